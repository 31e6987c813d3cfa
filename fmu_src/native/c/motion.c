/* Feedback, Lemma 1 and motion of n vehicles: mirrors psp_model/law/feedback.py,
 * psp_model/sampling/lemma1.py and psp_model/sampling/period.py.
 *
 * The loops are inlined twice: for PSP_N vehicles, a number that the compiler knows, and for any number. */
#include "vehicles.h"

#include <math.h>

#include "psp_kernels.h"
#include "slope.h"

static double smaller(double a, double b) { return b < a ? b : a; }

/* `v_desired` below 0 stands for v_star; the least of the bounds that gaps and speeds set are put into `of_gaps` and
 * `of_speeds`. */
static inline void feedback_of(const Constants *constants, const Shape *shape, int n, const double *restrict gaps,
                               const double *restrict v, double v_desired, double *restrict a, double *of_gaps,
                               double *of_speeds)
{
    const Constants c = *constants;
    const Shape h = *shape;
    double slope_in_front = 0.0, gap_bound = INFINITY, speed_bound = INFINITY;
    for (int i = 0; i < n; i++) {
        double slope_behind = 0.0;
        if (i < n - 1) {
            const double s = gaps[i];
            slope_behind = slope_at(&c, &h, s);
            gap_bound = smaller(gap_bound, psp_gap_bound(s, c.L, c.v_max));
        }
        const double u = slope_in_front - slope_behind;
        a[i] = v_desired < 0.0 ? psp_command(u, v[i], c.v_star, c.v_max, c.epsilon, c.mu)
                               : psp_command_towards(u, v[i], v_desired, c.v_max, c.epsilon, c.mu);
        speed_bound = smaller(speed_bound, psp_speed_bound(v[i], a[i], c.v_max));
        slope_in_front = slope_behind;
    }
    *of_gaps = gap_bound;
    *of_speeds = speed_bound;
}

double feedback_bounds(const Constants *constants, const Shape *shape, int n, const double *s, const double *v, double *a,
                       double *of_speeds)
{
    double of_gaps;
    if (n == PSP_N) feedback_of(constants, shape, PSP_N, s, v, -1.0, a, &of_gaps, of_speeds);
    else feedback_of(constants, shape, n, s, v, -1.0, a, &of_gaps, of_speeds);
    return smaller(of_gaps, *of_speeds);
}

double feedback(const Constants *constants, const Shape *shape, int n, const double *s, const double *v, double *a)
{
    double of_speeds;
    return feedback_bounds(constants, shape, n, s, v, a, &of_speeds);
}

double feedback_towards(const Constants *constants, const Shape *shape, int n, const double *s, const double *v,
                        double v_desired, double *a)
{
    double of_gaps, of_speeds;
    feedback_of(constants, shape, n, s, v, v_desired, a, &of_gaps, &of_speeds);
    return smaller(of_gaps, of_speeds);
}

double largest_period(const Constants *constants, int n, const double *s, const double *v, const double *a)
{
    double T_max = INFINITY;
    for (int i = 0; i < n - 1; i++) T_max = smaller(T_max, psp_gap_bound(s[i], constants->L, constants->v_max));
    for (int i = 0; i < n; i++) T_max = smaller(T_max, psp_speed_bound(v[i], a[i], constants->v_max));
    return T_max;
}

static inline void pass_time_of(const Weights *weights, int n, Instant *at, double tau)
{
    const Weights w = *weights;
    const double dv = at->v[0] - at->v[n - 1], da = at->a[0] - at->a[n - 1];
    double moved_front = psp_travelled(at->v[0], at->a[0], tau), gaps = 0.0, squares = at->a[0] * at->a[0];
    at->x += moved_front;
    at->v[0] = psp_speed_after(at->v[0], at->a[0], tau);
    for (int i = 1; i < n; i++) {
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

void pass_time(const Weights *weights, Instant *at, double tau)
{
    if (at->n == PSP_N) pass_time_of(weights, PSP_N, at, tau);
    else pass_time_of(weights, (int)at->n, at, tau);
}

double locate(double time, double T, double *fraction)
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
