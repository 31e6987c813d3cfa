/* Vehicles that act late and softly: mirrors psp_model/vehicles/actuation.py.
 *
 * There a platoon is driven from command to command.  Here a block of vehicles is, through all commands, before the next
 * block; what is done to a block under one command is written once and inlined for lags that are absent, alike or different,
 * so that the compiler can vectorise it. */
#include "actuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "psp_kernels.h"

enum { NEWTON_STEPS = 30, BLOCK = 128 };

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
    const double *command; /* in effect */
    int64_t next;          /* command on its way */
    double passed, tau, now; /* time since the rows were written, and in this time */
    bool ended;
} Pieces;

static Pieces pieces(const Actuators *of, double tau)
{
    const Pieces fresh = {of, of->command, 0, 0.0, tau, 0.0, false};
    return fresh;
}

/* The same for another time from the end of this one on. */
static Pieces pieces_after(const Pieces *before, double tau)
{
    const double passed = before->passed + before->tau;
    const Pieces fresh = {before->of, before->command, before->next, passed, tau, 0.0, false};
    return fresh;
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
    double t = a < command ? 0.0 : low, before = -1.0;
    for (int left = NEWTON_STEPS; left > 0; left--) {
        const double nearer = lag > 0.0 ? psp_nearer_stop(v, a, command, lag, t, low)
                                        : psp_nearer_stop_at_once(v, command, t, low);
        if (nearer == before) return left % 2 ? nearer : t; /* between two numbers, and so it would go on */
        if (nearer == t) break;                             /* and so it would stay */
        before = t;
        t = nearer;
    }
    return t;
}

/* A vehicle that may reverse; without a lag a is the command. */
static inline void uninterrupted(double v, double a, double command, double lag, double span, double *speed, double *moved)
{
    if (lag > 0.0) psp_uninterrupted(v, a, command, lag, span, speed, moved);
    else psp_unstopped_at_once(v, command, span, speed, moved);
}

/* Speed and distance where a vehicle may come to a stop on the way, and may drive off again. */
static void with_stop(double v, double a, double command, double lag, double span, double *then, double *moved)
{
    const bool again = a < 0.0 && command > 0.0;
    const double turn = again ? psp_turning(a, command, lag) : 0.0;
    const double low = again ? fmin(turn, span) : span;
    double speed, until, further;
    uninterrupted(v, a, command, lag, low, &speed, &until);
    if (!(speed < 0.0)) {
        *then = fmax(*then, 0.0);
        return;
    }
    uninterrupted(v, a, command, lag, first_stop(v, a, command, lag, low), &speed, &until);
    uninterrupted(0.0, 0.0, command, lag, again ? fmax(span - turn, 0.0) : 0.0, &speed, &further);
    *then = fmax(speed, 0.0);
    *moved = until + further;
}

void ride_steadily(double v, double a, double span, double *speed, double *moved)
{
    psp_unstopped_at_once(v, a, span, speed, moved);
    if (v + span * fmin(a, 0.0) < 0.0) with_stop(v, a, a, 0.0, span, speed, moved);
}

/* Some of the vehicles, in whose order all of these are: as many as there is room for on any stack. */
typedef struct {
    const double *lag, *a_min, *a_max, *automated, *of_others; /* automated is NULL where all are */
    const int32_t *places;                                     /* NULL where they are the same */
    int first, n;
    Lags lags;
    double span, gone[BLOCK], kept[BLOCK]; /* the shares that fade in a piece of that length; the first is for all alike */
    double gathered[BLOCK];
} Block;

static void choose_block(Block *block, const Actuation *actuation, const int32_t *places, const Foreign *foreign, int n,
                         int first)
{
    block->lag = actuation->actuator_lag + first;
    block->a_min = actuation->a_min + first;
    block->a_max = actuation->a_max + first;
    block->automated = foreign ? foreign->automated + first : NULL;
    block->of_others = foreign ? foreign->a + first : NULL;
    block->places = places ? places + first : NULL;
    block->first = first;
    block->n = n - first < BLOCK ? n - first : BLOCK;
    block->span = -1.0;
    block->gone[0] = 1.0;
}

/* Of rows of all vehicles those of the block. */
static const double *of_members(Block *block, const double *values)
{
    if (!block->places) return values + block->first;
    for (int i = 0; i < block->n; i++) block->gathered[i] = block->places[i] < 0 ? 0.0 : values[block->places[i]];
    return block->gathered;
}

/* Brings the shares that fade up to date; what differs by rounding counts as equal. */
static void fade(Block *block, double span)
{
    if (fabs(span - block->span) <= 4.0 * DBL_EPSILON * span) return;
    block->span = span;
    if (block->lags == ONE_LAG) psp_faded(block->lag[0], span, &block->gone[0], &block->kept[0]);
    for (int i = 0; block->lags == LAGS && i < block->n; i++)
        psp_faded(block->lag[i], span, &block->gone[i], &block->kept[i]);
}

