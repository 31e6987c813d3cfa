/* Feedback, Lemma 1 and motion of n vehicles: mirrors psp_model/law/feedback.py,
 * psp_model/sampling/lemma1.py and psp_model/sampling/period.py.
 *
 * The loops are inlined twice: for PSP_N vehicles, a number that the compiler knows, and for any number. */
#include "vehicles.h"

#include <math.h>

#include "psp_kernels.h"
#include "slope.h"
#include "speeds.h"

/* `v_desired` below 0 stands for v_star. */
static inline double feedback_of(const Constants *constants, const Shape *shape, int n, const double *restrict spacings,
                                 const double *restrict v, double v_desired, double *restrict a)
{
    const Constants c = *constants;
    const Shape h = *shape;
    double slope_in_front = 0.0, least = INFINITY; /* the smallest spacing sets the least of the spacings' bounds */
    for (int i = 0; i < n; i++) {
        double slope_behind = 0.0;
        if (i < n - 1) {
            const double s = spacings[i];
            slope_behind = slope_at(&c, &h, s);
            least = smaller(least, s);
        }
        const double u = slope_in_front - slope_behind;
        a[i] = v_desired < 0.0 ? psp_command(u, v[i], c.v_star, c.v_max, c.epsilon, c.mu)
                               : psp_command_towards(u, v[i], v_desired, c.v_max, c.epsilon, c.mu);
        slope_in_front = slope_behind;
    }
    return with_speeds(psp_spacing_period(least, c.L, c.v_max), c.v_max, 0, n, v, a);
}

double feedback(const Constants *constants, const Shape *shape, int n, const double *s, const double *v, double *a)
{
    return n == PSP_N ? feedback_of(constants, shape, PSP_N, s, v, -1.0, a)
                      : feedback_of(constants, shape, n, s, v, -1.0, a);
}

double feedback_towards(const Constants *constants, const Shape *shape, int n, const double *s, const double *v,
                        double v_desired, double *a)
{
    return feedback_of(constants, shape, n, s, v, v_desired, a);
}

double largest_period(const Constants *constants, int n, const double *s, const double *v, const double *a)
{
    double least = INFINITY;
    for (int i = 0; i < n - 1; i++) least = smaller(least, s[i]);
    return with_speeds(psp_spacing_period(least, constants->L, constants->v_max), constants->v_max, 0, n, v, a);
}

static inline void pass_time_of(const Weights *weights, int n, Instant *at, double tau)
{
    const Weights w = *weights;
    const double dv = at->v[0] - at->v[n - 1], da = at->a[0] - at->a[n - 1];
    double moved_front = psp_travelled(at->v[0], at->a[0], tau), spacings = 0.0, squares = at->a[0] * at->a[0];
    at->x += moved_front;
    at->v[0] = psp_speed_after(at->v[0], at->a[0], tau);
    for (int i = 1; i < n; i++) {
        const double v = at->v[i], a = at->a[i], s = at->s[i - 1], moved = psp_travelled(v, a, tau);
        spacings += s;
        squares += a * a;
        at->s[i - 1] = psp_spacing_after(s, moved_front, moved);
        at->v[i] = psp_speed_after(v, a, tau);
        moved_front = moved;
    }
    at->cost_acceleration += psp_acceleration_cost(squares, tau, w.w1, w.a_ref);
    at->cost_spacings += psp_spacing_cost(spacings, dv, da, tau, w.w2, w.s_ref);
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
