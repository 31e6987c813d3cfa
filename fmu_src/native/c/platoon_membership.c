/* Vehicles that join and leave: mirrors psp_model/membership.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platoon_model.h"

enum { PROBES = 100, TRUSTED = 5 }; /* gaps tried for one that would do; how many with the potential chosen for them */

/* A vehicle that wants to join behind the vehicle at `place`, 0: ahead of the leader. */
typedef struct {
    int place;
    double gap, speed;
} Joining;

/* What a change is tried out in. */
typedef struct {
    Front *front;
    const Part *part;
    Request request;
    Instant seen;  /* the platoon at the time of the change */
    Platoon trial; /* the platoon after it */
} Work;

static double is_in_domain(const Platoon *platoon)
{
    const Instant *now = &platoon->now;
    const int n = (int)now->n;
    return network_for(n) && !outside_domain(n, now->s, now->v, &platoon->constants) ? 1.0 : 0.0;
}

void part_begin(Part *part, int n)
{
    part->members = (Members){.told = {.n_active = n, .change_ok = 1.0}, .joined = n};
    for (int i = 0; i < n; i++) part->members.told.vehicles[i] = i + 1;
    part->in_domain = is_in_domain(&part->platoon);
}

/* A change that was made: the trial is the platoon from here on. */
static void take_over(Part *part, Work *work)
{
    part->platoon = work->trial;
    part->in_domain = is_in_domain(&part->platoon);
    warn_of_fallback(work->front, &part->platoon.constants, &work->request);
    part->members.told.n_active = (double)part->platoon.now.n;
    part->members.told.changes++;
    part->members.told.change_ok = 1.0;
}

static void refuse(Told *told, double gap_offered)
{
    told->refusals++;
    told->change_ok = 0.0;
    told->gap_offered = gap_offered;
}

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

/* Chooses the potential for the vehicles of the trial. */
static bool choose(Work *work)
{
    Platoon *trial = &work->trial;
    bool in_domain;
    work->request.n = (int)trial->now.n;
    work->request.s = trial->now.s;
    work->request.v = trial->now.v;
    return choose_shape(work->front, &trial->constants, &trial->weights, trial->T, &work->request, &trial->shape,
                        &in_domain);
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

/* Samples the trial with the vehicle, with the potential in use or one chosen `anew`; *certified: T then is. */
static bool try_join(Work *work, const Joining *joining, bool anew, bool *certified)
{
    Platoon *trial = &work->trial;
    *certified = false;
    if (!isfinite(joining->gap) || !arrange(work, joining)) return true;
    if (anew && !choose(work)) return false;
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

/* The nearest gap found at which the vehicle may join, 0 if there is none. */
static bool find_gap(Work *work, const Joining *asked, double *offered)
{
    double gaps[PROBES];
    const int count = gaps_to_try(work, asked, gaps);
    Joining probe = *asked;
    bool certified;
    int found = 0;
    *offered = 0.0;
    for (int k = 0; k < count && found < TRUSTED; k++) {
        probe.gap = gaps[k];
        if (!try_join(work, &probe, false, &certified)) return false;
        if (certified) gaps[found++] = gaps[k];
    }
    for (int k = 0; k < found && *offered == 0.0; k++) {
        probe.gap = gaps[k];
        if (!try_join(work, &probe, true, &certified)) return false;
        if (certified) *offered = probe.gap;
    }
    return true;
}

/* NAN as it is printed everywhere. */
static double printable(double value) { return isnan(value) ? (double)NAN : value; }

static bool refuse_join(Work *work, Told *told, const Joining *asked)
{
    const int place = asked->place + 1;
    const double gap = printable(asked->gap), T = work->part->platoon.T;
    double offered;
    if (!find_gap(work, asked, &offered)) return false;
    if (offered > 0.0)
        front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_gap, place, gap, asked->speed, T, offered);
    else
        front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_none, place, gap, asked->speed, T);
    refuse(told, offered);
    return true;
}

