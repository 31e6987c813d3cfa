/* The potential for a start: mirrors psp_model/selection/selectors.py and
 * psp_model/selection/rollout.py. */
#include "vehicles.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What candidates are judged by, and the best one so far. */
typedef struct {
    Front *front;
    const Constants *constants;
    const Weights *weights;
    double T;
    const Request *request;
    Instant trial;
    Shape best;
    double J; /* infinite while none is certified */
} Search;

/* J of one candidate from the start; infinite unless Lemma 1 certifies T throughout. */
static double rollout_cost(Search *search, const Shape *candidate)
{
    const Request *start = search->request;
    Instant *at = &search->trial;
    double fraction;
    const double periods = fmax(locate(start->horizon, search->T, &fraction), 1.0);
    at->n = start->n;
    at->x = at->cost_acceleration = at->cost_spacings = 0.0;
    memcpy(at->s, start->s, (size_t)(start->n - 1) * sizeof *at->s);
    memcpy(at->v, start->v, (size_t)start->n * sizeof *at->v);
    for (double k = 0.0; k < periods; k += 1.0) {
        if (!(feedback(search->constants, candidate, start->n, at->s, at->v, at->a) > search->T)) return INFINITY;
        pass_time(search->weights, at, search->T);
    }
    return at->cost_acceleration + at->cost_spacings;
}

/* Projects `tried` and makes it the best if it is certified and its J is smaller. */
static bool try_rollout(Search *search, Shape *tried)
{
    if (!project(search->front, tried, search->constants)) return false;
    const double J = rollout_cost(search, tried);
    if (J < search->J) {
        search->best = *tried;
        search->J = J;
    }
    return true;
}

/* psp_model/selection/rollout.py: the least J of the candidates, the first of equals, the first if none is certified; then
 * rounds of refinement by r + h, r - h, p + k, p - k around the best, with steps that are halved. */
static bool best_by_rollout(Search *search, Shape *candidates)
{
    const Request *start = search->request;
    const int left = start->rollouts / 8 - 1, rounds = left < 0 ? 0 : left > 3 ? 3 : left;
    const int count = network_candidates(start->n, start->s, start->v, start->rollouts - 4 * rounds, candidates);
    search->J = INFINITY;
    for (int k = 0; k < count; k++) {
        if (!try_rollout(search, &candidates[k])) return false;
        if (k == 0) search->best = candidates[0];
    }
    for (int round = 0; round < rounds; round++) {
        const Shape centre = search->best;
        const double h = ldexp(0.1, -round), k = ldexp(0.15, -round);
        Shape around[4] = {centre, centre, centre, centre};
        around[0].r += h;
        around[1].r -= h;
        around[2].p += k;
        around[3].p -= k;
        for (int i = 0; i < 4; i++)
            if (!try_rollout(search, &around[i])) return false;
    }
    return true;
}

static bool choose_by_rollout(Front *front, const Constants *constants, const Weights *weights, double T,
                              const Request *request, Shape *shape)
{
    REQUIRE(request->horizon / T < PERIODS_MAX, PSP_SENTENCE_periods, request->horizon, T);
    Shape *candidates = malloc((size_t)request->rollouts * sizeof *candidates);
    Search *search = calloc(1, sizeof *search);
    bool done = false;
    if (candidates && search) {
        search->front = front;
        search->constants = constants;
        search->weights = weights;
        search->T = T;
        search->request = request;
        done = best_by_rollout(search, candidates);
        *shape = search->best;
    } else {
        front_log(front, fmi2Error, "there is no memory left for %d rollouts: lower rollout_count", request->rollouts);
    }
    free(candidates);
    free(search);
    return done;
}

/* NULL, or why there is no answer of a network for the vehicles, which may be put into `text`. */
static const char *reason_for_fallback(const Constants *constants, const Request *request, char text[80])
{
    if (network_for(request->n)) return outside_domain(request->n, request->s, request->v, constants);
    snprintf(text, 80, "%d vehicles, for which there is no network here", request->n);
    return text;
}

void warn_of_fallback(Front *front, const Constants *constants, const Request *request)
{
    char text[80];
    if (request->old || request->n == 1 || request->source == SOURCE_FIXED) return;
    const char *reason = reason_for_fallback(constants, request, text);
    if (reason)
        front_log(front, fmi2Warning, PSP_SENTENCE_fallback, reason, request->fixed.alpha, request->fixed.r,
                  request->fixed.p);
}

bool choose_shape(Front *front, const Constants *constants, const Weights *weights, double T, const Request *request,
                  Shape *shape)
{
    char text[80];
    *shape = request->fixed;
    if (request->old) {
        *shape = (Shape){1.0, 0.0, 0.0, 0.0};
        return true;
    }
    if (request->n == 1 || request->source == SOURCE_FIXED || reason_for_fallback(constants, request, text)) {
        if (!require_feasible(front, &request->fixed, constants)) return false;
        if (!request->quiet) warn_of_fallback(front, constants, request);
        return true;
    }
    if (request->source == SOURCE_ROLLOUT) return choose_by_rollout(front, constants, weights, T, request, shape);
    network_candidates(request->n, request->s, request->v, 1, shape);
    return finite_triple(front, shape) && project(front, shape, constants);
}
