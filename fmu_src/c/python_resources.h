/* What the launcher reads from the resources of the FMU. */
#ifndef PSP_PYTHON_RESOURCES_H
#define PSP_PYTHON_RESOURCES_H

#include "front.h"

/* The first line of a file in resources, "" if there is none. */
const char *first_line(const char *resources, const char *name, char *buffer, size_t size);

/* A path that pythonfmu, which knows no Unicode on Windows, can open too: the short form of one that is not ASCII. */
const char *openable(const char *resources, char *buffer, size_t size);

/* pythonfmu crashes on resources that it cannot read: true if it can, else why not is logged. */
bool readable(Front *front, const char *resources);

/* pythonfmu's library of this FMU, which stays loaded for good; NULL if it cannot be loaded, which is logged.  Every archive
 * that is extracted brings a copy of its own: of those that are alike one is loaded.  Between python_enter and python_leave. */
void *open_pythonfmu(Front *front, const char *resources);

#endif
