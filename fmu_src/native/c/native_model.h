/* What an instance of the native FMU holds. */
#ifndef PSP_NATIVE_MODEL_H
#define PSP_NATIVE_MODEL_H

#include "platoon.h"

/* The whole state of an instance; a saved state is a copy of it. */
typedef struct {
    double values[PSP_COUNT]; /* by value reference: parameters as set, outputs as last computed */
    double start_time;        /* [s] */
    double in_domain;
    int32_t initialising, has_platoon;
    int32_t stale; /* the outputs in values lag behind the platoon */
    int32_t unused;
    int64_t period; /* the communication point as whole sampling periods and a fraction */
    double fraction;
    Platoon platoon;
} Model;

struct Backend {
    Front *front;
    Model model;
    Instant between; /* what outputs between two sampling instants are computed in: no room on a stack for many vehicles */
};

extern const char *const PSP_VARIABLE_NAMES[PSP_COUNT];

/* Makes the platoon that the parameters describe; false on failure, which has been logged. */
bool native_initialise(Backend *backend);

/* Writes all outputs, in the order of their references; there must be a platoon. */
void native_put_out(Backend *backend, double *outputs);

/* Brings the outputs in `values` up to date; false on failure, which has been logged. */
bool native_refresh(Backend *backend);

static inline bool native_is_integer(fmi2ValueReference reference)
{
    return reference - PSP_FIRST_INTEGER < PSP_INTEGER_COUNT;
}

#endif
