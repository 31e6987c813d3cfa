/* What the controller is told once: mirrors fmu_src/python/controller_slave.py and the checks of
 * psp_model/controller.py. */
#include "controller.h"

#include <math.h>
#include <string.h>

static bool read_sampling(Front *front, const double *read, Settings *settings)
{
    settings->phase = read[PSP_phase];
    if (!read_choice(front, "lemma1_policy", read[PSP_lemma1_policy], 1, 2, &settings->policy) ||
        !read_period(front, read, &settings->T))
        return false;
    REQUIRE(0.0 <= settings->phase && settings->phase < settings->T, PSP_SENTENCE_phase, settings->phase, settings->T);
    return true;
}

static bool check_limits(Front *front, const Settings *settings)
{
    const double a_min = settings->a_min, a_max = settings->a_max, a_safe = settings->a_safe;
    if (!finite_or_log(front, "a_min", a_min, "m/s2") || !finite_or_log(front, "a_max", a_max, "m/s2") ||
        !finite_or_log(front, "a_safe", a_safe, "m/s2"))
        return false;
    REQUIRE(a_min < 0.0, PSP_SENTENCE_a_min, a_min);
    REQUIRE(a_max > 0.0, PSP_SENTENCE_a_max, a_max);
    REQUIRE(a_safe <= 0.0, PSP_SENTENCE_a_safe_positive, a_safe);
    REQUIRE(a_safe >= a_min, PSP_SENTENCE_a_safe, a_safe, a_min);
    return true;
}

bool read_settings(Front *front, const double *read, Settings *settings)
{
    memset(settings, 0, sizeof *settings);
    settings->a_min = read[PSP_a_min];
    settings->a_max = read[PSP_a_max];
    settings->a_safe = read[PSP_a_safe];
    settings->max_age = read[PSP_max_age];
    if (!read_sampling(front, read, settings) || !read_constants(front, read, &settings->constants) ||
        !read_weights(front, read, &settings->weights) || !read_request(front, read, &settings->request) ||
        !read_choice(front, "bad_input", read[PSP_bad_input], 1, 2, &settings->bad_input))
        return false;
    if (!check_limits(front, settings)) return false;
    REQUIRE(settings->max_age > 0.0, PSP_SENTENCE_max_age, settings->max_age);
    return settings->request.old || require_feasible(front, &settings->request.fixed, &settings->constants);
}

void nothing_decided(const Settings *settings, Command *now)
{
    const Shape old = {1.0, 0.0, 0.0, 0.0};
    memset(now, 0, sizeof *now);
    now->in_order = true;
    now->shape = settings->request.old ? old : settings->request.fixed;
}
