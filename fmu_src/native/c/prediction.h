/* Where the vehicles will be when the next command takes effect, and the law there. */
#ifndef PSP_PREDICTION_H
#define PSP_PREDICTION_H

#include "actuation.h"
#include "cooperation.h"

/* What is remembered of others from one sampling instant to the next. */
typedef struct {
    double v[PSP_N], a[PSP_N], closing[PSP_N];
} Watched;

/* Commands on their way, and how the vehicles act; the actuators are those of `span` before now. */
typedef struct {
    const Actuators *actuators;
    const int32_t *places; /* of the vehicles that there are now; NULL where they are the same */
    const Actuation *actuation;
    double span;
    bool lags; /* of any of the PSP_N vehicles */
} Issued;

/* The vehicles at the time at which a command given now takes effect: places for n - 1, n and n numbers. */
typedef struct {
    double *s, *v, *a;
} Predicted;

/* Room for what is computed on the way. */
typedef struct {
    double moved[PSP_N], s[PSP_N], v[PSP_N], a[PSP_N]; /* the last three: the vehicles a lag later */
    double spacing[PSP_N], speed[PSP_N], other[PSP_N]; /* where the law is evaluated, and what it says */
} Ahead;

/* What is remembered after another sampling instant: v and what closing up would add if it were engaged at once.  `before`
 * is NULL at the first; `places` as in actuation.h. */
void watch(Watched *now, const Watched *before, const int32_t *places, int n, const double *v, const double *wanted,
           double T);

/* The acceleration of each vehicle that drives itself: communicated where known, else estimated. */
void accelerations(const Watched *watched, int n, const double *measured, const double *known, double *a);

/* What is known one sampling period after a command was given. */
void issue(Actuators *actuators, const Actuation *actuation, double span, int n, const double *a, double T);

/* n vehicles a dead time from now, from what was measured `age` ago. */
void predict(const Issued *issued, int n, const double *s, const double *v, double age, const Foreign *foreign,
             const Predicted *predicted, Ahead *work);

/* The commands of n vehicles: the law a lag ahead. */
void predictive_command(const Constants *constants, const Shape *shape, const Cooperation *cooperation,
                        const Traffic *traffic, const Issued *issued, int n, const Predicted *predicted, Ahead *work,
                        double *a);

#endif
