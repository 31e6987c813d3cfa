/* Vehicles that act late and softly: mirrors psp_model/vehicles/actuation.py.
 *
 * What is exact in one step per command there is a loop over the commands here, inside it one over the vehicles; that one is
 * written once and inlined for lags that are absent, alike or different, so that the compiler can vectorise it. */
#include "actuation.h"

#include <math.h>
#include <string.h>

#include "psp_kernels.h"

enum { NEWTON_STEPS = 30 };

typedef enum { NO_LAG, ONE_LAG, LAGS } Lags;

int64_t actuators_rows(double longest, double T)
{
    const double periods = ceil(longest / T * (1.0 - 1e-9)); /* as many as were meant before rounding */
    if (!(longest > 0.0)) return 0;
    return periods <= PSP_QUEUE - 2 ? (int64_t)periods + 2 : -1;
}

void actuators_begin(Actuators *actuators, int64_t rows)
{
    memset(actuators, 0, offsetof(Actuators, queue));
    actuators->rows = rows;
}

size_t actuators_ring(const Actuators *actuators) { return (size_t)actuators->rows * sizeof(OnItsWay); }

bool actuators_can_be(const Actuators *actuators, int64_t rows)
{
    const Actuators *const at = actuators;
    if (at->rows != rows || !(0 <= at->count && at->count <= rows)) return false;
    if (!(at->first == 0 || (0 < at->first && at->first < rows))) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!isfinite(at->a[i]) || !isfinite(at->command[i])) return false;
    }
    for (int64_t k = 0; k < rows; k++) { /* also those that wait for a command: they are cheap, and no surprise later */
        if (!isfinite(at->queue[k].due)) return false;
        for (int i = 0; i < PSP_N; i++) {
            if (!isfinite(at->queue[k].a[i])) return false;
        }
    }
    return true;
}

/* A row by its place among the commands on their way. */
static const OnItsWay *row(const Actuators *at, int64_t k)
{
    const int64_t place = at->first + k;
    return &at->queue[place < at->rows ? place : place - at->rows];
}

bool actuators_command(Actuators *actuators, int n, const double *a, double due)
{
    double *into = actuators->command;
    if (actuators->rows > 0) {
        if (actuators->count == actuators->rows) return false;
        OnItsWay *const last = (OnItsWay *)row(actuators, actuators->count++);
        last->due = due;
        into = last->a;
    }
    for (int i = 0; i < PSP_N; i++) into[i] = i < n ? a[i] : 0.0;
    return true;
}

const double *actuators_last(const Actuators *actuators)
{
    return actuators->count > 0 ? row(actuators, actuators->count - 1)->a : actuators->command;
}

/* How far one has come through a time tau, in pieces with one command each. */
typedef struct {
    const Actuators *of;
    const Places *places;  /* or NULL */
    const double *command; /* in effect */
    int64_t next;          /* command on its way */
    double passed, tau, now; /* time since the rows were written, and in this time */
    bool ended;
} Pieces;

static Pieces pieces(const Actuators *of, const Places *places, double tau)
{
    const Pieces fresh = {of, places, of->command, 0, 0.0, tau, 0.0, false};
    return fresh;
}

/* The same for another time from the end of this one on. */
static Pieces pieces_after(const Pieces *before, double tau)
{
    const double passed = before->passed + before->tau;
    const Pieces fresh = {before->of, before->places, before->command, before->next, passed, tau, 0.0, false};
    return fresh;
}

/* Rows of other vehicles, those themselves where they are the same. */
static const double *of_members(const double *values, const Places *places, int n)
{
    if (!places) return values;
    for (int i = 0; i < n; i++) places->gathered[i] = places->of[i] < 0 ? 0.0 : values[places->of[i]];
    return places->gathered;
}

/* The command of the next piece and its length; NULL at the end. */
static const double *next_piece(Pieces *at, double *span)
{
    const double *command = at->command;
    if (at->ended) return NULL;
    for (; at->next < at->of->count; at->next++) {
        const OnItsWay *following = row(at->of, at->next);
        const double due = following->due - at->passed, begun = at->now;
        if (due > at->tau) break;
        at->command = following->a;
        if (due > begun) {
            *span = due - begun;
            at->now = due;
            at->next++;
            return command;
        }
        command = following->a;
    }
    at->ended = true;
    *span = at->tau - at->now;
    return command;
}

