/* Vehicles that act late and softly: mirrors psp_model/vehicles/actuation.py.
 *
 * There a platoon is driven from command to command.  Here a block of vehicles is, through all commands, before the next
 * block; what is done to a block under one command is written once and inlined for lags that are absent, alike or different,
 * so that the compiler can vectorise it. */
#include "actuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "pieces.h"
#include "psp_kernels.h"
#include "ride.h"

enum { BLOCK = 128 };

typedef enum { NO_LAG, ONE_LAG, LAGS } Lags;

/* The actuators at the end of the pieces, their accelerations aside. */
static void leave_behind(Actuators *actuators, const Pieces *all)
{
    if (all->command != actuators->command) memcpy(actuators->command, all->command, sizeof actuators->command);
    if (actuators->rows == 0) return;
    actuators->first = (actuators->first + all->next) % actuators->rows;
    actuators->count -= all->next;
    for (int64_t k = 0; k < actuators->count; k++) actuators->queue[row_of(actuators, k)].due -= all->tau;
}

static Lags lags_of(const Actuation *actuation, int n)
{
    const double *lag = actuation->actuator_lag;
    for (int i = 1; i < n; i++) {
        if (lag[i] != lag[0]) return LAGS;
    }
    return lag[0] > 0.0 ? ONE_LAG : NO_LAG;
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
        if (stopping && stops) ride_with_stop(from, begins, command, lag, span, &then, &further);
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
