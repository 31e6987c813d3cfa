/* Where the vehicles will be when the next command takes effect: mirrors psp_model/vehicles/prediction.py and
 * psp_model/law/watching.py. */
#include "prediction.h"

#include <math.h>
#include <string.h>

#include "psp_kernels.h"
#include "ride.h"

#define CLOSEST 1e-3      /* [m] as in psp_model/vehicles/prediction.py */
#define ESTIMATE_TIME 0.2 /* [s] as in psp_model/law/watching.py */
#define CLOSING_TIME 2.0  /* [s] */

void watch(Watched *now, const Watched *before, const int32_t *places, int n, const double *v, const double *wanted,
           double T)
{
    const double estimated = 1.0 - exp(-T / ESTIMATE_TIME), engaged = 1.0 - exp(-T / CLOSING_TIME);
    for (int i = 0; i < n; i++) {
        const int was = places ? places[i] : i;
        const bool known = before && was >= 0;
        const double a = known ? before->a[was] : 0.0, closing = known ? before->closing[was] : 0.0;
        const double change = (v[i] - (known ? before->v[was] : v[i])) / T;
        now->v[i] = v[i];
        now->a[i] = before ? psp_nearer(a, change, estimated) : 0.0;
        now->closing[i] = before ? psp_nearer(closing, wanted[i], engaged) : 0.0;
    }
}

void accelerations(const Watched *watched, int n, const double *measured, const double *known, double *a)
{
    for (int i = 0; i < n; i++) a[i] = known[i] > 0.5 ? measured[i] : watched->a[i];
}

void issue(Actuators *actuators, const Actuation *actuation, double span, int n, const double *a, double T)
{
    actuators_command(actuators, n, a, actuation->actuation_delay + span);
    actuators_settle(actuators, actuation, n, T);
}

static void spacings_after(int n, const double *s, const double *moved, double *then)
{
    for (int i = 0; i < n - 1; i++) then[i] = psp_spacing_after(s[i], moved[i], moved[i + 1]);
}

void predict(const Issued *issued, int n, const double *s, const double *v, double age, const Foreign *foreign,
             const Predicted *predicted, Ahead *work)
{
    const double horizon = age + issued->actuation->actuation_delay;
    double *const then = predicted->v, *const a = predicted->a;
    memcpy(then, v, (size_t)n * sizeof *v);
    actuators_foresee(issued->actuators, issued->places, issued->actuation, n, issued->span - age, horizon, foreign, then,
                      work->moved, a, work->other);
    for (int i = 0; i < n; i++) {
        const double own = issued->lags ? a[i] : work->other[i];
        a[i] = psp_unless_standing(then[i], foreign && !(foreign->automated[i] > 0.5) ? foreign->a[i] : own);
    }
    spacings_after(n, s, work->moved, predicted->s);
}

/* The vehicles a time later if they keep their accelerations, down to standstill. */
static void later(const Predicted *now, int n, double span, Ahead *work)
{
    for (int i = 0; i < n; i++) {
        ride_steadily(now->v[i], now->a[i], span, &work->v[i], &work->moved[i]);
        work->a[i] = psp_unless_standing(work->v[i], now->a[i]);
    }
    spacings_after(n, now->s, work->moved, work->s);
}

/* The law where it is defined: no clearance of 0 or less. */
static void law_at(const Constants *constants, const Shape *shape, const Cooperation *cooperation, const Traffic *traffic,
                   int n, const Predicted *at, Ahead *work, double *a)
{
    Traffic there = *traffic;
    if (there.automated) there.a = at->a;
    for (int i = 0; i < n; i++) work->speed[i] = at->v[i] < constants->v_max ? at->v[i] : constants->v_max;
    for (int i = 0; i < n - 1; i++) {
        const double room = psp_clearance(at->s[i], cooperation->length[i], constants->L);
        work->spacing[i] = room > 0.0 ? at->s[i] : at->s[i] + (CLOSEST - room);
    }
    cooperative_command(constants, shape, cooperation, &there, n, work->spacing, work->speed, a);
}

void predictive_command(const Constants *constants, const Shape *shape, const Cooperation *cooperation,
                        const Traffic *traffic, const Issued *issued, int n, const Predicted *predicted, Ahead *work,
                        double *a)
{
    const double *lag = issued->actuation->actuator_lag;
    const Predicted then = {work->s, work->v, work->a};
    double longest = 0.0;
    bool alike = true;
    for (int i = 0; i < n; i++) longest = lag[i] > longest ? lag[i] : longest;
    for (int i = 0; i < n; i++) alike = alike && lag[i] == longest;
    if (longest == 0.0) {
        law_at(constants, shape, cooperation, traffic, n, predicted, work, a);
        return;
    }
    later(predicted, n, longest, work);
    law_at(constants, shape, cooperation, traffic, n, &then, work, a);
    if (alike) return;
    law_at(constants, shape, cooperation, traffic, n, predicted, work, work->other);
    for (int i = 0; i < n; i++) {
        const double share = lag[i] / longest;
        a[i] = share * a[i] + (1.0 - share) * work->other[i];
    }
}
