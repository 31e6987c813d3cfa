/* The sampled platoon in C: clock, policies, choice of the potential.  The formulas are in psp_kernels.h, generated from
 * the model; what is written by hand mirrors psp_model/platoon.py, feasible.py, choose.py and rollout.py. */
#ifndef PSP_PLATOON_H
#define PSP_PLATOON_H

#include <stdbool.h>
#include <stdint.h>

#include "front.h"
#include "psp_model.h" /* generated: PSP_N, the table of variables, sentences, network */

typedef struct {
    double L, lam, v_star, v_max, epsilon, mu, z;
} Constants;

typedef struct {
    double w1, w2, a_ref, s_ref;
} Weights;

typedef struct {
    double alpha, r, p, hill;
} Shape;

/* What the loop knows at a sampling instant; the time is (period + fraction) T. */
typedef struct {
    int64_t period, violations;
    double fraction, span; /* [sampling periods] */
    double x, T_max, cost_acceleration, cost_gaps;
    double s[PSP_N - 1], v[PSP_N], a[PSP_N];
} Instant;

typedef struct {
    Constants constants;
    Weights weights;
    Shape shape;
    double T;
    int64_t policy, max_short_periods;
    Instant now;
} Platoon;

enum { POLICY_ERROR = 1, POLICY_WARN = 2, POLICY_SHORTEN = 3 };

#define TIME_TOLERANCE 1e-6 /* [sampling periods] as in psp_model/platoon.py */
#define PERIODS_MAX 9e15    /* more sampling periods cannot be told apart */

/* Everything a start asks for, read from the parameters (platoon_choice.c). */
typedef struct {
    const double *s, *v; /* initial gaps and speeds */
    double x;
    bool old;
    int source, rollouts;
    double horizon;
    Shape fixed;
} Request;

/* All of these are false on failure, which has been logged. */

/* platoon_clock.c: accelerations and T_max at the instant; what a time tau makes of it; time as whole periods and a
 * fraction; the first instant; all instants up to a time. */
void platoon_feedback(const Platoon *platoon, Instant *at);
void platoon_pass(const Platoon *platoon, Instant *at, double tau);
double platoon_locate(double time, double T, double *fraction);
bool platoon_start(Platoon *platoon, Front *front);
bool platoon_advance(Platoon *platoon, Front *front, int64_t period, double fraction);

/* platoon_lemma1.c: says which vehicle keeps T from being certified. */
void platoon_log_violation(const Platoon *platoon, Front *front, fmi2Status status);

/* platoon_feasible.c */
bool require_feasible(Front *front, const Shape *shape, const Constants *constants);
bool project(Front *front, Shape *shape, const Constants *constants);

/* platoon_network.c: the network's answer first, then the triples it ranks highest; how many there are. */
int network_candidates(const double *s, const double *v, int count, Shape *candidates);
/* NULL, or why the network's answer does not hold for a start. */
const char *outside_domain(const double *s, const double *v, const Constants *constants);

/* platoon_choice.c: constants, weights, sampling and start from the parameters, checked; the potential for them. */
bool platoon_read(Platoon *platoon, Front *front, const double *values, Request *request);
bool platoon_choose(Platoon *platoon, Front *front, const Request *request);

/* platoon_derivatives.c: what changes of parameters do to the outputs at the first instant. */
void platoon_tangent(const Platoon *platoon, const double *seed, double *change);

#endif
