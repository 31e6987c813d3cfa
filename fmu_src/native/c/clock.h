/* How far the sampling has come, from the communication steps of any master: mirrors
 * psp_model/sampling/clock.py, which says why. */
#ifndef PSP_CLOCK_H
#define PSP_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "names.h"

/* (period + offset) T since the first sampling instant; instants are at whole numbers. */
typedef struct {
    double first;   /* the first sampling instant as the master has it [s] */
    double time;    /* the last communication point as the master has it [s] */
    int64_t period; /* the nearest sampling instant */
    double offset;  /* how far behind it the communication point is [sampling periods] */
    double last;    /* size of the last step [s] */
    double doubt;   /* what the steps may have drifted since the last instant that was met [sampling periods] */
} Clock;

void clock_begin(Clock *clock, double start, double phase, double T);

/* Passes a communication step; false, and the clock as it was, where that is more sampling periods than can be counted. */
bool clock_pass(Clock *clock, double begin, double size, double T);

/* The communication point as whole sampling periods since the first instant and a fraction in [0, 1). */
int64_t clock_at(const Clock *clock, double *fraction);

/* Whether a clock that was read from bytes can be one. */
bool clock_can_be(const Clock *clock);
bool clock_is_fresh(const Clock *clock); /* no step has been passed yet */

/* A sampling instant as the master has it [s]; how far an age may be off because of the master's rounding [s]. */
double clock_time_of(const Clock *clock, int64_t instant, double T);
double clock_age_rounding(const Clock *clock, double age, double T);

#endif
