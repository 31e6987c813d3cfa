/* The sampling clock: mirrors psp_model/platoon.py. */
#include "platoon.h"

#include <math.h>

#include "psp_kernels.h"

#define SHORTEST 0x1p-60 /* [sampling periods] no period is cut further than this */

static double smaller(double a, double b) { return b < a ? b : a; }

void platoon_feedback(const Platoon *platoon, Instant *at)
{
    const Constants c = platoon->constants;
    const Shape h = platoon->shape;
    double slope_in_front = 0.0, T_max = INFINITY;
    for (int i = 0; i < PSP_N; i++) {
        double slope_behind = 0.0;
        if (i < PSP_N - 1) {
            const double s = at->s[i];
            slope_behind = h.hill != 0.0 && psp_on_hill(s, h.r) != 0.0
                               ? psp_slope(s, h.alpha, h.r, h.p, h.hill, c.L, c.lam)
                               : psp_slope_off_hill(s, h.alpha, c.L, c.lam);
            T_max = smaller(T_max, psp_gap_bound(s, c.L, c.v_max));
        }
        at->a[i] = psp_command(slope_in_front - slope_behind, at->v[i], c.v_star, c.v_max, c.epsilon, c.mu);
        T_max = smaller(T_max, psp_speed_bound(at->v[i], at->a[i], c.v_max));
        slope_in_front = slope_behind;
    }
    at->T_max = T_max;
}

void platoon_pass(const Platoon *platoon, Instant *at, double tau)
{
    const Weights w = platoon->weights;
    const double dv = at->v[0] - at->v[PSP_N - 1], da = at->a[0] - at->a[PSP_N - 1];
    double moved_front = psp_travelled(at->v[0], at->a[0], tau), gaps = 0.0, squares = at->a[0] * at->a[0];
    at->x += moved_front;
    at->v[0] = psp_speed_after(at->v[0], at->a[0], tau);
    for (int i = 1; i < PSP_N; i++) {
        const double v = at->v[i], a = at->a[i], s = at->s[i - 1], moved = psp_travelled(v, a, tau);
        gaps += s;
        squares += a * a;
        at->s[i - 1] = psp_gap_after(s, moved_front, moved);
        at->v[i] = psp_speed_after(v, a, tau);
        moved_front = moved;
    }
    at->cost_acceleration += psp_acceleration_cost(squares, tau, w.w1, w.a_ref);
    at->cost_gaps += psp_gap_cost(gaps, dv, da, tau, w.w2, w.s_ref);
}

double platoon_locate(double time, double T, double *fraction)
{
    const double periods = time / T;
    *fraction = 0.0;
    if (!(fabs(periods) < PERIODS_MAX)) return periods;
    const double nearest = (double)(int64_t)(periods + 0.5); /* no call of the mathematical library: it costs */
    if (fabs(periods - nearest) <= TIME_TOLERANCE) return nearest;
    const double whole = (double)(int64_t)periods;
    *fraction = periods - whole;
    return whole;
}

/* With policy 2 a run may leave the model's domain; the other policies keep every gap above L. */
static bool gaps_are_open(const Platoon *platoon, Front *front)
{
    const Instant *now = &platoon->now;
    int least = 0;
    if (platoon->policy != POLICY_WARN) return true;
    for (int i = 1; i < PSP_N - 1; i++) {
        if (now->s[i] < now->s[least]) least = i;
    }
    if (now->s[least] > platoon->constants.L) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_left_gap, least + 2, now->s[least], platoon->constants.L,
              ((double)now->period + now->fraction) * platoon->T);
    return false;
}

/* Feedback and Lemma 1 at the instant `now`. */
static bool sample(Platoon *platoon, Front *front)
{
    Instant *now = &platoon->now;
    const double T = platoon->T, last_T_max = now->T_max;
    if (!gaps_are_open(platoon, front)) return false;
    platoon_feedback(platoon, now);
    const bool certified = now->T_max > T;
    double span = 1.0;
    if (platoon->policy == POLICY_SHORTEN) {
        while (!(span * T < now->T_max) && span > SHORTEST) span *= 0.5;
        span = smaller(span, 1.0 - now->fraction);
    }
    const bool begins = !certified && (now->violations == 0 || last_T_max > T);
    now->span = span;
    now->violations += !certified;
    if (certified || platoon->policy == POLICY_SHORTEN) return true;
    if (platoon->policy == POLICY_ERROR || begins)
        platoon_log_violation(platoon, front, platoon->policy == POLICY_ERROR ? fmi2Error : fmi2Warning);
    return platoon->policy != POLICY_ERROR;
}

bool platoon_start(Platoon *platoon, Front *front) { return sample(platoon, front); }

static bool too_many_short_periods(const Platoon *platoon, Front *front, int64_t short_periods)
{
    const Instant *now = &platoon->now;
    if (short_periods <= platoon->max_short_periods && now->span > SHORTEST) return false;
    front_log(front, fmi2Error, PSP_SENTENCE_short_periods, (int)platoon->max_short_periods,
              ((double)now->period + now->fraction) * platoon->T, now->T_max);
    return true;
}

bool platoon_advance(Platoon *platoon, Front *front, int64_t period, double fraction)
{
    Instant *now = &platoon->now;
    for (int64_t short_periods = 0;;) {
        const double ends = now->fraction + now->span;
        const int64_t next_period = ends >= 1.0 ? now->period + 1 : now->period;
        const double next_fraction = ends >= 1.0 ? 0.0 : ends;
        if (next_period > period || (next_period == period && next_fraction > fraction)) return true;
        if (now->span < 1.0 && ends < 1.0 && too_many_short_periods(platoon, front, ++short_periods)) return false;
        platoon_pass(platoon, now, now->span * platoon->T);
        now->period = next_period;
        now->fraction = next_fraction;
        if (!sample(platoon, front)) return false;
    }
}
