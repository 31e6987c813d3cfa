/* How hard the vehicles ahead may brake: mirrors psp_model/vehicles/braking.py.
 *
 * Of the instants at which a pair of vehicles is looked at there, most are passed over here: distances grow with time, so that
 * what holds at both ends of an interval, each end taken at its worst, holds within it.  The numbers are the same. */
#include "braking.h"

#include <math.h>
#include <stdbool.h>

#include "psp_kernels.h"
#include "ride.h"

enum { INSTANTS = 200 };

#define ROUNDING 1e-9 /* [1] no interval is passed over by a narrower margin than what rounding could make */

/* A vehicle that keeps its acceleration for the dead time, drives `first` meanwhile, and then brakes. */
typedef struct {
    double v, a, dead_time, first, speed, begins, a_min, lag, braked;
} Vehicle;

/* Two vehicles, and when they are looked at. */
typedef struct {
    Vehicle ahead, behind;
    bool foreign; /* the one ahead brakes with b */
    double clearance, until;
} Pair;

/* What is known of a pair at an instant, counted from 1. */
typedef struct {
    int k;
    double t, needed, ahead; /* how far the one ahead has to get, and how far it gets */
} Look;

static Vehicle vehicle(const Braking *all, int i)
{
    Vehicle of = {.v = all->v[i], .a = all->a[i], .dead_time = all->dead_time, .a_min = all->a_min[i], .lag = all->lag[i]};
    ride_steadily(of.v, of.a, of.dead_time, &of.speed, &of.first);
    const double a = psp_unless_standing(of.speed, of.a);
    of.begins = psp_first_felt(a, of.a_min, of.lag);
    const double low = (of.speed + fmax(a - of.a_min, 0.0) * of.lag) / -of.a_min;
    of.braked = first_stop(of.speed, of.begins, of.a_min, of.lag, low);
    return of;
}

static double travelled(const Vehicle *of, double t)
{
    double speed, first, then;
    if (t < of->dead_time) {
        ride_steadily(of->v, of->a, t, &speed, &first);
        return first;
    }
    const double braking = fmin(t - of->dead_time, of->braked);
    if (of->lag > 0.0) psp_uninterrupted(of->speed, of->begins, of->a_min, of->lag, braking, &speed, &then);
    else psp_unstopped_at_once(of->speed, of->a_min, braking, &speed, &then);
    return of->first + then;
}

static Look look(const Pair *pair, int k)
{
    const double share = (double)k / INSTANTS, t = share * share * pair->until;
    const Look found = {k, t, travelled(&pair->behind, t) - pair->clearance,
                        pair->foreign ? 0.0 : travelled(&pair->ahead, t)};
    return found;
}

/* The bound on b that an instant sets; for an automated vehicle ahead 0 in a collision. */
static double bound_at(const Pair *pair, const Look *at)
{
    if (pair->foreign) return psp_hardest(at->needed, pair->ahead.v, at->t);
    return at->ahead > at->needed ? BRAKE_MARGIN_MOST : 0.0;
}

/* Whether no instant between two sets a bound below `least`. */
static bool can_be_passed_over(const Pair *pair, const Look *from, const Look *to, double least)
{
    const double slack = ROUNDING * (1.0 + fabs(to->needed));
    if (!pair->foreign) return from->ahead > to->needed + slack;
    const double bound = psp_hardest(to->needed + slack, pair->ahead.v, from->t);
    return bound > least + ROUNDING || bound == BRAKE_MARGIN_MOST;
}

/* Whether the one behind brakes as hard and as soon as the one ahead and is hardly faster, so that they never meet: while both
 * drive the acceleration of the one behind exceeds the other's only by what is left of that by which it did so first, hence
 * its speed by no more than `faster`. */
static bool never_meet(const Pair *pair)
{
    const Vehicle *one = &pair->ahead, *other = &pair->behind;
    const double sooner = fmax(other->a - one->a, 0.0) * (other->dead_time + other->lag);
    const double faster = fmax(other->v - one->v, 0.0) + sooner;
    return !pair->foreign && other->a_min <= one->a_min && other->lag <= one->lag && other->a_min <= other->a &&
           one->a_min <= one->a && faster * pair->until < (1.0 - ROUNDING) * pair->clearance - ROUNDING;
}

/* The least of the bounds at the instants between two, and of `least`. */
static double least_between(const Pair *pair, const Look *from, const Look *to, double least)
{
    if (to->k - from->k < 2 || least <= 0.0 || can_be_passed_over(pair, from, to, least)) return least;
    const Look middle = look(pair, (from->k + to->k) / 2);
    least = fmin(least, bound_at(pair, &middle));
    least = least_between(pair, &middle, to, least);
    return least_between(pair, from, &middle, least);
}

double brake_margin(int n, const double *clearance, const Braking *vehicles, const double *automated)
{
    double least = BRAKE_MARGIN_MOST;
    bool any = false, counted = false;
    for (int i = 0; automated && i < n; i++) any = any || automated[i] < 0.5;
    Pair pair = {.behind = vehicle(vehicles, 0)};
    for (int i = 1; i < n && least > 0.0; i++) {
        const bool behind_is_foreign = any && automated[i] < 0.5;
        pair.ahead = pair.behind;
        pair.behind = vehicle(vehicles, i);
        pair.foreign = any ? automated[i - 1] < 0.5 : i == 1;
        counted = counted || pair.foreign; /* someone ahead drives himself */
        if (!counted || behind_is_foreign) continue;
        pair.clearance = clearance[i - 1];
        pair.until = pair.behind.dead_time + pair.behind.braked;
        if (never_meet(&pair)) continue;
        const Look start = {0, 0.0, -pair.clearance, 0.0}, end = look(&pair, INSTANTS);
        least = fmin(least, bound_at(&pair, &end));
        least = least_between(&pair, &start, &end, least);
    }
    return fmax(least, 0.0);
}
