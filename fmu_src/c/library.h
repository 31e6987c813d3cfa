/* Shared libraries, on POSIX and on Windows. */
#ifndef PSP_LIBRARY_H
#define PSP_LIBRARY_H

#include <stdbool.h>
#include <stddef.h>

#include "names.h"

/* The library at `path`, or NULL; its symbols are everybody's if `global` (POSIX only). */
void *library_open(const char *path, bool global);

/* Puts the address of the function `name` into the function pointer at `function`; false if there is none.
 * A NULL library stands for what the process has loaded already. */
bool library_function(void *library, const char *name, void *function);

/* Why the last call failed, one line. */
const char *library_error(char *buffer, size_t size);

#endif
