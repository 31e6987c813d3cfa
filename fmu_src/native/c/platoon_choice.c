/* From parameters to a platoon: the checks of psp_model/parameters.py and state.py, and psp_model/choose.py. */
#include "platoon.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool finite_or_log(Front *front, const char *name, double value, const char *unit)
{
    if (isfinite(value)) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_finite, name, isnan(value) ? (double)NAN : value, unit);
    return false;
}

/* Logs a sentence that takes the value and perhaps a limit, unless `holds`. */
#define REQUIRE(holds, ...)                                                                                            \
    do {                                                                                                               \
        if (!(holds)) {                                                                                                \
            front_log(front, fmi2Error, __VA_ARGS__);                                                                  \
            return false;                                                                                              \
        }                                                                                                              \
    } while (0)

static bool check_constants(Front *front, const Constants *c)
{
    const double values[] = {c->L, c->lam, c->v_star, c->v_max, c->epsilon, c->mu, c->z};
    const char *const names[] = {"L", "lambda", "v_star", "v_max", "epsilon", "mu", "z"};
    const char *const units[] = {"m", "m", "m/s", "m/s", "m/s2", "1/s", "m/s2"};
    for (int i = 0; i < 7; i++) {
        if (!finite_or_log(front, names[i], values[i], units[i])) return false;
    }
    REQUIRE(c->L > 0.0, PSP_SENTENCE_L, c->L);
    REQUIRE(c->lam > c->L + 3.0, PSP_SENTENCE_lambda, c->lam, c->L + 3.0);
    REQUIRE(c->v_max > 0.0, PSP_SENTENCE_v_max, c->v_max);
    REQUIRE(0.0 < c->v_star && c->v_star < c->v_max, PSP_SENTENCE_v_star, c->v_star, c->v_max);
    REQUIRE(c->epsilon > 0.0, PSP_SENTENCE_epsilon, c->epsilon);
    REQUIRE(c->mu > 0.0, PSP_SENTENCE_mu, c->mu);
    REQUIRE(c->z > 0.0, PSP_SENTENCE_z, c->z);
    return true;
}

