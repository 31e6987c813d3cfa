/* Vehicles that join and leave, on a copy of the platoon: mirrors psp_model/membership.py. */
#include "platoon_trial.h"

#include <math.h>
#include <string.h>

enum { PROBES = 100, TRUSTED = 5 }; /* gaps tried for one that would do; how many with the potential chosen for them */

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
    if (again && last->T_max <= platoon->T) now->violations--;
}

bool trial_choose(Work *work)
{
    Platoon *trial = &work->trial;
    work->request.n = (int)trial->now.n;
    work->request.s = trial->now.s;
    work->request.v = trial->now.v;
    return choose_shape(work->front, &trial->constants, &trial->weights, trial->T, &work->request, &trial->shape);
}

/* Puts the vehicle into the trial; whether all gaps then exceed L. */
static bool arrange(Work *work, const Joining *joining)
{
    const Instant *seen = &work->seen;
    const int n = (int)seen->n, place = joining->place, gap = place > 0 ? place - 1 : 0;
    Instant *now = &work->trial.now;
    begin_trial(work);
    now->n = n + 1;
    now->x = seen->x + (place == 0 ? joining->gap : 0.0);
    now->s[gap] = joining->gap;
    memcpy(now->s + gap + 1, seen->s + gap, (size_t)(n - 1 - gap) * sizeof *now->s);
    if (0 < place && place < n) now->s[place] -= joining->gap;
    now->v[place] = joining->speed;
    memcpy(now->v + place + 1, seen->v + place, (size_t)(n - place) * sizeof *now->v);
    for (int i = 0; i < n; i++) {
        if (!(now->s[i] > work->trial.constants.L)) return false;
    }
    return true;
}

bool trial_join(Work *work, const Joining *joining, bool anew, bool *certified)
{
    Platoon *trial = &work->trial;
    *certified = false;
    if (!isfinite(joining->gap) || !arrange(work, joining)) return true;
    if (anew && !trial_choose(work)) return false;
    trial->policy = POLICY_SHORTEN; /* looks, and never objects */
    platoon_sample(trial, work->front, fmi2Warning);
    trial->policy = work->part->platoon.policy;
    *certified = trial->now.T_max > trial->T;
    return true;
}

/* Gaps at which the vehicle might join, nearest to the one asked for first; how many there are. */
static int gaps_to_try(const Work *work, const Joining *asked, double gaps[PROBES])
{
    const Constants *c = &work->part->platoon.constants;
    const bool inside = 0 < asked->place && asked->place < work->seen.n;
    const double room = inside ? work->seen.s[asked->place - 1] - c->L : c->L + 5.0 * c->lam;
    const double wanted = isfinite(asked->gap) ? asked->gap : c->lam, step = (room - c->L) / (PROBES + 1);
    if (!(room > c->L)) return 0;
    for (int k = 0; k < PROBES; k++) {
        const double gap = (k + 1) * step + c->L;
        int at = k;
        for (; at > 0 && fabs(gaps[at - 1] - wanted) > fabs(gap - wanted); at--) gaps[at] = gaps[at - 1];
        gaps[at] = gap;
    }
    return PROBES;
}

bool trial_find_gap(Work *work, const Joining *asked, double *offered)
{
    double gaps[PROBES];
    const int count = gaps_to_try(work, asked, gaps);
    Joining probe = *asked;
    bool certified;
    int found = 0;
    *offered = 0.0;
    for (int k = 0; k < count && found < TRUSTED; k++) {
        probe.gap = gaps[k];
        if (!trial_join(work, &probe, false, &certified)) return false;
        if (certified) gaps[found++] = gaps[k];
    }
    for (int k = 0; k < found && *offered == 0.0; k++) {
        probe.gap = gaps[k];
        if (!trial_join(work, &probe, true, &certified)) return false;
        if (certified) *offered = probe.gap;
    }
    return true;
}

void trial_take_out(Work *work, int gone)
{
    const Instant *seen = &work->seen;
    const int n = (int)seen->n;
    const int next = gone == 0 ? 1 : gone < n - 1 ? gone + 1 : n - 1; /* the gaps from here on move up */
    Instant *now = &work->trial.now;
    begin_trial(work);
    now->n = n - 1;
    if (gone == 0) now->x = seen->x - seen->s[0];
    else if (gone < n - 1) now->s[gone - 1] = seen->s[gone - 1] + seen->s[gone];
    memmove(now->s + next - 1, now->s + next, (size_t)(n - 1 - next) * sizeof *now->s);
    memmove(now->v + gone, now->v + gone + 1, (size_t)(n - 1 - gone) * sizeof *now->v);
    now->v[n - 1] = now->a[n - 1] = now->s[n - 2] = 0.0;
}
