/* Directional derivatives of the outputs at the first instant with respect to the parameters. */
#include <stdlib.h>

#include "native_model.h"

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
    const int n = (int)platoon->now.n;
    for (int i = 0; i < n; i++) {
        const int spacing = i; /* the spacing behind vehicle i + 1 */
        double u = 0.0, du = 0.0;
        if (i > 0) {
            change[PSP_s + i - 1] = seed[PSP_s_start + i - 1];
            change[PSP_x + i] = change[PSP_x + i - 1] - change[PSP_s + i - 1];
            u += slope(platoon, spacing - 1);
            du += slope_change(platoon, seed, spacing - 1);
        }
        if (i < n - 1) {
            u -= slope(platoon, spacing);
            du -= slope_change(platoon, seed, spacing);
        }
        change[PSP_v + i] = seed[PSP_v_start + i];
        change[PSP_a + i] =
            psp_command_tangent(u, platoon->now.v[i], c.v_star, c.v_max, c.epsilon, c.mu, du, seed[PSP_v_start + i],
                                seed[PSP_v_star], seed[PSP_v_max], seed[PSP_epsilon], seed[PSP_mu]);
    }
}

/* The change of the bound that a speed sets, the first of those that are `bound`. */
static double speed_change(const Platoon *platoon, const double *seed, const double *change, double bound)
{
    const Instant *now = &platoon->now;
    const double v_max = platoon->constants.v_max;
    for (int i = 0; i < now->n && bound < LONGEST; i++) {
        if (psp_speed_bound(now->v[i], now->a[i], v_max) == bound)
            return psp_speed_bound_tangent(now->v[i], now->a[i], v_max, seed[PSP_v_start + i], change[PSP_a + i],
                                           seed[PSP_v_max]);
    }
    return 0.0;
}

/* The change of the bound that T_max is, the first of equals. */
static double bound_change(const Platoon *platoon, const double *seed, const double *change)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, v_max = platoon->constants.v_max;
    for (int i = 0; i < now->n - 1; i++) {
        if (psp_spacing_period(now->s[i], L, v_max) == now->T_max)
            return psp_spacing_period_tangent(now->s[i], L, v_max, seed[PSP_s_start + i], seed[PSP_L], seed[PSP_v_max]);
    }
    return speed_change(platoon, seed, change, now->T_max);
}

/* The change of the bound that T_exact is, the first of equals. */
static double exact_change(const Platoon *platoon, const double *seed, const double *change)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, T_exact = platoon_exact(platoon);
    for (int i = 0; i < now->n - 1 && T_exact < LONGEST; i++) {
        const double left = now->s[i] - L, b = now->v[i] - now->v[i + 1], a = now->a[i] - now->a[i + 1];
        if (psp_first_contact(left, b, a) == T_exact)
            return psp_first_contact_tangent(left, b, a, seed[PSP_s_start + i] - seed[PSP_L],
                                             seed[PSP_v_start + i] - seed[PSP_v_start + i + 1],
                                             change[PSP_a + i] - change[PSP_a + i + 1]);
    }
    return speed_change(platoon, seed, change, T_exact);
}

void platoon_tangent(const Platoon *platoon, const double *seed, double *change)
{
    for (int i = PSP_FIRST_OUTPUT; i < PSP_COUNT; i++) change[i] = 0.0;
    motion_change(platoon, seed, change);
    change[PSP_T_max] = bound_change(platoon, seed, change);
    change[PSP_T_exact] = exact_change(platoon, seed, change);
    if (platoon->shape.hill != 0.0) {
        change[PSP_alpha] = seed[PSP_alpha_fixed];
        change[PSP_r] = seed[PSP_r_fixed];
        change[PSP_p] = seed[PSP_p_fixed];
    }
}

/* Outputs that depend on how alpha, r, p were chosen. */
static bool depends_on_choice(fmi2ValueReference reference)
{
    return (reference >= PSP_a && reference < PSP_a + PSP_N) || reference == PSP_alpha || reference == PSP_r ||
           reference == PSP_p || reference == PSP_T_max || reference == PSP_T_exact;
}

/* Parameters that only the extended law has. */
static bool is_of_extended_law(fmi2ValueReference reference)
{
    return reference == PSP_kappa || reference == PSP_kappa_reach || reference == PSP_closing_speed ||
           reference == PSP_closing_spacing || reference == PSP_closing_reach ||
           (reference >= PSP_length && reference < PSP_length + PSP_N);
}

/* Whether the law is the paper's by the values of the variables, so that outputs have their derivatives here. */
static bool is_papers(const double *values)
{
    bool papers = values[PSP_kappa] == 0.0 && values[PSP_closing_speed] == 0.0 && values[PSP_leader_automated] >= 0.5;
    for (int i = 0; i < PSP_N; i++) papers = papers && values[PSP_length + i] == 0.0; /* L, whatever becomes of it */
    return papers;
}

static bool derivable(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                      const fmi2ValueReference knowns[], size_t known_count)
{
    const double *values = backend->model.values;
    const bool chosen = values[PSP_potential] == 2.0 && values[PSP_parameter_source] != 2.0;
    bool initial = false; /* inputs act when the next step begins: no output has a derivative by them */
    for (size_t i = 0; i < known_count; i++) {
        if (knowns[i] >= PSP_FIRST_OUTPUT || native_is_integer(knowns[i])) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative knows no derivative with respect to value reference "
                                       "%d: name Real parameters or inputs", (int)knowns[i]);
            return false;
        }
        if (is_of_extended_law(knowns[i])) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative knows no derivative with respect to %s: leave it out",
                       PSP_VARIABLE_NAMES[knowns[i]]);
            return false;
        }
        initial = initial || knowns[i] < PSP_FIRST_INPUT;
    }
    if (initial && !is_papers(values)) {
        front_fail(backend->front, "fmi2GetDirectionalDerivative knows the derivatives of the paper's law only: set kappa "
                                   "and closing_speed to 0, length to 0 and leader_automated to 1, or use differences");
        return false;
    }
    for (size_t i = 0; i < unknown_count; i++) {
        if (unknowns[i] < PSP_FIRST_OUTPUT || unknowns[i] >= PSP_COUNT) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative knows no derivative of value reference %d: name "
                                       "outputs", (int)unknowns[i]);
            return false;
        }
        if (chosen && initial && depends_on_choice(unknowns[i])) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative has no derivative of %s while alpha, r, p come from "
                                       "the network: set parameter_source to 2", PSP_VARIABLE_NAMES[unknowns[i]]);
            return false;
        }
    }
    if (initial && !backend->model.initialising)
        front_fail(backend->front, "fmi2GetDirectionalDerivative with respect to initial values is for initialization "
                                   "mode: afterwards outputs depend on inputs only, by which they have no derivative");
    return !initial || backend->model.initialising;
}

fmi2Status backend_directional_derivative(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    Model *model = &backend->model;
    if (!derivable(backend, unknowns, unknown_count, knowns, known_count)) return fmi2Error;
    if (model->initialising && !native_make_ready(backend)) return fmi2Error;
    double *work = calloc(2 * PSP_COUNT, sizeof *work); /* a seed and a change for every variable */
    if (!work) return front_fail(backend->front, "there is no memory left for derivatives: free some instances");
    for (size_t i = 0; i < known_count; i++) work[knowns[i]] += seed[i];
    if (known_count > 0 && model->initialising) platoon_tangent(&model->part.platoon, work, work + PSP_COUNT);
    for (size_t i = 0; i < unknown_count; i++) sensitivity[i] = work[PSP_COUNT + unknowns[i]];
    free(work);
    return fmi2OK;
}
