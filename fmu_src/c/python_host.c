#ifndef _WIN32
#define _GNU_SOURCE /* dladdr */
#endif

#include "python_host.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#ifndef _WIN32
#include <dlfcn.h>
#endif

#define PSP_INTERRUPTION "_psp_interruption" /* attributes of sys */
#define PSP_GENERATION "_psp_generation"

typedef void *Object;

/* The functions of Python's stable interface that are used here; all FMUs of the process share what they do. */
static struct {
    int (*Py_IsInitialized)(void);
    int (*PyGILState_Ensure)(void);
    void (*PyGILState_Release)(int);
    unsigned long (*PyThread_get_thread_ident)(void);
    int (*PyErr_CheckSignals)(void);
    void (*PyErr_Fetch)(Object *, Object *, Object *);
    void (*PyErr_Restore)(Object, Object, Object);
    void (*PyErr_SetObject)(Object, Object);
    void (*PyErr_Clear)(void);
    int (*Py_AddPendingCall)(int (*)(void *), void *);
    int (*PyThreadState_SetAsyncExc)(unsigned long, Object);
    Object (*PySys_GetObject)(const char *);
    int (*PySys_SetObject)(const char *, Object);
    Object (*PyObject_Type)(Object);
    Object (*PyObject_GetAttrString)(Object, const char *);
    Object (*PyImport_ImportModule)(const char *);
    unsigned long (*PyLong_AsUnsignedLong)(Object);
    Object (*PyLong_FromVoidPtr)(void *);
    void *(*PyLong_AsVoidPtr)(Object);
    const char *(*PyUnicode_AsUTF8AndSize)(Object, ptrdiff_t *);
    Object (*PyList_GetItem)(Object, ptrdiff_t);
    ptrdiff_t (*PyList_Size)(Object);
    int (*PySequence_DelItem)(Object, ptrdiff_t);
    int (*PyDict_DelItemString)(Object, const char *);
    void (*Py_DecRef)(Object);
    int (*Py_IsFinalizing)(void); /* NULL where Python does not say */
} py;

bool python_functions(void)
{
    bool found = true;
#define FIND(name) found = library_function(NULL, #name, &py.name) && found
    FIND(Py_IsInitialized); FIND(PyGILState_Ensure); FIND(PyGILState_Release); FIND(PyThread_get_thread_ident);
    FIND(PyErr_CheckSignals); FIND(PyErr_Fetch); FIND(PyErr_Restore); FIND(PyErr_SetObject); FIND(PyErr_Clear);
    FIND(Py_AddPendingCall); FIND(PyThreadState_SetAsyncExc); FIND(PySys_GetObject); FIND(PySys_SetObject);
    FIND(PyObject_Type); FIND(PyObject_GetAttrString); FIND(PyImport_ImportModule); FIND(PyLong_AsUnsignedLong);
    FIND(PyLong_FromVoidPtr); FIND(PyLong_AsVoidPtr); FIND(PyUnicode_AsUTF8AndSize); FIND(PyList_GetItem);
    FIND(PyList_Size); FIND(PySequence_DelItem); FIND(PyDict_DelItemString); FIND(Py_DecRef);
#undef FIND
    if (!library_function(NULL, "Py_IsFinalizing", &py.Py_IsFinalizing)) /* Python 3.13 and later */
        library_function(NULL, "_Py_IsFinalizing", &py.Py_IsFinalizing);
    return found;
}

/* Signals ---------------------------------------------------------------------------------------------------- */

/* Those for which hosts in Python are known to have handlers that raise. */
#ifdef _WIN32
static const int SIGNALS[] = {SIGINT};
#else
static const int SIGNALS[] = {SIGINT, SIGTERM, SIGALRM, SIGHUP, SIGUSR1, SIGUSR2};
#endif
enum { SIGNAL_COUNT = sizeof SIGNALS / sizeof SIGNALS[0] };

#ifdef _WIN32
typedef void (*Handler)(int);
#else
typedef struct sigaction Handler;
#endif

/* The process has one handler per signal, and only Python's main thread runs what they lead to and changes them here. */
static volatile sig_atomic_t arrived[SIGNAL_COUNT];
static Handler kept[SIGNAL_COUNT];
static unsigned handled;          /* bit per signal that the host handles in Python */
static unsigned long main_thread; /* Python's */

static void note(int number)
{
    for (int k = 0; k < SIGNAL_COUNT; k++)
        if (SIGNALS[k] == number) arrived[k] = 1;
#ifdef _WIN32
    signal(number, note); /* which a delivery undoes */
#endif
}

#ifdef _WIN32
static bool pythons(int number)
{
    Handler handler = signal(number, SIG_DFL);
    signal(number, handler);
    return handler != SIG_DFL && handler != SIG_IGN && handler != SIG_ERR;
}

static Handler put(int number, const Handler *handler) { return signal(number, handler ? *handler : note); }
static bool is_note(const Handler *handler) { return *handler == note; }
#else
/* Whether Python would handle the signal: its handler lies in the library that Python's other functions lie in. */
static bool pythons(int number)
{
    static void (*known)(int) = NULL; /* Python has one handler for all signals */
    struct sigaction action;
    Dl_info python, of_handler;
    void *address, *function;
    if (sigaction(number, NULL, &action) || action.sa_handler == SIG_DFL || action.sa_handler == SIG_IGN) return false;
    if (action.sa_handler == note || action.sa_handler == known) return true;
    memcpy(&address, &action.sa_handler, sizeof address);
    memcpy(&function, &py.Py_IsInitialized, sizeof function);
    if (!dladdr(function, &python) || !dladdr(address, &of_handler) || python.dli_fbase != of_handler.dli_fbase) return false;
    known = action.sa_handler;
    return true;
}

