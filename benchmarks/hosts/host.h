/* What the C hosts share: messages go to stderr, statuses other than OK end the program. */
#ifndef HOST_H
#define HOST_H

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"

static void message(fmi2ComponentEnvironment e, fmi2String n, fmi2Status status, fmi2String c, fmi2String format, ...)
{
    va_list arguments;
    (void)e, (void)n, (void)status, (void)c;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void must(fmi2Status status)
{
    if (status == fmi2OK) return;
    fprintf(stderr, "a call gave status %d\n", (int)status);
    exit(3);
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)

#endif
