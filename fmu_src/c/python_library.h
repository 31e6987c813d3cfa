/* Python for hosts that have none in their process. */
#ifndef PSP_PYTHON_LIBRARY_H
#define PSP_PYTHON_LIBRARY_H

#include "front.h"

/* Makes sure that Python's functions can be found and that Python runs, starting it if the host has not.
 * False, with one sentence logged, if this machine has no Python that could be loaded. */
bool python_is_running(Front *front);

#endif
