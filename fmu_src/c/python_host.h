/* What the launcher asks of the Python that runs in the host's process.
 *
 * A call into the slave belongs between python_enter and python_leave.  In between Python's lock is held, and what Python
 * would do about a signal waits: an exception like KeyboardInterrupt in the middle of a step would leave half a step.
 * It is raised in the host, as soon as that goes on.
 */
#ifndef PSP_PYTHON_HOST_H
#define PSP_PYTHON_HOST_H

#include <stdbool.h>
#include <stddef.h>

#include "names.h"

typedef struct {
    int lock;           /* PyGILState_STATE */
    unsigned held;      /* bit per signal that waits */
    void *exception[3]; /* what a signal's handler raised before the call began: type, value, traceback */
} PythonCall;

/* Finds the functions used here; false if one is missing.  Python must run. */
bool python_functions(void);

/* False if Python has ended, or is about to: nothing of it may be touched any more.
 * `look`: find out anew which signals the host handles in Python; for calls that take long enough anyway. */
bool python_enter(PythonCall *call, bool look);

/* `failed`: the slave reported a failure, which may be an exception that belongs to the host. */
void python_leave(PythonCall *call, bool failed);

/* Between python_enter and python_leave --------------------------------------------------------------------- */

/* A pointer that is kept under a name for as long as Python runs, by all launchers in the process; NULL if there is none. */
void *python_recall(const char *name);
void python_remember(const char *name, void *pointer);

/* A number that is another one once Python has ended and was started anew: what was made before must not be touched. */
void *python_generation(void);

/* Takes one entry of that path out of sys.path again. */
void python_forget_path(const char *path);

#endif
