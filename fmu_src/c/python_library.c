/* Finds the Python that a host without one should load, loads it, and starts it.
 *
 * The library is the one that the environment variable PSP_LIBPYTHON names, else that of the first Python on PATH.
 * Python is started here and not by pythonfmu's library, because pythonfmu would take over the host's Ctrl-C and would
 * finalize Python when the host unloads the FMU, which numpy does not survive.
 */
#include "python_library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>

#include "library.h"
#include "python_question.h"

#ifdef _WIN32
#define PYTHON "python"
#else
#define PYTHON "python3"
#endif
#define OLDEST 11 /* of Python 3 */

#define REMEDY                                                                                                         \
    "put a 64-bit Python 3.11 or newer that has numpy and onnxruntime first on PATH, or name its shared library in "   \
    "the environment variable PSP_LIBPYTHON, or use the native FMU, which needs no Python"

static const char *const VARIABLES[] = {"PYTHONHOME", "PYTHONPATH", "PYTHONPLATLIBDIR"};
enum { VARIABLE_COUNT = 3 };

static bool is_set(const char *name)
{
    const char *value = getenv(name);
    return value && value[0] != '\0';
}

/* Why the Python on PATH does not answer: one of the environment variables that mislead it, if it answers without. */
static void blame(Front *front, const Answer *answer)
{
    for (int k = 0; k < VARIABLE_COUNT; k++) {
        if (!is_set(VARIABLES[k])) continue;
        const Answer other = ask_python_on_path(VARIABLES[k]);
        if (!answered(&other)) continue;
        front_fail(front, "Python does not start with the environment variable %s = %.300s (%.300s): unset it, %s starts "
                          "without, or use the native FMU, which needs no Python",
                   VARIABLES[k], getenv(VARIABLES[k]), answer->said, other.executable);
        return;
    }
    front_fail(front, "the %s on PATH does not start (%.300s): " REMEDY, PYTHON, answer->said);
}

/* True if the Python on PATH can serve; else why not is logged. */
static bool serves(Front *front, const Answer *answer)
{
    int minor = 0;
    if (!answer->found)
        front_fail(front, "the host has no Python and there is no %s on PATH: " REMEDY, PYTHON);
    else if (!answered(answer))
        blame(front, answer);
    else if (sscanf(answer->version, "3.%d", &minor) != 1 || minor < OLDEST)
        front_fail(front, "the Python on PATH, %s, is %s, and 3.%d or newer is needed: " REMEDY, answer->executable,
                   answer->version, OLDEST);
    else if (strcmp(answer->bits, "64") != 0)
        front_fail(front, "the Python on PATH, %s, has %s bits, and 64 are needed: " REMEDY, answer->executable,
                   answer->bits);
    else if (answer->library[0] == '\0')
        front_fail(front, "the Python on PATH, %s, has no shared library that could be loaded: install it (Debian: "
                          "libpython3.%d), or " REMEDY, answer->executable, minor);
    else
        return true;
    return false;
}

/* Loads libpython for good; NULL if that fails, which is logged. */
static void *load(Front *front, const Answer *answer)
{
    char why[512];
    const char *path = is_set("PSP_LIBPYTHON") ? getenv("PSP_LIBPYTHON") : answer->library;
    if (!is_set("PSP_LIBPYTHON") && !serves(front, answer)) return NULL;
    void *library = library_open(path, true);
    if (!library)
        front_fail(front, "Python's library %s cannot be loaded (%s): " REMEDY, path, library_error(why, sizeof why));
    return library;
}

/* Python's PyStatus and the beginning of its PyConfig, the same from Python 3.8 on. */
typedef struct {
    int kind; /* 0: all is well */
    const char *function, *message;
    int exit_code;
} Outcome;

typedef struct {
    int kind, isolated, use_environment, dev_mode, install_signal_handlers;
} ConfigHead;

typedef union {
    ConfigHead head;
    void *aligned;
    char room[1 << 14]; /* many times what any PyConfig needs */
} Config;

/* Starts Python without its signal handlers; NULL, or what it says against it.  Py_InitializeEx would end the process. */
static const char *initialize(void *library)
{
    static Config config; /* its strings are not given back */
    void (*prepare)(void *) = NULL;
    Outcome (*start)(const void *) = NULL;
    void (*start_or_exit)(int) = NULL;
#ifndef _WIN32 /* there PyConfig_InitPythonConfig would turn the host's standard streams into binary ones */
    if (library_function(library, "PyConfig_InitPythonConfig", &prepare) &&
        library_function(library, "Py_InitializeFromConfig", &start)) {
        prepare(&config);
        config.head.install_signal_handlers = 0;
        const Outcome outcome = start(&config);
        if (outcome.kind == 0) return NULL;
        return outcome.message ? outcome.message : "it wants to exit";
    }
#else
    (void)config, (void)prepare, (void)start;
#endif
    if (!library_function(library, "Py_InitializeEx", &start_or_exit)) return "it lacks Py_InitializeEx";
    start_or_exit(0);
    return NULL;
}

/* Starts Python as the Python on PATH would start, so that it finds its packages, those of a virtual environment too. */
static bool start(Front *front, void *library, const Answer *answer)
{
    wchar_t *(*decode)(const char *, size_t *);
    void (*set_program_name)(const wchar_t *); /* deprecated since Python 3.11, but still there */
    void *(*release)(void);
    if (answer->executable[0] && library_function(library, "Py_DecodeLocale", &decode) &&
        library_function(library, "Py_SetProgramName", &set_program_name)) {
        wchar_t *name = decode(answer->executable, NULL); /* Python keeps the pointer */
        if (name) set_program_name(name);
    }
    const char *why = initialize(library);
    if (why) {
        const char *named = is_set("PYTHONHOME") ? "PYTHONHOME" : "PYTHONPATH";
        front_fail(front, "Python does not start (%.300s) with the environment variable %s = %.300s: correct or unset it, "
                          "start the host anew, or " REMEDY, why, named, is_set(named) ? getenv(named) : "(unset)");
        return false;
    }
    if (library_function(library, "PyEval_SaveThread", &release)) release();
    return true;
}

static bool new_enough(Front *front, void *library)
{
    const char *(*version)(void);
    int minor = 0;
    if (library_function(library, "Py_GetVersion", &version) && sscanf(version(), "3.%d", &minor) == 1 && minor >= OLDEST)
        return true;
    front_fail(front, "the Python in this process is 3.%d, and 3.%d or newer is needed: " REMEDY, minor, OLDEST);
    return false;
}

bool python_is_running(Front *front)
{
    int (*is_initialized)(void);
    void *library = NULL;
    if (library_function(NULL, "Py_IsInitialized", &is_initialized) && is_initialized()) return new_enough(front, NULL);
    const Answer answer = ask_python_on_path(NULL);
    if (!library_function(NULL, "Py_IsInitialized", &is_initialized)) {
        library = load(front, &answer);
        if (!library) return false;
        if (!library_function(library, "Py_IsInitialized", &is_initialized)) {
            front_fail(front, "the library that PSP_LIBPYTHON names is not Python's: " REMEDY);
            return false;
        }
    }
    if (!new_enough(front, library)) return false;
    return is_initialized() || start(front, library, &answer);
}