/* The actuators at the end of the pieces, their accelerations aside. */
static void leave_behind(Actuators *actuators, const Pieces *all)
{
    if (all->command != actuators->command) memcpy(actuators->command, all->command, sizeof actuators->command);
    if (actuators->rows == 0) return;
    actuators->first = (actuators->first + all->next) % actuators->rows;
    actuators->count -= all->next;
    for (int64_t k = 0; k < actuators->count; k++) ((OnItsWay *)row(actuators, k))->due -= all->tau;
}

static Lags lags_of(const Actuation *actuation, int n)
{
    const double *lag = actuation->actuator_lag;
    for (int i = 1; i < n; i++) {
        if (lag[i] != lag[0]) return LAGS;
    }
    return lag[0] > 0.0 ? ONE_LAG : NO_LAG;
}

double first_stop(double v, double a, double command, double lag, double low)
{
    double t = a < command ? 0.0 : low;
    for (int k = 0; k < NEWTON_STEPS; k++) {
        const double nearer = psp_nearer_stop(v, a, command, lag, t, low);
        if (nearer == t) break; /* and so it would stay */
        t = nearer;
    }
    return t;
}

/* Speed and distance where a vehicle may come to a stop on the way, and may drive off again. */
static void with_stop(double v, double a, double command, double lag, double span, double *then, double *moved)
{
    const bool again = a < 0.0 && command > 0.0;
    const double turn = again ? psp_turning(a, command, lag) : 0.0;
    const double low = again ? fmin(turn, span) : span;
    double speed, until, further;
    psp_uninterrupted(v, a, command, lag, low, &speed, &until);
    if (!(speed < 0.0)) {
        *then = fmax(*then, 0.0);
        return;
    }
    psp_uninterrupted(v, a, command, lag, first_stop(v, a, command, lag, low), &speed, &until);
    psp_uninterrupted(0.0, 0.0, command, lag, again ? fmax(span - turn, 0.0) : 0.0, &speed, &further);
    *then = fmax(speed, 0.0);
    *moved = until + further;
}

void ride_steadily(double v, double a, double span, double *speed, double *moved)
{
    psp_unstopped_at_once(v, a, span, speed, moved);
    if (v + span * fmin(a, 0.0) < 0.0) with_stop(v, a, a, 0.0, span, speed, moved);
}

/* What n vehicles are told, and what they do with it. */
typedef struct {
    const Actuation *actuation;
    const Foreign *foreign; /* or NULL */
    const double *command;
    int n;
    double span;
} Told;

static inline double given(const Told *told, int i, bool all_automated)
{
    const Actuation *act = told->actuation;
    const double own = psp_limited(told->command[i], act->a_min[i], act->a_max[i]);
    return all_automated || told->foreign->automated[i] > 0.5 ? own : told->foreign->a[i];
}

static inline double now_given(const Told *told, const double *a, int i, bool all_automated)
{
    return all_automated || told->foreign->automated[i] > 0.5 ? a[i] : told->foreign->a[i];
}

static inline bool may_stop(const Told *told, Lags lags, bool all_automated, const double *restrict v,
                            const double *restrict a)
{
    bool any = false;
    for (int i = 0; i < told->n; i++) {
        const double command = given(told, i, all_automated);
        const double begins = lags == NO_LAG ? command
                                             : psp_first_felt(now_given(told, a, i, all_automated), command,
                                                              told->actuation->actuator_lag[i]);
        const double least = begins < command ? begins : command;
        any |= !(v[i] + told->span * (least < 0.0 ? least : 0.0) >= 0.0);
    }
    return any;
}

static inline void ride_of(const Told *told, Lags lags, bool all_automated, bool stops, double *restrict v,
                           double *restrict moved, double *restrict a)
{
    const double *restrict lag = told->actuation->actuator_lag, span = told->span;
    double gone = 1.0, kept = 0.0;
    if (lags == ONE_LAG) psp_faded(lag[0], span, &gone, &kept);
    for (int i = 0; i < told->n; i++) {
        const double command = given(told, i, all_automated), before = now_given(told, a, i, all_automated), from = v[i];
        double then, further, after = command;
        if (lags == LAGS && (i == 0 || lag[i] != lag[i - 1])) psp_faded(lag[i], span, &gone, &kept);
        if (lags == NO_LAG) psp_unstopped_at_once(from, command, span, &then, &further);
        else psp_unstopped(from, before, command, lag[i], span, gone, kept, &then, &further, &after);
        if (stops) with_stop(from, psp_first_felt(before, command, lag[i]), command, lag[i], span, &then, &further);
        v[i] = then;
        moved[i] += further;
        a[i] = after;
    }
}

