/* From the values of the variables to constants, weights and the choice of the potential: mirrors
 * fmu_src/interface/meaning.py and the checks of psp_model/validate.py. */
#include "vehicles.h"

#include <math.h>

double printable(double value) { return isnan(value) ? (double)NAN : value; }

bool finite_or_log(Front *front, const char *name, double value, const char *unit)
{
    if (isfinite(value)) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_finite, name, printable(value), unit);
    return false;
}

bool read_period(Front *front, const double *read, double *T)
{
    *T = read[PSP_T];
    if (!finite_or_log(front, "T", *T, "s")) return false;
    REQUIRE(*T > 0.0, PSP_SENTENCE_T, *T);
    return true;
}

bool read_constants(Front *front, const double *read, Constants *c)
{
    *c = (Constants){read[PSP_L],     read[PSP_lambda], read[PSP_v_star], read[PSP_v_max],
                     read[PSP_epsilon], read[PSP_mu],     read[PSP_z]};
    const double values[] = {c->L, c->lam, c->v_star, c->v_max, c->epsilon, c->mu, c->z};
    const char *const names[] = {"L", "lambda", "v_star", "v_max", "epsilon", "mu", "z"};
    const char *const units[] = {"m", "m", "m/s", "m/s", "m/s2", "1/s", "m/s2"};
    for (int i = 0; i < 7; i++) {
        if (!finite_or_log(front, names[i], values[i], units[i])) return false;
    }
    REQUIRE(c->L > 0.0, PSP_SENTENCE_L, c->L);
    REQUIRE(c->lam > c->L + 3.0, PSP_SENTENCE_lambda, c->lam, c->L + 3.0);
    REQUIRE(c->v_max > 0.0, PSP_SENTENCE_v_max, c->v_max);
    REQUIRE(c->v_star > 0.0, PSP_SENTENCE_v_star_backwards, c->v_star, c->v_max);
    REQUIRE(c->v_star < c->v_max, PSP_SENTENCE_v_star, c->v_star, c->v_max);
    REQUIRE(c->epsilon > 0.0, PSP_SENTENCE_epsilon, c->epsilon);
    REQUIRE(c->mu > 0.0, PSP_SENTENCE_mu, c->mu);
    REQUIRE(c->z > 0.0, PSP_SENTENCE_z, c->z);
    return true;
}

bool read_weights(Front *front, const double *read, Weights *w)
{
    *w = (Weights){read[PSP_w1], read[PSP_w2], read[PSP_a_ref], read[PSP_s_ref]};
    const double values[] = {w->w1, w->w2, w->a_ref, w->s_ref};
    const char *const names[] = {"w1", "w2", "a_ref", "s_ref"};
    const char *const units[] = {"1", "1", "m/s2", "m"};
    for (int i = 0; i < 4; i++) {
        if (!finite_or_log(front, names[i], values[i], units[i])) return false;
    }
    REQUIRE(w->w1 >= 0.0, PSP_SENTENCE_w1, w->w1);
    REQUIRE(w->w2 >= 0.0, PSP_SENTENCE_w2, w->w2);
    REQUIRE(w->a_ref > 0.0, PSP_SENTENCE_a_ref, w->a_ref);
    REQUIRE(w->s_ref > 0.0, PSP_SENTENCE_s_ref, w->s_ref);
    return true;
}

/* An Integer parameter, checked against the bounds of its row. */
bool read_choice(Front *front, const char *name, double value, int low, int high, int *chosen)
{
    *chosen = (int)value;
    if (high < low) REQUIRE(*chosen >= low, PSP_SENTENCE_count, name, *chosen);
    else REQUIRE(low <= *chosen && *chosen <= high, PSP_SENTENCE_choice, name, *chosen, low, high);
    return true;
}

bool read_request(Front *front, const double *read, Request *request)
{
    int potential;
    request->fixed = (Shape){read[PSP_alpha_fixed], read[PSP_r_fixed], read[PSP_p_fixed], 1.0};
    request->horizon = read[PSP_rollout_horizon];
    request->quiet = false;
    if (!read_choice(front, "potential", read[PSP_potential], 1, 2, &potential) ||
        !read_choice(front, "parameter_source", read[PSP_parameter_source], 1, 3, &request->source) ||
        !finite_or_log(front, "alpha", request->fixed.alpha, "1") || !finite_or_log(front, "r", request->fixed.r, "m") ||
        !finite_or_log(front, "p", request->fixed.p, "1") ||
        !read_choice(front, "rollout_count", read[PSP_rollout_count], 1, 1000, &request->rollouts))
        return false;
    request->old = potential == 1;
    REQUIRE(request->horizon > 0.0 && isfinite(request->horizon), PSP_SENTENCE_horizon, request->horizon);
    return true;
}