/* Whether `place` names a vehicle, or with first = 0 the road ahead of the leader; logs why not. */
static bool is_place(Front *front, const char *name, double place, int first, int n)
{
    if (first <= place && place <= n && place == floor(place)) return true;
    front_log(front, fmi2Warning, PSP_SENTENCE_place, name, printable(place), first, n);
    return false;
}

static bool may_join(Work *work, const double *values)
{
    const int n = (int)work->seen.n;
    const double speed = values[PSP_insert_speed], v_max = work->part->platoon.constants.v_max;
    if (!is_place(work->front, "insert_behind", values[PSP_insert_behind], 0, n)) return false;
    if (n == PSP_N) {
        front_log(work->front, fmi2Warning, PSP_SENTENCE_full, PSP_N);
        return false;
    }
    if (0.0 <= speed && speed <= v_max) return true;
    front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_speed, printable(speed), v_max);
    return false;
}

static bool join(Part *part, Work *work, const double *values)
{
    Members *members = &part->members;
    bool certified;
    if (!may_join(work, values)) {
        refuse(&members->told, 0.0);
        return true;
    }
    const Joining asked = {(int)values[PSP_insert_behind], values[PSP_insert_gap], values[PSP_insert_speed]};
    if (!try_join(work, &asked, true, &certified)) return false;
    if (!certified) return refuse_join(work, &members->told, &asked);
    take_over(part, work);
    double *at = members->told.vehicles + asked.place;
    memmove(at + 1, at, (size_t)(part->platoon.now.n - 1 - asked.place) * sizeof *at);
    *at = (double)++members->joined;
    return true;
}

static bool may_leave(Work *work, double place)
{
    const int n = (int)work->seen.n;
    if (!is_place(work->front, "remove_place", place, 1, n)) return false;
    if (n > 1) return true;
    front_log(work->front, fmi2Warning, PSP_SENTENCE_last);
    return false;
}

/* Takes the vehicle at index `gone` out of the trial. */
static void take_out(Work *work, int gone)
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

static bool leave(Part *part, Work *work, const double *values)
{
    Members *members = &part->members;
    const double place = values[PSP_remove_place];
    if (!may_leave(work, place)) {
        refuse(&members->told, 0.0);
        return true;
    }
    const int gone = (int)place - 1, left = (int)work->seen.n - 1;
    take_out(work, gone);
    if (!choose(work)) return false;
    if (!platoon_sample(&work->trial, work->front, fmi2Warning)) {
        refuse(&members->told, 0.0);
        return true;
    }
    take_over(part, work);
    double *at = members->told.vehicles + gone;
    memmove(at, at + 1, (size_t)(left - gone) * sizeof *at);
    members->told.vehicles[left] = 0.0;
    return true;
}

typedef bool Change(Part *part, Work *work, const double *values);

static bool make(Change *change, Part *part, Front *front, const double *values)
{
    Work *work = calloc(1, sizeof *work);
    bool done = false;
    if (!work) {
        front_log(front, fmi2Error, "there is no memory left for vehicles to join or leave: free some instances");
        return false;
    }
    work->front = front;
    work->part = part;
    const Instant *seen = platoon_observe(&part->platoon, part->period, part->fraction, &work->seen);
    if (seen != &work->seen) work->seen = *seen;
    done = read_request(front, values, &work->request);
    work->request.quiet = true;
    done = done && change(part, work, values);
    free(work);
    return done;
}

bool part_make_changes(Part *part, Front *front, const double *values)
{
    const double insert = values[PSP_insert], remove = values[PSP_remove];
    Members *members = &part->members;
    if (insert == members->insert && remove == members->remove) return true;
    if (remove > 0.5 && !(members->remove > 0.5) && !make(leave, part, front, values)) return false;
    if (insert > 0.5 && !(members->insert > 0.5) && !make(join, part, front, values)) return false;
    members->insert = insert;
    members->remove = remove;
    return true;
}
