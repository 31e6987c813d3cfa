/* From the values of the variables to constants, weights and the choice of the potential: mirrors
 * fmu_src/interface/meaning.py and the checks of psp_model/validate.py. */
#include "vehicles.h"

#include <math.h>

/* With the lists of fields: a field from its variable, or from its variable_fixed; whether the field of `taken` is finite. */
#define TAKE(field, variable, unit) .field = read[PSP_##variable],
#define TAKE_FIXED(field, variable, unit) .field = read[PSP_##variable##_fixed],
#define AND_FINITE(field, variable, unit) &&finite_or_log(front, #variable, taken->field, unit)

bool finite_triple(Front *front, const Shape *taken) { return true PSP_TRIPLE_FIELDS(AND_FINITE); }

bool read_constants(Front *front, const double *read, Constants *taken)
{
    const Constants *const c = taken;
    *taken = (Constants){PSP_CONSTANTS_FIELDS(TAKE)};
    if (!(true PSP_CONSTANTS_FIELDS(AND_FINITE))) return false;
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

bool read_weights(Front *front, const double *read, Weights *taken)
{
    const Weights *const w = taken;
    *taken = (Weights){PSP_WEIGHTS_FIELDS(TAKE)};
    if (!(true PSP_WEIGHTS_FIELDS(AND_FINITE))) return false;
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
    request->fixed = (Shape){PSP_TRIPLE_FIELDS(TAKE_FIXED).hill = 1.0};
    request->horizon = read[PSP_rollout_horizon];
    request->quiet = false;
    if (!read_choice(front, "potential", read[PSP_potential], 1, 2, &potential) ||
        !read_choice(front, "parameter_source", read[PSP_parameter_source], 1, 3, &request->source) ||
        !finite_triple(front, &request->fixed) ||
        !read_choice(front, "rollout_count", read[PSP_rollout_count], 1, 1000, &request->rollouts))
        return false;
    request->old = potential == 1;
    REQUIRE(request->horizon > 0.0 && isfinite(request->horizon), PSP_SENTENCE_horizon, request->horizon);
    return true;
}
