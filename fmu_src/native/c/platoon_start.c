/* What a platoon starts with: mirrors fmu_src/python/platoon_slave.py and the checks of psp_model/validate.py. */
#include "platoon.h"

#include <string.h>

static bool read_sampling(Front *front, const double *read, Platoon *platoon)
{
    int policy, max_short_periods, certificate;
    if (!read_choice(front, "lemma1_policy", read[PSP_lemma1_policy], 1, 3, &policy) ||
        !read_choice(front, "certificate", read[PSP_certificate], 1, 2, &certificate) ||
        !read_choice(front, "max_short_periods", read[PSP_max_short_periods], 1, 0, &max_short_periods) ||
        !read_period(front, read, &platoon->T))
        return false;
    platoon->policy = policy;
    platoon->certificate = certificate;
    platoon->max_short_periods = max_short_periods;
    return true;
}

static bool read_join_margin(Front *front, const double *read, Platoon *platoon)
{
    const double margin = read[PSP_join_brake_margin], a_min = read[PSP_join_a_min];
    if (!finite_or_log(front, "join_brake_margin", margin, "m/s2") || !finite_or_log(front, "join_a_min", a_min, "m/s2"))
        return false;
    REQUIRE(0.0 <= margin && margin <= PSP_HARDEST, PSP_SENTENCE_join_brake_margin, margin, PSP_HARDEST);
    REQUIRE(a_min < 0.0, PSP_SENTENCE_join_a_min, a_min);
    platoon->join_brake_margin = margin;
    platoon->join_a_min = a_min;
    return true;
}

bool platoon_read(Platoon *platoon, Front *front, const double *values, Request *request)
{
    memset(platoon, 0, sizeof *platoon);
    request->x = values[PSP_x_start];
    request->s = values + PSP_s_start;
    request->v = values + PSP_v_start;
    if (!read_choice(front, "n_start", values[PSP_n_start], 1, PSP_N, &request->n) ||
        !read_constants(front, values, &platoon->constants) || !read_weights(front, values, &platoon->weights) ||
        !read_sampling(front, values, platoon) ||
        !read_cooperation(front, values, &platoon->constants, request->n, &platoon->cooperation) ||
        !read_join_margin(front, values, platoon) ||
        !check_start(front, request->n, request->x, request->s, request->v, platoon->cooperation.length,
                     platoon->constants.L, platoon->constants.v_max) ||
        !read_request(front, values, request))
        return false;
    if (!request->old && request->source != SOURCE_FIXED) { /* or a later change could find no potential at all */
        REQUIRE(PSP_NETWORK, PSP_SENTENCE_no_network, request->n);
        if (!require_feasible(front, &request->fixed, &platoon->constants)) return false;
    }
    platoon->now.n = request->n;
    platoon->now.x = request->x;
    memcpy(platoon->now.s, request->s, (size_t)(request->n - 1) * sizeof *request->s);
    memcpy(platoon->now.v, request->v, (size_t)request->n * sizeof *request->v);
    return true;
}