/* One piece; whether a vehicle may come to a stop in it, which is taken into account if `stopping`. */
static inline bool ride_of(const Block *block, const double *restrict told, double span, Lags lags, bool all_automated,
                           bool stopping, double *restrict v, double *restrict moved, double *restrict a)
{
    bool any = false;
    for (int i = 0; i < block->n; i++) {
        const bool own = all_automated || block->automated[i] > 0.5;
        const double command = own ? psp_limited(told[i], block->a_min[i], block->a_max[i]) : block->of_others[i];
        const double from = v[i], before = own ? a[i] : command, lag = block->lag[i];
        const double begins = lags == NO_LAG ? command : psp_first_felt(before, command, lag);
        const double least = begins < command ? begins : command;
        const bool stops = !(from + span * (least < 0.0 ? least : 0.0) >= 0.0);
        double then, further, after = command;
        if (lags == NO_LAG) psp_unstopped_at_once(from, command, span, &then, &further);
        else {
            const int k = lags == ONE_LAG ? 0 : i;
            psp_unstopped(from, before, command, lag, span, block->gone[k], block->kept[k], &then, &further, &after);
        }
        if (stopping && stops) with_stop(from, begins, command, lag, span, &then, &further);
        any |= stops;
        v[i] = then;
        moved[i] += further;
        a[i] = after;
    }
    return any;
}

/* `ride_of` for what the compiler is to know. */
static inline bool ride_with(const Block *block, const double *told, double span, Lags lags, bool stopping, double *v,
                             double *moved, double *a)
{
    if (stopping) return ride_of(block, told, span, lags, !block->automated, true, v, moved, a);
    return block->automated ? ride_of(block, told, span, lags, false, false, v, moved, a)
                            : ride_of(block, told, span, lags, true, false, v, moved, a);
}

static bool ride(const Block *block, const double *told, double span, bool stopping, double *v, double *moved, double *a)
{
    switch (block->lags) {
    case NO_LAG: return ride_with(block, told, span, NO_LAG, stopping, v, moved, a);
    case ONE_LAG: return ride_with(block, told, span, ONE_LAG, stopping, v, moved, a);
    default: return ride_with(block, told, span, LAGS, stopping, v, moved, a);
    }
}

/* Drives a block through the pieces; false, and nothing of worth, where a vehicle may come to a stop and may not. */
static bool drive_through(Block *block, Pieces *all, bool stopping, double *v, double *moved, double *a)
{
    const double *told;
    double span;
    memset(moved, 0, (size_t)block->n * sizeof *moved);
    while ((told = next_piece(all, &span))) {
        if (block->lags != NO_LAG) fade(block, span);
        if (ride(block, of_members(block, told), span, stopping, v, moved, a) && !stopping) return false;
    }
    return true;
}

/* The same: vehicles rarely stop, and as long as none does nobody asks in which piece. */
static void drive_block(Block *block, Pieces *all, double *v, double *moved, double *a)
{
    const Pieces begun = *all;
    const size_t size = (size_t)block->n * sizeof *v;
    double v_begun[BLOCK], a_begun[BLOCK];
    memcpy(v_begun, v, size);
    memcpy(a_begun, a, size);
    if (drive_through(block, all, false, v, moved, a)) return;
    *all = begun;
    memcpy(v, v_begun, size);
    memcpy(a, a_begun, size);
    drive_through(block, all, true, v, moved, a);
}

/* What the actuators of a block alone do in the pieces. */
static void settle_block(Block *block, Pieces *all, double *a)
{
    const double *told;
    double span;
    while ((told = next_piece(all, &span))) {
        if (block->lags == NO_LAG && !all->ended) continue; /* the last command counts */
        if (block->lags != NO_LAG) fade(block, span);
        told = of_members(block, told);
        for (int i = 0; i < block->n; i++) {
            const double command = psp_limited(told[i], block->a_min[i], block->a_max[i]);
            a[i] = psp_approached(a[i], command, block->gone[block->lags == LAGS ? i : 0]);
        }
    }
}

void actuators_drive(Actuators *actuators, const Actuation *actuation, int n, double tau, const Foreign *foreign, double *v,
                     double *moved)
{
    Block block = {.lags = lags_of(actuation, n)};
    Pieces all = pieces(actuators, tau);
    for (int i = 0; i < n; i += BLOCK) {
        all = pieces(actuators, tau);
        choose_block(&block, actuation, NULL, foreign, n, i);
        drive_block(&block, &all, v + i, moved + i, actuators->a + i);
    }
    leave_behind(actuators, &all);
}

void actuators_foresee(const Actuators *actuators, const int32_t *places, const Actuation *actuation, int n, double wait,
                       double tau, const Foreign *foreign, double *v, double *moved, double *a, double *command)
{
    Block block = {.lags = lags_of(actuation, n)};
    for (int i = 0; i < n; i += BLOCK) {
        Pieces all = pieces(actuators, wait > 0.0 ? wait : tau);
        choose_block(&block, actuation, places, foreign, n, i);
        const size_t size = (size_t)block.n * sizeof *a;
        memcpy(a + i, of_members(&block, actuators->a), size);
        if (wait > 0.0) {
            settle_block(&block, &all, a + i);
            all = pieces_after(&all, tau);
        }
        drive_block(&block, &all, v + i, moved + i, a + i);
        memcpy(command + i, of_members(&block, all.command), size);
    }
}

void actuators_settle(Actuators *actuators, const Actuation *actuation, int n, double tau)
{
    Block block = {.lags = lags_of(actuation, n)};
    Pieces all = pieces(actuators, tau);
    for (int i = 0; i < n; i += BLOCK) {
        all = pieces(actuators, tau);
        choose_block(&block, actuation, NULL, NULL, n, i);
        settle_block(&block, &all, actuators->a + i);
    }
    leave_behind(actuators, &all);
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
