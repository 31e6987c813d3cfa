/* The sampled platoon in C: clock and policies; mirrors psp_model/platoon.py and sampling/loop.py. */
#ifndef PSP_PLATOON_H
#define PSP_PLATOON_H

#include "certificate.h"

/* What is told of a first vehicle that drives itself; all 0 where it is automated. */
typedef struct {
    int64_t driven;
    double speed, acceleration;
} Leader;

typedef struct {
    Constants constants;
    Weights weights;
    Shape shape;
    double T;
    int64_t policy, max_short_periods, certificate;
    double join_brake_margin, join_a_min;
    Cooperation cooperation; /* with the lengths of the vehicles in `now` */
    Leader leader;           /* as it was taken last */
    int64_t papers;          /* the law is the paper's: platoon_settle */
    Instant now;
} Platoon;

/* All of these are false on failure, which has been logged. */

/* platoon_law.c: the parameters of the extended law for n vehicles, and what is told of the leader, checked; notes whether
 * the law is the paper's; where it is not, the accelerations at an instant `since` [s] after the last, and T_max; T_exact for
 * the last instant; takes what is told of the leader, for the last instant on if the communication point is that one. */
bool read_cooperation(Front *front, const double *values, const Constants *constants, int n, Cooperation *taken);
bool read_leader(Front *front, const double *values, double v_max, Leader *leader);
void platoon_settle(Platoon *platoon);
double platoon_decide(Platoon *platoon, double since);
double platoon_exact(const Platoon *platoon);
bool platoon_take_leader(Platoon *platoon, Front *front, const double *values, bool here);

/* platoon_start.c: constants, weights, sampling and start from the parameters, checked; the potential is not chosen. */
bool platoon_read(Platoon *platoon, Front *front, const double *values, Request *request);

/* platoon_clock.c: the law and the certificate for the vehicles in `now`, `since` [s] after the last time; failures are
 * logged with `status`; all instants up to a
 * time; the platoon at a time, which is `now` or put into `scratch`.  Where an instant is refused `now` is that one and the
 * status fmi2Error; behind another one that was passed `now` is the last that was in order, and the status fmi2Discard. */
bool platoon_sample(Platoon *platoon, Front *front, double since, fmi2Status status);
fmi2Status platoon_advance(Platoon *platoon, Front *front, int64_t period, double fraction, Instant *scratch);
const Instant *platoon_observe(const Platoon *platoon, int64_t period, double fraction, Instant *scratch);

/* platoon_lemma1.c: says which vehicle keeps T from being certified. */
void platoon_log_violation(const Platoon *platoon, Front *front, fmi2Status status);

/* platoon_derivatives.c: what changes of parameters do to the outputs at the first instant. */
void platoon_tangent(const Platoon *platoon, const double *seed, double *change);

#endif
