/* Finds the Python that a host without one should load, loads it, and starts it.
 *
 * The library is the one that the environment variable PSP_LIBPYTHON names, else that of the first Python on PATH.
 * Python is started here and not by pythonfmu's library, because pythonfmu would take over the host's Ctrl-C and would
 * finalize Python when the host unloads the FMU, which numpy does not survive.
 */
#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#endif

#include "python_library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>

#include "library.h"

#ifdef _WIN32
#define popen _popen
#define pclose _pclose
#define PYTHON "python"
#define NO_MESSAGES " 2>NUL"
#define FIND_LIBRARY "c=[sys.base_prefix+'/python3.dll'];"
#else
#define PYTHON "python3"
#define NO_MESSAGES " 2>/dev/null"
#define FIND_LIBRARY                                                                                                   \
    "g=sysconfig.get_config_var;d=g('LIBDIR') or '';n='libpython'+sysconfig.get_python_version();"                     \
    "c=[p+'/'+f for p in (d,d+'/'+(g('MULTIARCH') or ''),sys.base_prefix+'/lib')"                                      \
    " for f in (g('INSTSONAME') or n,n+'.so.1.0',n+'.so') if '.so' in f];"
#endif

/* Prints its executable, and its library if it has one. */
#define QUESTION                                                                                                       \
    PYTHON " -c \"import os,sys,sysconfig;" FIND_LIBRARY                                                               \
           "print(sys.executable);print(next(filter(os.path.isfile,c),''))\"" NO_MESSAGES

#define REMEDY                                                                                                         \
    "put a Python 3.11 or newer that has numpy and onnxruntime first on PATH, or name its shared library in the "      \
    "environment variable PSP_LIBPYTHON, or use the native FMU, which needs no Python"

typedef struct {
    char executable[1024];
    char library[1024];
} Answer;

static void read_line(FILE *stream, char *line, int size)
{
    line[0] = '\0';
    if (fgets(line, size, stream)) line[strcspn(line, "\r\n")] = '\0';
}

static Answer ask_python_on_path(void)
{
    Answer answer = {"", ""};
    FILE *stream = popen(QUESTION, "r");
    if (!stream) return answer;
    read_line(stream, answer.executable, sizeof answer.executable);
    read_line(stream, answer.library, sizeof answer.library);
    pclose(stream);
    return answer;
}

/* Loads libpython for good; NULL if that fails, which is logged. */
static void *load(Front *front, const Answer *answer)
{
    char why[512];
    const char *chosen = getenv("PSP_LIBPYTHON");
    if (chosen && chosen[0] == '\0') chosen = NULL;
    if (!chosen && answer->executable[0] == '\0') {
        front_fail(front, "the host has no Python and there is no %s on PATH: " REMEDY, PYTHON);
        return NULL;
    }
    if (!chosen && answer->library[0] == '\0') {
        front_fail(front, "the Python on PATH, %s, has no shared library that could be loaded: install it (Debian: "
                          "libpython3.x), or " REMEDY, answer->executable);
        return NULL;
    }
    void *library = library_open(chosen ? chosen : answer->library, true);
    if (!library)
        front_fail(front, "Python's library %s cannot be loaded (%s): " REMEDY, chosen ? chosen : answer->library,
                   library_error(why, sizeof why));
    return library;
}

/* Starts Python as the Python on PATH would start, so that it finds its packages, those of a virtual environment too. */
static void start(void *library, const Answer *answer)
{
    wchar_t *(*decode)(const char *, size_t *);
    void (*set_program_name)(const wchar_t *); /* deprecated since Python 3.11, but still there */
    void (*initialize)(int);
    void *(*release)(void);
    if (answer->executable[0] && library_function(library, "Py_DecodeLocale", &decode) &&
        library_function(library, "Py_SetProgramName", &set_program_name)) {
        wchar_t *name = decode(answer->executable, NULL); /* Python keeps the pointer */
        if (name) set_program_name(name);
    }
    if (library_function(library, "Py_InitializeEx", &initialize) && library_function(library, "PyEval_SaveThread", &release)) {
        initialize(0); /* 0: the host's signal handlers stay */
        release();
    }
}

bool python_is_running(Front *front)
{
    int (*is_initialized)(void);
    void *library = NULL;
    if (library_function(NULL, "Py_IsInitialized", &is_initialized) && is_initialized()) return true;
    const Answer answer = ask_python_on_path();
    if (!library_function(NULL, "Py_IsInitialized", &is_initialized)) {
        library = load(front, &answer);
        if (!library) return false;
        if (!library_function(library, "Py_IsInitialized", &is_initialized)) {
            front_fail(front, "the library that PSP_LIBPYTHON names is not Python's: " REMEDY);
            return false;
        }
    }
    if (!is_initialized()) start(library, &answer);
    return true;
}
