/* Vehicles that join and leave, on a copy of the platoon: mirrors psp_model/membership.py. */
#include "platoon_trial.h"

#include "braking.h"

#include <math.h>
#include <string.h>

enum { PROBES = 100, TRUSTED = 5 }; /* spacings tried for one that would do; how many with the potential chosen for them */

/* The trial begins as the platoon at the time of the change; the verdict of an earlier sampling then is void. */
static void begin_trial(Work *work)
{
    const Part *part = work->part;
    const Platoon *platoon = &part->platoon;
    const Instant *last = &platoon->now;
    Instant *now = &work->trial.now;
    work->trial = *platoon;
    *now = work->seen;
    now->period = part->period;
    now->fraction = part->fraction;
    const bool again = part->period == last->period && part->fraction == last->fraction;
    if (again && last->bound <= platoon->T) now->violations--;
}

bool trial_choose(Work *work)
{
    Platoon *trial = &work->trial;
    work->request.n = (int)trial->now.n;
    work->request.s = work->room;
    work->request.v = trial->now.v;
    return choose_shape(work->front, &trial->constants, &trial->weights, trial->T, &work->request, &trial->shape);
}

/* The spacings of the trial with the lengths ahead taken for L; whether all exceed L. */
static bool make_room(Work *work)
{
    Platoon *trial = &work->trial;
    const int n = (int)trial->now.n;
    contact_spacing(&trial->constants, &trial->cooperation, n, trial->now.s, work->room);
    platoon_settle(trial);
    for (int i = 0; i < n - 1; i++) {
        if (!(work->room[i] > trial->constants.L)) return false;
    }
    return true;
}

/* Puts a value among n others, at a place; takes the one at a place out of n. */
static void put_in(double *values, int n, int place, double value)
{
    memmove(values + place + 1, values + place, (size_t)(n - place) * sizeof *values);
    values[place] = value;
}

/* Puts the vehicle into the trial; whether no two vehicles then touch. */
static bool arrange(Work *work, const Joining *joining)
{
    const int n = (int)work->seen.n, place = joining->place, spacing = place > 0 ? place - 1 : 0;
    Instant *now = &work->trial.now;
    begin_trial(work);
    now->n = n + 1;
    if (place == 0) {
        now->x += joining->spacing;
        now->driven = 0; /* the first vehicle is another one */
    }
    put_in(now->s, n - 1, spacing, joining->spacing);
    if (0 < place && place < n) now->s[place] -= joining->spacing;
    put_in(now->v, n, place, joining->speed);
    put_in(now->closing, n, place, 0.0);
    put_in(work->trial.cooperation.length, n, place, joining->length);
    return make_room(work);
}

/* Whether the trial has the brake margin that joining asks for. */
static bool can_brake(Work *work)
{
    const Platoon *trial = &work->trial;
    const int n = (int)trial->now.n;
    const Braking braking = {.v = trial->now.v, .a = trial->now.a, .lag = work->no_lag, .a_min = work->a_min};
    if (!(trial->join_brake_margin > 0.0)) return true;
    for (int i = 0; i < n; i++) work->a_min[i] = trial->join_a_min;
    clearances(&trial->constants, &trial->cooperation, n, trial->now.s, work->clearance);
    return brake_margin(n, work->clearance, &braking, NULL) >= trial->join_brake_margin;
}

bool trial_join(Work *work, const Joining *joining, bool anew, Verdict *verdict)
{
    Platoon *trial = &work->trial;
    *verdict = NOT_CERTIFIED;
    if (!isfinite(joining->spacing) || !arrange(work, joining)) return true;
    if (anew && !trial_choose(work)) return false;
    trial->policy = POLICY_SHORTEN; /* looks, and never objects */
    platoon_sample(trial, work->front, work->since, fmi2Warning);
    trial->policy = work->part->platoon.policy;
    if (trial->now.bound > trial->T) *verdict = can_brake(work) ? MAY_JOIN : TOO_CLOSE;
    return true;
}

/* Spacings at which the vehicle might join, nearest to the one asked for first; how many there are. */
static int spacings_to_try(const Work *work, const Joining *asked, double spacings[PROBES])
{
    const Platoon *platoon = &work->part->platoon;
    const Constants *c = &platoon->constants;
    const bool inside = 0 < asked->place && asked->place < work->seen.n;
    const double least = asked->place > 0 ? platoon->cooperation.length[asked->place - 1] : asked->length;
    const double most = inside ? work->seen.s[asked->place - 1] - asked->length : least + 5.0 * c->lam;
    const double wanted = isfinite(asked->spacing) ? asked->spacing : c->lam, step = (most - least) / (PROBES + 1);
    if (!(most > least)) return 0;
    for (int k = 0; k < PROBES; k++) {
        const double spacing = (k + 1) * step + least;
        int at = k;
        for (; at > 0 && fabs(spacings[at - 1] - wanted) > fabs(spacing - wanted); at--) spacings[at] = spacings[at - 1];
        spacings[at] = spacing;
    }
    return PROBES;
}

bool trial_find_spacing(Work *work, const Joining *asked, double *offered)
{
    double spacings[PROBES];
    const int count = spacings_to_try(work, asked, spacings);
    Joining probe = *asked;
    Verdict verdict;
    int found = 0;
    *offered = 0.0;
    for (int k = 0; k < count && found < TRUSTED; k++) {
        probe.spacing = spacings[k];
        if (!trial_join(work, &probe, false, &verdict)) return false;
        if (verdict == MAY_JOIN) spacings[found++] = spacings[k];
    }
    for (int k = 0; k < found && *offered == 0.0; k++) {
        probe.spacing = spacings[k];
        if (!trial_join(work, &probe, true, &verdict)) return false;
        if (verdict == MAY_JOIN) *offered = probe.spacing;
    }
    return true;
}

static void take_out(double *values, int n, int place)
{
    memmove(values + place, values + place + 1, (size_t)(n - 1 - place) * sizeof *values);
}

void trial_take_out(Work *work, int gone)
{
    const Instant *seen = &work->seen;
    const int n = (int)seen->n, spacing = gone < n - 1 ? gone : n - 2; /* the one that goes */
    Instant *now = &work->trial.now;
    double *length = work->trial.cooperation.length;
    begin_trial(work);
    now->n = n - 1;
    if (gone == 0) {
        now->x -= seen->s[0];
        now->driven = 0; /* the first vehicle is another one */
    } else if (gone < n - 1) now->s[gone - 1] = seen->s[gone - 1] + seen->s[gone];
    take_out(now->s, n - 1, spacing);
    take_out(now->v, n, gone);
    take_out(now->closing, n, gone);
    take_out(length, n, gone);
    now->v[n - 1] = now->a[n - 1] = now->s[n - 2] = now->closing[n - 1] = 0.0;
    length[n - 1] = work->trial.constants.L;
    make_room(work);
}
