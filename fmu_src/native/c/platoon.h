/* The sampled platoon in C: clock and policies; mirrors psp_model/platoon.py and sampling/loop.py. */
#ifndef PSP_PLATOON_H
#define PSP_PLATOON_H

#include "vehicles.h"

typedef struct {
    Constants constants;
    Weights weights;
    Shape shape;
    double T;
    int64_t policy, max_short_periods;
    Instant now;
} Platoon;

/* All of these are false on failure, which has been logged. */

/* platoon_start.c: constants, weights, sampling and start from the parameters, checked; the potential is not chosen. */
bool platoon_read(Platoon *platoon, Front *front, const double *values, Request *request);

/* platoon_clock.c: feedback and Lemma 1 for the vehicles in `now`, failures logged with `status`; all instants up to a
 * time; the platoon at a time, which is `now` or put into `scratch`.  Where an instant is refused `now` is that one and the
 * status fmi2Error; behind another one that was passed `now` is the last that was in order, and the status fmi2Discard. */
bool platoon_sample(Platoon *platoon, Front *front, fmi2Status status);
fmi2Status platoon_advance(Platoon *platoon, Front *front, int64_t period, double fraction, Instant *scratch);
const Instant *platoon_observe(const Platoon *platoon, int64_t period, double fraction, Instant *scratch);

/* platoon_lemma1.c: says which vehicle keeps T from being certified. */
void platoon_log_violation(const Platoon *platoon, Front *front, fmi2Status status);

/* platoon_derivatives.c: what changes of parameters do to the outputs at the first instant. */
void platoon_tangent(const Platoon *platoon, const double *seed, double *change);

#endif
