/* Follows many starts under policy 3 with the native FMU's own clock and formulas, and looks at every sampling instant.
 *
 * A row of `starts` holds L, lambda, v_star, v_max, epsilon, mu, z, alpha, r, p, hill, T, then n-1 spacings and n speeds;
 * a row of `ends` gets what became of it (enum End), then the spacings and speeds at the end.
 */
#include <math.h>
#include <string.h>

#include "platoon.h"

enum { GIVEN = 12 };
enum End { FATE, PERIOD, INSTANTS, MOST_SHORT, ROOM, AT_END };
enum Fate { FINE, LEFT_OMEGA, NOT_FINITE, STALLED };

static enum Fate look(const Platoon *platoon, double *room)
{
    const Instant *now = &platoon->now;
    const Constants *c = &platoon->constants;
    for (int64_t i = 0; i < now->n; i++) {
        if (!isfinite(now->v[i]) || !isfinite(now->a[i])) return NOT_FINITE;
        if (now->v[i] < 0.0 || now->v[i] > c->v_max) return LEFT_OMEGA;
    }
    for (int64_t i = 0; i < now->n - 1; i++) {
        if (!isfinite(now->s[i])) return NOT_FINITE;
        if (!(now->s[i] > c->L)) return LEFT_OMEGA;
        *room = fmin(*room, now->s[i] - c->L);
    }
    return isfinite(now->T_max) && isfinite(now->x) ? FINE : NOT_FINITE;
}

/* One sampling instant further: platoon_advance to the very time at which the next one is. */
static bool next(Platoon *platoon, Front *front)
{
    const double ends = platoon->now.fraction + platoon->now.span;
    const bool whole = ends >= 1.0;
    Instant scratch;
    front->partly = false;
    return platoon_advance(platoon, front, platoon->now.period + whole, whole ? 0.0 : ends, &scratch) == fmi2OK;
}

static Platoon begin(int n, const double *row)
{
    Platoon platoon = {.policy = POLICY_SHORTEN, .max_short_periods = 1, .T = row[11]};
    memcpy(&platoon.constants, row, sizeof platoon.constants);
    memcpy(&platoon.shape, row + 7, sizeof platoon.shape);
    platoon.now.n = n;
    memcpy(platoon.now.s, row + GIVEN, (size_t)(n - 1) * sizeof(double));
    memcpy(platoon.now.v, row + GIVEN + n - 1, (size_t)n * sizeof(double));
    platoon.weights = (Weights){0.5, 0.5, 4.0, 20.0};
    return platoon;
}

void follow(int n, int count, int periods, int stall, const double *starts, double *ends)
{
    Front front = {0}; /* no logger */
    for (int k = 0; k < count; k++, starts += GIVEN + 2 * n - 1, ends += AT_END + 2 * n - 1) {
        Platoon platoon = begin(n, starts);
        double instants = 1.0, shortened = 0.0, most = 0.0, room = INFINITY;
        bool going = platoon_sample(&platoon, &front, fmi2Error);
        enum Fate fate = look(&platoon, &room);
        while (fate == FINE && going && platoon.now.period < periods) {
            const int64_t period = platoon.now.period;
            going = next(&platoon, &front);
            fate = look(&platoon, &room);
            shortened = platoon.now.period == period ? shortened + 1.0 : 0.0;
            most = fmax(most, shortened);
            instants += 1.0;
            if (shortened > stall || !going) fate = fate == FINE ? STALLED : fate;
        }
        const double found[] = {fate, (double)platoon.now.period, instants, most, room};
        memcpy(ends, found, sizeof found);
        memcpy(ends + AT_END, platoon.now.s, (size_t)(n - 1) * sizeof(double));
        memcpy(ends + AT_END + n - 1, platoon.now.v, (size_t)n * sizeof(double));
    }
}
