/* What platoon and controller share: up to PSP_N vehicles, their motion, and the choice of the potential.  The formulas
 * are in psp_kernels.h, generated from the model; what is written by hand mirrors psp_model. */
#ifndef PSP_VEHICLES_H
#define PSP_VEHICLES_H

#include <stdbool.h>
#include <stdint.h>

#include "front.h"
#include "psp_model.h" /* generated: PSP_N, the table of variables, sentences, limits */

#define PSP_FIELD(field, variable, unit) double field;

/* The fields of psp_model's structs; PSP_..._FIELDS come from fmu_src/interface/meaning.py. */
typedef struct {
    PSP_CONSTANTS_FIELDS(PSP_FIELD)
} Constants;

typedef struct {
    PSP_WEIGHTS_FIELDS(PSP_FIELD)
} Weights;

typedef struct {
    PSP_TRIPLE_FIELDS(PSP_FIELD)
    double hill;
} Shape;

/* What the loop knows at a sampling instant; the time is (period + fraction) T. */
typedef struct {
    int64_t period, violations, n; /* n vehicles; the places behind them hold nothing */
    double fraction, span;         /* [sampling periods] */
    double x, T_max, cost_acceleration, cost_spacings;
    double bound;           /* what T has to be below, by the chosen certificate */
    int64_t driven;         /* whether a[0] is that of a leader that drives itself */
    double s[PSP_N - 1], v[PSP_N], a[PSP_N];
    double closing[PSP_N];  /* what closing up adds to the desired speeds; outputs do not look at it */
} Instant;

/* For whom a potential is wanted, and how it is to be chosen (psp_model/selection/selectors.py). */
typedef struct {
    int n;               /* vehicles, 1 to PSP_N */
    const double *s, *v; /* spacings and speeds, leader first */
    double x;            /* of the leader */
    bool old;
    int source, rollouts;
    double horizon;
    Shape fixed;
    bool quiet; /* does not warn of the fallback */
} Request;

enum { SOURCE_NETWORK = 1, SOURCE_FIXED = 2, SOURCE_ROLLOUT = 3 };
enum { POLICY_ERROR = 1, POLICY_WARN = 2, POLICY_SHORTEN = 3 }; /* the controller does not shorten */

#define TIME_TOLERANCE 1e-6 /* [sampling periods] as in psp_model/sampling/clock.py */
#define PERIODS_MAX 9e15    /* more sampling periods cannot be told apart */
#define LONGEST 1e9         /* [s] T_max of a lone vehicle at rest with v_star is infinite, which importers do not like */

/* Whatever is bool below is false on failure, which has been logged. */

/* Logs a sentence that takes the value and perhaps a limit, and fails, unless `holds`. */
#define REQUIRE(holds, ...)                                                                                            \
    do {                                                                                                               \
        if (!(holds)) {                                                                                                \
            front_log(front, fmi2Error, __VA_ARGS__);                                                                  \
            return false;                                                                                              \
        }                                                                                                              \
    } while (0)

/* motion.c: the accelerations of n vehicles, and T_max (returned), with the desired speed v_star or another one; T_max
 * for given accelerations; what a time tau makes of an instant; time as whole periods and a fraction. */
double feedback(const Constants *constants, const Shape *shape, int n, const double *s, const double *v, double *a);
double feedback_towards(const Constants *constants, const Shape *shape, int n, const double *s, const double *v,
                        double v_desired, double *a);
double largest_period(const Constants *constants, int n, const double *s, const double *v, const double *a);
void pass_time(const Weights *weights, Instant *at, double tau);
double locate(double time, double T, double *fraction);

/* checks.c: a number as every C library prints it, without the sign of a NaN; a number, or one of an array, that has to be
 * finite; the sampling period; the start of n vehicles. */
double printable(double value);
bool finite_or_log(Front *front, const char *name, double value, const char *unit);
bool finite_element(Front *front, const char *name, int vehicle, double value, const char *unit);
bool read_period(Front *front, const double *values, double *T);
bool check_start(Front *front, int n, double x, const double *s, const double *v, const double *length, double L,
                 double v_max);

/* parameters.c: constants, weights and the choice of the potential from the values of the variables, checked. */
bool finite_triple(Front *front, const Shape *shape);
bool read_choice(Front *front, const char *name, double value, int low, int high, int *chosen); /* high < low: none */
bool read_constants(Front *front, const double *values, Constants *constants);
bool read_weights(Front *front, const double *values, Weights *weights);
bool read_request(Front *front, const double *values, Request *request); /* leaves n, s, v and x alone */

/* feasible.c */
bool require_feasible(Front *front, const Shape *shape, const Constants *constants);
bool project(Front *front, Shape *shape, const Constants *constants);

/* network.c: whether there is a network for n vehicles; its answer first, then the triples it ranks highest, and
 * how many there are; NULL, or why the network's answer does not hold for a start; whether there is one and it does. */
bool network_for(int n);
int network_candidates(int n, const double *s, const double *v, int count, Shape *candidates);
const char *outside_domain(int n, const double *s, const double *v, const Constants *constants);
bool lies_in_domain(int n, const double *s, const double *v, const Constants *constants);

/* choice.c: the potential for the vehicles of the request; the warning that a quiet choice kept to itself. */
bool choose_shape(Front *front, const Constants *constants, const Weights *weights, double T, const Request *request,
                  Shape *shape);
void warn_of_fallback(Front *front, const Constants *constants, const Request *request);

#endif