static Handler put(int number, const Handler *handler)
{
    Handler before, ours = {.sa_handler = note, .sa_flags = SA_ONSTACK};
    sigaction(number, handler ? handler : &ours, &before);
    return before;
}

static bool is_note(const Handler *handler) { return handler->sa_handler == note; }
#endif

/* Reads threading.main_thread().ident without running a line of Python, in which a signal could be handled. */
static unsigned long find_main_thread(void)
{
    Object threading = py.PyImport_ImportModule("threading");
    Object thread = threading ? py.PyObject_GetAttrString(threading, "_main_thread") : NULL;
    Object ident = thread ? py.PyObject_GetAttrString(thread, "_ident") : NULL;
    const unsigned long found = ident ? py.PyLong_AsUnsignedLong(ident) : 0;
    py.PyErr_Clear();
    py.Py_DecRef(ident), py.Py_DecRef(thread), py.Py_DecRef(threading);
    return found;
}

static void look_at_signals(void)
{
    unsigned found = 0;
    for (int k = 0; k < SIGNAL_COUNT; k++)
        if (pythons(SIGNALS[k])) found |= 1u << k;
    if (found && !main_thread) main_thread = find_main_thread();
    handled = found;
}

static void hold_signals(PythonCall *call)
{
    if (!handled || py.PyThread_get_thread_ident() != main_thread) return;
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        if (!(handled & 1u << k)) continue;
        const Handler before = put(SIGNALS[k], NULL);
        if (is_note(&before)) continue; /* a call inside a call, made by a logger */
        kept[k] = before;
        call->held |= 1u << k;
    }
    if (call->held && py.PyErr_CheckSignals()) /* one that came just before */
        py.PyErr_Fetch(&call->exception[0], &call->exception[1], &call->exception[2]);
}

static void release_signals(const PythonCall *call)
{
    for (int k = 0; k < SIGNAL_COUNT; k++) {
        if (!(call->held & 1u << k)) continue;
        const Handler before = put(SIGNALS[k], &kept[k]);
        if (!is_note(&before)) put(SIGNALS[k], &before); /* changed by a logger */
        if (!arrived[k]) continue;
        arrived[k] = 0;
        raise(SIGNALS[k]);
    }
}

/* Calls ------------------------------------------------------------------------------------------------------ */

static int raise_in_host(void *kept_exception)
{
    Object *exception = kept_exception;
    py.PyErr_Restore(exception[0], exception[1], exception[2]);
    free(exception);
    return -1;
}

/* Lets the host's code get an exception at its next instruction. */
static void hand_over(Object exception[3])
{
    const unsigned long here = py.PyThread_get_thread_ident();
    Object *copy = here == main_thread ? malloc(3 * sizeof *copy) : NULL;
    if (copy) memcpy(copy, exception, 3 * sizeof *copy);
    if (copy && py.Py_AddPendingCall(raise_in_host, copy) == 0) return;
    free(copy);
    py.PyThreadState_SetAsyncExc(here, exception[0]); /* another thread's, or too many are pending: its type must do */
    for (int i = 0; i < 3; i++) py.Py_DecRef(exception[i]);
}

/* What the slave caught and could not handle; see `logged` in table_slave.py. */
static void take_interruption(Object exception[3])
{
    Object found = py.PySys_GetObject(PSP_INTERRUPTION);
    Object type = found ? py.PyObject_Type(found) : NULL;
    if (!type) return;
    py.PyErr_SetObject(type, found);
    py.PyErr_Fetch(&exception[0], &exception[1], &exception[2]);
    py.PySys_SetObject(PSP_INTERRUPTION, NULL);
    py.Py_DecRef(type);
}

bool python_enter(PythonCall *call, bool look)
{
    const PythonCall none = {0, 0, {NULL, NULL, NULL}};
    *call = none;
    if (!py.Py_IsInitialized() || (py.Py_IsFinalizing && py.Py_IsFinalizing())) return false;
    call->lock = py.PyGILState_Ensure();
    if (look) look_at_signals();
    hold_signals(call);
    return true;
}

void python_leave(PythonCall *call, bool failed)
{
    if (failed && !call->exception[0]) take_interruption(call->exception);
    if (call->exception[0]) hand_over(call->exception);
    release_signals(call);
    py.PyGILState_Release(call->lock);
}

/* What is kept in sys ---------------------------------------------------------------------------------------- */

void *python_recall(const char *name)
{
    Object found = py.PySys_GetObject(name);
    void *pointer = found ? py.PyLong_AsVoidPtr(found) : NULL;
    py.PyErr_Clear();
    return pointer;
}

void python_remember(const char *name, void *pointer)
{
    Object number = py.PyLong_FromVoidPtr(pointer);
    if (number) py.PySys_SetObject(name, number);
    py.PyErr_Clear();
    py.Py_DecRef(number);
}

void *python_generation(void)
{
    void *number = python_recall(PSP_GENERATION);
    if (number) return number;
    number = malloc(1); /* never given back, so that no later one is the same */
    python_remember(PSP_GENERATION, number);
    return number;
}

void python_forget_path(const char *path)
{
    Object paths = py.PySys_GetObject("path"), finders = py.PySys_GetObject("path_importer_cache");
    const ptrdiff_t count = paths ? py.PyList_Size(paths) : 0;
    for (ptrdiff_t i = 0; i < count; i++) {
        Object entry = py.PyList_GetItem(paths, i);
        const char *text = entry ? py.PyUnicode_AsUTF8AndSize(entry, NULL) : NULL;
        if (!text || strcmp(text, path) != 0) continue;
        py.PySequence_DelItem(paths, i);
        break;
    }
    py.PyErr_Clear();
    if (finders) py.PyDict_DelItemString(finders, path);
    py.PyErr_Clear();
}