/* `ride_of` for what the compiler is to know. */
static inline void ride_with(const Told *told, Lags lags, double *v, double *moved, double *a)
{
    const bool all_automated = !told->foreign;
    const bool stops = all_automated ? may_stop(told, lags, true, v, a) : may_stop(told, lags, false, v, a);
    if (stops) ride_of(told, lags, all_automated, true, v, moved, a);
    else if (all_automated) ride_of(told, lags, true, false, v, moved, a);
    else ride_of(told, lags, false, false, v, moved, a);
}

static void ride(const Told *told, Lags lags, double *v, double *moved, double *a)
{
    switch (lags) {
    case NO_LAG: ride_with(told, NO_LAG, v, moved, a); return;
    case ONE_LAG: ride_with(told, ONE_LAG, v, moved, a); return;
    default: ride_with(told, LAGS, v, moved, a);
    }
}

/* Drives n vehicles through the pieces. */
static void drive(Pieces *all, const Actuation *actuation, int n, const Foreign *foreign, double *v, double *moved, double *a)
{
    const Lags lags = lags_of(actuation, n);
    Told told = {actuation, foreign, NULL, n, 0.0};
    memset(moved, 0, (size_t)n * sizeof *moved);
    while ((told.command = next_piece(all, &told.span))) {
        told.command = of_members(told.command, all->places, n);
        ride(&told, lags, v, moved, a);
    }
}

/* What the actuators alone do in the pieces. */
static void settle(Pieces *all, const Actuation *actuation, int n, double *a)
{
    const Lags lags = lags_of(actuation, n);
    const double *lag = actuation->actuator_lag, *command;
    double span;
    while ((command = next_piece(all, &span))) {
        double gone = 1.0, kept;
        if (lags == NO_LAG && !all->ended) continue; /* the last command counts */
        command = of_members(command, all->places, n);
        if (lags == ONE_LAG) psp_faded(lag[0], span, &gone, &kept);
        for (int i = 0; i < n; i++) {
            if (lags == LAGS && (i == 0 || lag[i] != lag[i - 1])) psp_faded(lag[i], span, &gone, &kept);
            a[i] = psp_approached(a[i], psp_limited(command[i], actuation->a_min[i], actuation->a_max[i]), gone);
        }
    }
}

void actuators_drive(Actuators *actuators, const Actuation *actuation, int n, double tau, const Foreign *foreign, double *v,
                     double *moved)
{
    Pieces all = pieces(actuators, NULL, tau);
    drive(&all, actuation, n, foreign, v, moved, actuators->a);
    leave_behind(actuators, &all);
}

const double *actuators_foresee(const Actuators *actuators, const Places *places, const Actuation *actuation, int n,
                                double wait, double tau, const Foreign *foreign, double *v, double *moved, double *a)
{
    Pieces all = pieces(actuators, places, wait > 0.0 ? wait : tau);
    memcpy(a, of_members(actuators->a, places, n), (size_t)n * sizeof *a);
    if (wait > 0.0) {
        settle(&all, actuation, n, a);
        all = pieces_after(&all, tau);
    }
    drive(&all, actuation, n, foreign, v, moved, a);
    return of_members(all.command, places, n);
}

static void rearrange(double *rows, int n, const int32_t *places, bool backwards)
{
    for (int k = 0; k < n; k++) {
        const int i = backwards ? n - 1 - k : k;
        rows[i] = places[i] < 0 ? 0.0 : rows[places[i]];
    }
    for (int i = n; i < PSP_N; i++) rows[i] = 0.0;
}

void actuators_rearrange(Actuators *actuators, int n, const int32_t *places)
{
    bool backwards = false; /* no row may be overwritten before it has been taken */
    for (int i = 0; i < n; i++) backwards = backwards || (0 <= places[i] && places[i] < i);
    rearrange(actuators->a, n, places, backwards);
    rearrange(actuators->command, n, places, backwards);
    for (int64_t k = 0; k < actuators->count; k++)
        rearrange(((OnItsWay *)row(actuators, k))->a, n, places, backwards);
}

void actuators_settle(Actuators *actuators, const Actuation *actuation, int n, double tau)
{
    Pieces all = pieces(actuators, NULL, tau);
    settle(&all, actuation, n, actuators->a);
    leave_behind(actuators, &all);
}
