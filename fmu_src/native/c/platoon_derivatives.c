/* Directional derivatives of the outputs at the first instant with respect to the parameters. */
#include "platoon.h"

#include "psp_kernels.h"

/* V'(s_i) and its change. */
static double slope_change(const Platoon *platoon, const double *seed, int i)
{
    const Constants c = platoon->constants;
    const Shape h = platoon->shape;
    const double given = h.hill; /* 1, or 0 with V_old, which takes no notice of the fixed triple */
    return psp_slope_tangent(platoon->now.s[i], h.alpha, h.r, h.p, h.hill, c.L, c.lam, seed[PSP_s_start + i],
                             given * seed[PSP_alpha_fixed], given * seed[PSP_r_fixed], given * seed[PSP_p_fixed], 0.0,
                             seed[PSP_L], seed[PSP_lambda]);
}

static double slope(const Platoon *platoon, int i)
{
    const Constants c = platoon->constants;
    const Shape h = platoon->shape;
    return psp_slope(platoon->now.s[i], h.alpha, h.r, h.p, h.hill, c.L, c.lam);
}

static void motion_change(const Platoon *platoon, const double *seed, double *change)
{
    const Constants c = platoon->constants;
    change[PSP_x] = seed[PSP_x_start];
    for (int i = 0; i < PSP_N; i++) {
        const int gap = i; /* the gap behind vehicle i + 1 */
        double u = 0.0, du = 0.0;
        if (i > 0) {
            change[PSP_s + i - 1] = seed[PSP_s_start + i - 1];
            change[PSP_x + i] = change[PSP_x + i - 1] - change[PSP_s + i - 1];
            u += slope(platoon, gap - 1);
            du += slope_change(platoon, seed, gap - 1);
        }
        if (i < PSP_N - 1) {
            u -= slope(platoon, gap);
            du -= slope_change(platoon, seed, gap);
        }
        change[PSP_v + i] = seed[PSP_v_start + i];
        change[PSP_a + i] =
            psp_command_tangent(u, platoon->now.v[i], c.v_star, c.v_max, c.epsilon, c.mu, du, seed[PSP_v_start + i],
                                seed[PSP_v_star], seed[PSP_v_max], seed[PSP_epsilon], seed[PSP_mu]);
    }
}

/* The change of the bound that T_max is, the first of equals. */
static double bound_change(const Platoon *platoon, const double *seed, const double *change)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, v_max = platoon->constants.v_max;
    for (int i = 0; i < PSP_N - 1; i++) {
        if (psp_gap_bound(now->s[i], L, v_max) == now->T_max)
            return psp_gap_bound_tangent(now->s[i], L, v_max, seed[PSP_s_start + i], seed[PSP_L], seed[PSP_v_max]);
    }
    for (int i = 0; i < PSP_N; i++) {
        if (psp_speed_bound(now->v[i], now->a[i], v_max) == now->T_max)
            return psp_speed_bound_tangent(now->v[i], now->a[i], v_max, seed[PSP_v_start + i], change[PSP_a + i],
                                           seed[PSP_v_max]);
    }
    return 0.0;
}

void platoon_tangent(const Platoon *platoon, const double *seed, double *change)
{
    for (int i = PSP_FIRST_OUTPUT; i < PSP_COUNT; i++) change[i] = 0.0;
    motion_change(platoon, seed, change);
    change[PSP_T_max] = bound_change(platoon, seed, change);
    if (platoon->shape.hill != 0.0) {
        change[PSP_alpha] = seed[PSP_alpha_fixed];
        change[PSP_r] = seed[PSP_r_fixed];
        change[PSP_p] = seed[PSP_p_fixed];
    }
}
