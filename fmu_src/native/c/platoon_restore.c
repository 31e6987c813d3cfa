/* Whether the closed loop can be as bytes say: mirrors fmu_src/python/platoon_state.py.  What follows from the
 * parameters is computed anew, the rest is checked. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "native_model.h"

#include "psp_kernels.h"

/* What the parameters say, in the place of what the bytes say of it; false where they do not make a platoon. */
static bool take_settings(Platoon *platoon, const double *values, Request *request)
{
    Front nobody = {0}; /* hears nothing */
    Platoon *fresh = malloc(sizeof *fresh);
    const bool made = fresh && platoon_read(fresh, &nobody, values, request);
    if (made) {
        platoon->constants = fresh->constants;
        platoon->weights = fresh->weights;
        platoon->T = fresh->T;
        platoon->policy = fresh->policy;
        platoon->max_short_periods = fresh->max_short_periods;
        platoon->certificate = fresh->certificate;
        platoon->join_brake_margin = fresh->join_brake_margin;
        platoon->join_a_min = fresh->join_a_min;
        memcpy(fresh->cooperation.length, platoon->cooperation.length, sizeof fresh->cooperation.length);
        platoon->cooperation = fresh->cooperation;
    }
    free(fresh);
    return made;
}

static bool are_finite(const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(values[i])) return false;
    }
    return true;
}

static bool is_time(int64_t period, double fraction)
{
    return state_is_count((double)period, 0.0) && 0.0 <= fraction && fraction < 1.0;
}

static bool can_be_now(const Instant *now)
{
    if (!(1 <= now->n && now->n <= PSP_N) || !is_time(now->period, now->fraction)) return false;
    if (!state_is_count((double)now->violations, 0.0) || !(0.0 < now->span && now->span <= 1.0)) return false;
    if (!isfinite(now->x) || isnan(now->T_max) || !(now->cost_acceleration >= 0.0) || isnan(now->cost_spacings)) return false;
    if (isnan(now->bound) || (now->driven != 0 && now->driven != 1)) return false;
    return are_finite(now->s, PSP_N - 1) && are_finite(now->v, PSP_N) && are_finite(now->a, PSP_N) &&
           are_finite(now->closing, PSP_N);
}

/* Whether the lengths, and what was told of the leader, can be; and whether no vehicles touch, unless that has `failed`. */
static bool can_be_law(const Platoon *platoon, bool failed)
{
    const Leader *leader = &platoon->leader;
    const double *length = platoon->cooperation.length, L = platoon->constants.L;
    if (!are_finite(length, PSP_N) || (leader->driven != 0 && leader->driven != 1)) return false;
    if (!(0.0 <= leader->speed && leader->speed <= platoon->constants.v_max) || !isfinite(leader->acceleration)) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!(length[i] > 0.0)) return false;
    }
    for (int i = 0; i < platoon->now.n - 1 && !failed; i++) {
        if (!(psp_contact_spacing(platoon->now.s[i], length[i], L) > L)) return false;
    }
    return true;
}

static bool can_be_members(const Members *members, int64_t n)
{
    const Told *told = &members->told;
    if (told->n_active != (double)n || !state_is_count((double)members->joined, (double)n)) return false;
    if ((told->change_ok != 0.0 && told->change_ok != 1.0) || !isfinite(told->gap_offered)) return false;
    if (!state_is_count(told->changes, 0.0) || !state_is_count(told->refusals, 0.0)) return false;
    for (int64_t i = 0; i < PSP_N; i++) {
        const double vehicle = told->vehicles[i];
        if (i >= n ? vehicle != 0.0 : !state_is_count(vehicle, 1.0) || vehicle > (double)members->joined) return false;
    }
    return true;
}

/* Whether the communication point lies between the last sampling instant and the next, and the clock and the front
 * stand there: a step from elsewhere would pass instants without end. */
static bool can_be_here(const Part *part, const Progress *progress, const Clock *clock)
{
    const Instant *now = &part->platoon.now;
    const double since = (double)(part->period - now->period) + (part->fraction - now->fraction);
    double fraction;
    const int64_t period = clock_at(clock, &fraction);
    return -1.0 <= since && since <= 1.0 + TIME_TOLERANCE && period == part->period && fraction == part->fraction &&
           progress->time == clock->time;
}

bool part_restore(Model *model, const Progress *progress)
{
    Part *part = &model->part;
    Platoon *platoon = &part->platoon;
    Request request;
    if (!take_settings(platoon, model->values, &request)) return false;
    if (!state_is_shape(&platoon->shape, &platoon->constants, request.old) || !is_time(part->period, part->fraction) ||
        !can_be_now(&platoon->now) || !can_be_law(platoon, progress->mode == IN_ERROR) ||
        !can_be_members(&part->members, platoon->now.n) || (part->in_domain != 0.0 && part->in_domain != 1.0))
        return false;
    platoon_settle(platoon);
    return progress->mode != STEP_COMPLETE || can_be_here(part, progress, &model->clock);
}