static bool check_weights(Front *front, const Weights *w)
{
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
static bool choice(Front *front, const double *values, const char *name, int reference, int low, int high, int *chosen)
{
    *chosen = (int)values[reference];
    if (high < low) REQUIRE(*chosen >= low, PSP_SENTENCE_count, name, *chosen);
    else REQUIRE(low <= *chosen && *chosen <= high, PSP_SENTENCE_choice, name, *chosen, low, high);
    return true;
}

static bool check_start(Front *front, const Request *request, const Constants *c)
{
    char name[32];
    if (!finite_or_log(front, "x_start", request->x, "m")) return false;
    for (int i = 0; i < PSP_N - 1; i++) {
        snprintf(name, sizeof name, "s_start[%d]", i + 2);
        if (!finite_or_log(front, name, request->s[i], "m")) return false;
        REQUIRE(request->s[i] > c->L, PSP_SENTENCE_gap, i + 2, request->s[i], c->L);
    }
    for (int i = 0; i < PSP_N; i++) {
        snprintf(name, sizeof name, "v_start[%d]", i + 1);
        if (!finite_or_log(front, name, request->v[i], "m/s")) return false;
        REQUIRE(0.0 <= request->v[i] && request->v[i] <= c->v_max, PSP_SENTENCE_speed, i + 1, request->v[i], c->v_max,
                i + 1);
    }
    return true;
}

static bool check_sampling(Front *front, Platoon *platoon, const double *values)
{
    int policy, max_short_periods;
    if (!choice(front, values, "lemma1_policy", PSP_lemma1_policy, 1, 3, &policy) ||
        !choice(front, values, "max_short_periods", PSP_max_short_periods, 1, 0, &max_short_periods) ||
        !finite_or_log(front, "T", platoon->T, "s"))
        return false;
    REQUIRE(platoon->T > 0.0, PSP_SENTENCE_T, platoon->T);
    platoon->policy = policy;
    platoon->max_short_periods = max_short_periods;
    return true;
}

static bool check_request(Front *front, const double *values, Request *request)
{
    int potential;
    if (!choice(front, values, "potential", PSP_potential, 1, 2, &potential) ||
        !choice(front, values, "parameter_source", PSP_parameter_source, 1, 3, &request->source) ||
        !finite_or_log(front, "alpha", request->fixed.alpha, "1") || !finite_or_log(front, "r", request->fixed.r, "m") ||
        !finite_or_log(front, "p", request->fixed.p, "1") ||
        !choice(front, values, "rollout_count", PSP_rollout_count, 1, 1000, &request->rollouts))
        return false;
    request->old = potential == 1;
    REQUIRE(request->horizon > 0.0 && isfinite(request->horizon), PSP_SENTENCE_horizon, request->horizon);
    return true;
}

bool platoon_read(Platoon *platoon, Front *front, const double *values, Request *request)
{
    memset(platoon, 0, sizeof *platoon);
    platoon->constants = (Constants){values[PSP_L],       values[PSP_lambda], values[PSP_v_star], values[PSP_v_max],
                                     values[PSP_epsilon], values[PSP_mu],     values[PSP_z]};
    platoon->weights = (Weights){values[PSP_w1], values[PSP_w2], values[PSP_a_ref], values[PSP_s_ref]};
    platoon->T = values[PSP_T];
    request->x = values[PSP_x_start];
    request->s = values + PSP_s_start;
    request->v = values + PSP_v_start;
    request->fixed = (Shape){values[PSP_alpha_fixed], values[PSP_r_fixed], values[PSP_p_fixed], 1.0};
    request->horizon = values[PSP_rollout_horizon];
    if (!check_constants(front, &platoon->constants) || !check_weights(front, &platoon->weights) ||
        !check_sampling(front, platoon, values) || !check_start(front, request, &platoon->constants) ||
        !check_request(front, values, request))
        return false;
    platoon->now.x = request->x;
    memcpy(platoon->now.s, request->s, sizeof platoon->now.s);
    memcpy(platoon->now.v, request->v, sizeof platoon->now.v);
    return true;
}

/* J of one candidate from the start; infinite unless Lemma 1 certifies T throughout. */
static double rollout_cost(Platoon *trial, const Platoon *platoon, const Shape *candidate, double horizon)
{
    double fraction;
    const double periods = fmax(platoon_locate(horizon, platoon->T, &fraction), 1.0);
    *trial = *platoon;
    trial->shape = *candidate;
    for (double k = 0.0; k < periods; k += 1.0) {
        platoon_feedback(trial, &trial->now);
        if (!(trial->now.T_max > trial->T)) return INFINITY;
        platoon_pass(trial, &trial->now, trial->T);
    }
    return trial->now.cost_acceleration + trial->now.cost_gaps;
}

/* The best certified triple so far, and its J. */
typedef struct {
    Shape shape;
    double J;
} Best;

/* Projects `tried` and makes it the best if it is certified and its J is smaller. */
static bool try_rollout(Platoon *platoon, Front *front, const Request *request, Shape *tried, Platoon *trial, Best *best)
{
    if (!project(front, tried, &platoon->constants)) return false;
    const double J = rollout_cost(trial, platoon, tried, request->horizon);
    if (J < best->J) *best = (Best){*tried, J};
    return true;
}

/* psp_model/rollout.py: the least J of the candidates, the first of equals, the first if none is certified; then
 * rounds of refinement by r + h, r - h, p + k, p - k around the best, with steps that are halved. */
static bool best_by_rollout(Platoon *platoon, Front *front, const Request *request, Shape *candidates, Platoon *trial)
{
    const int left = request->rollouts / 8 - 1, rounds = left < 0 ? 0 : left > 3 ? 3 : left;
    const int count = network_candidates(request->s, request->v, request->rollouts - 4 * rounds, candidates);
    Best best = {candidates[0], INFINITY};
    for (int k = 0; k < count; k++) {
        if (!try_rollout(platoon, front, request, &candidates[k], trial, &best)) return false;
        if (k == 0) best.shape = candidates[0];
    }
    for (int round = 0; round < rounds; round++) {
        const Shape centre = best.shape;
        const double h = ldexp(0.1, -round), k = ldexp(0.15, -round);
        Shape around[4] = {centre, centre, centre, centre};
        around[0].r += h;
        around[1].r -= h;
        around[2].p += k;
        around[3].p -= k;
        for (int i = 0; i < 4; i++)
            if (!try_rollout(platoon, front, request, &around[i], trial, &best)) return false;
    }
    platoon->shape = best.shape;
    return true;
}

static bool choose_by_rollout(Platoon *platoon, Front *front, const Request *request)
{
    Shape *candidates = malloc((size_t)request->rollouts * sizeof *candidates);
    Platoon *trial = malloc(sizeof *trial);
    bool done = false;
    if (candidates && trial) done = best_by_rollout(platoon, front, request, candidates, trial);
    else front_log(front, fmi2Error, "there is no memory left for %d rollouts: lower rollout_count", request->rollouts);
    free(candidates);
    free(trial);
    return done;
}

bool platoon_choose(Platoon *platoon, Front *front, const Request *request)
{
    platoon->shape = request->fixed;
    if (request->old) {
        platoon->shape = (Shape){1.0, 0.0, 0.0, 0.0};
        return true;
    }
    if (request->source == 2) return require_feasible(front, &request->fixed, &platoon->constants);
    if (!PSP_NETWORK) {
        front_log(front, fmi2Error, PSP_SENTENCE_no_network, PSP_N);
        return false;
    }
    const char *reason = outside_domain(request->s, request->v, &platoon->constants);
    if (reason) {
        if (!require_feasible(front, &request->fixed, &platoon->constants)) return false;
        front_log(front, fmi2Warning, PSP_SENTENCE_fallback, reason, request->fixed.alpha, request->fixed.r,
                  request->fixed.p);
        return true;
    }
    if (request->source == 3) return choose_by_rollout(platoon, front, request);
    network_candidates(request->s, request->v, 1, &platoon->shape);
    if (!finite_or_log(front, "alpha", platoon->shape.alpha, "1") || !finite_or_log(front, "r", platoon->shape.r, "m") ||
        !finite_or_log(front, "p", platoon->shape.p, "1"))
        return false;
    return project(front, &platoon->shape, &platoon->constants);
}
