/* Vehicles that join and leave, and what is said of it: mirrors psp_model/membership.py and
 * fmu_src/python/platoon_slave.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platoon_trial.h"

static double is_in_domain(const Platoon *platoon, const double *room)
{
    return lies_in_domain((int)platoon->now.n, room, platoon->now.v, &platoon->constants) ? 1.0 : 0.0;
}

void part_begin(Part *part, int n, const double *room)
{
    part->members = (Members){.told = {.n_active = n, .change_ok = 1.0}, .joined = n};
    for (int i = 0; i < n; i++) part->members.told.vehicles[i] = i + 1;
    part->in_domain = is_in_domain(&part->platoon, room);
}

/* A change that was made: the trial is the platoon from here on. */
static void take_over(Part *part, Work *work)
{
    part->platoon = work->trial;
    part->in_domain = is_in_domain(&part->platoon, work->room);
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

/* The sentences of a refusal, by the verdict on the spacing asked for: with a spacing that would do, and without. */
static const char *refusal(const Platoon *platoon, Verdict verdict, bool offered)
{
    if (verdict == TOO_CLOSE) return offered ? PSP_SENTENCE_insert_spacing_margin : PSP_SENTENCE_insert_none_margin;
    if (platoon->certificate == CERTIFICATE_EXACT)
        return offered ? PSP_SENTENCE_insert_spacing_exact : PSP_SENTENCE_insert_none_exact;
    return offered ? PSP_SENTENCE_insert_spacing : PSP_SENTENCE_insert_none;
}

static bool refuse_join(Work *work, Told *told, const Joining *asked, Verdict verdict)
{
    const Platoon *platoon = &work->part->platoon;
    const int place = asked->place + 1;
    const double spacing = printable(asked->spacing), limit = verdict == TOO_CLOSE ? platoon->join_brake_margin : platoon->T;
    double offered;
    if (!trial_find_spacing(work, asked, &offered)) return false;
    const char *sentence = refusal(platoon, verdict, offered > 0.0);
    if (offered > 0.0) front_log(work->front, fmi2Warning, sentence, place, spacing, asked->speed, limit, offered);
    else front_log(work->front, fmi2Warning, sentence, place, spacing, asked->speed, limit);
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
    const double length = values[PSP_insert_length];
    if (!is_place(work->front, "insert_behind", values[PSP_insert_behind], 0, n)) return false;
    if (n == PSP_N) {
        front_log(work->front, fmi2Warning, PSP_SENTENCE_full, PSP_N);
        return false;
    }
    if (0.0 <= speed && speed <= v_max) {
        if (0.0 <= length && isfinite(length)) return true;
        front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_length, printable(length));
        return false;
    }
    if (!isfinite(speed))
        front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_finite, printable(speed), v_max);
    else if (speed < 0.0) front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_backwards, speed, v_max);
    else front_log(work->front, fmi2Warning, PSP_SENTENCE_insert_speed, speed, v_max);
    return false;
}

static bool join(Part *part, Work *work, const double *values)
{
    Members *members = &part->members;
    Verdict verdict;
    if (!may_join(work, values)) {
        refuse(&members->told, 0.0);
        return true;
    }
    const double given = values[PSP_insert_length], length = given == 0.0 ? part->platoon.constants.L : given;
    const Joining asked = {(int)values[PSP_insert_behind], values[PSP_insert_gap], values[PSP_insert_speed], length};
    if (!trial_join(work, &asked, true, &verdict)) return false;
    if (verdict != MAY_JOIN) return refuse_join(work, &members->told, &asked, verdict);
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

static bool leave(Part *part, Work *work, const double *values)
{
    Members *members = &part->members;
    const double place = values[PSP_remove_place];
    if (!may_leave(work, place)) {
        refuse(&members->told, 0.0);
        return true;
    }
    const int gone = (int)place - 1, left = (int)work->seen.n - 1;
    trial_take_out(work, gone);
    if (!trial_choose(work)) return false;
    if (!platoon_sample(&work->trial, work->front, work->since, fmi2Warning)) {
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
    memcpy(work->seen.closing, part->platoon.now.closing, sizeof work->seen.closing);
    work->since = ((double)(part->period - part->platoon.now.period) + (part->fraction - part->platoon.now.fraction)) *
                  part->platoon.T;
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
