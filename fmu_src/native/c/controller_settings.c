/* What the controller is told once: mirrors fmu_src/python/controller_slave.py, fmu_src/interface/meaning.py and the checks of
 * psp_model/controller/settings.py and psp_model/validate.py. */
#include "controller.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PREDICTED_AGE 1.0 /* [s] as in psp_model/controller/settings.py */

static bool read_sampling(Front *front, const double *read, Settings *settings)
{
    settings->phase = read[PSP_phase];
    if (!read_choice(front, "lemma1_policy", read[PSP_lemma1_policy], 1, 2, &settings->policy) ||
        !read_choice(front, "certificate", read[PSP_certificate], 1, 2, &settings->certificate) ||
        !read_period(front, read, &settings->T))
        return false;
    REQUIRE(0.0 <= settings->phase && settings->phase < settings->T, PSP_SENTENCE_phase, settings->phase, settings->T);
    return true;
}

static void read_actuation(const double *read, Settings *settings)
{
    Actuation *actuation = &settings->actuation;
    actuation->actuation_delay = read[PSP_actuation_delay];
    memcpy(actuation->actuator_lag, read + PSP_actuator_lag, sizeof actuation->actuator_lag);
    memcpy(actuation->a_min, read + PSP_a_min, sizeof actuation->a_min);
    memcpy(actuation->a_max, read + PSP_a_max, sizeof actuation->a_max);
    for (int i = 0; i < PSP_N; i++) settings->lags = settings->lags || actuation->actuator_lag[i] != 0.0;
}

static bool read_cooperation(Front *front, const double *read, Settings *settings)
{
    Cooperation *law = &settings->cooperation;
    int following;
    if (!read_choice(front, "following", read[PSP_following], 1, 2, &following)) return false;
    law->following = following;
    law->kappa = read[PSP_kappa];
    law->kappa_reach = read[PSP_kappa_reach];
    law->time_gap = read[PSP_time_gap];
    law->feedforward = read[PSP_feedforward];
    law->closing_speed = read[PSP_closing_speed];
    law->closing_spacing = read[PSP_closing_spacing];
    law->closing_reach = read[PSP_closing_reach];
    for (int i = 0; i < PSP_N; i++) {
        const double length = read[PSP_length + i];
        law->length[i] = length == 0.0 ? settings->constants.L : length;
    }
    return true;
}

static bool finite_each(Front *front, const char *name, const double *values, const char *unit)
{
    for (int i = 0; i < PSP_N; i++) {
        if (!finite_element(front, name, i + 1, values[i], unit)) return false;
    }
    return true;
}

static bool not_negative(Front *front, const char *name, double value, const char *unit)
{
    REQUIRE(value >= 0.0, PSP_SENTENCE_not_negative, name, value, unit, unit);
    return true;
}

static bool check_limits(Front *front, const Settings *settings)
{
    const Actuation *actuation = &settings->actuation;
    const double a_safe = settings->a_safe;
    if (!finite_or_log(front, "a_safe", a_safe, "m/s2") || !finite_each(front, "a_min", actuation->a_min, "m/s2") ||
        !finite_each(front, "a_max", actuation->a_max, "m/s2"))
        return false;
    for (int i = 0; i < PSP_N; i++) {
        const double least = actuation->a_min[i];
        REQUIRE(!(least < 0.0) || a_safe >= least, PSP_SENTENCE_a_safe, a_safe, i + 1, least);
    }
    REQUIRE(a_safe <= 0.0, PSP_SENTENCE_a_safe_positive, a_safe);
    REQUIRE(settings->max_age > 0.0, PSP_SENTENCE_max_age, settings->max_age);
    return true;
}

static bool check_law(Front *front, const Settings *settings)
{
    const Cooperation *law = &settings->cooperation;
    const double L = settings->constants.L, reach = law->closing_reach;
    if (!finite_or_log(front, "kappa", law->kappa, "1/s") || !finite_or_log(front, "kappa_reach", law->kappa_reach, "m") ||
        !finite_or_log(front, "time_gap", law->time_gap, "s") ||
        !finite_or_log(front, "feedforward", law->feedforward, "1") ||
        !finite_or_log(front, "closing_speed", law->closing_speed, "m/s") ||
        !finite_or_log(front, "closing_spacing", law->closing_spacing, "m") ||
        !finite_or_log(front, "closing_reach", reach, "m") || !not_negative(front, "kappa", law->kappa, "1/s") ||
        !not_negative(front, "time_gap", law->time_gap, "s") ||
        !not_negative(front, "closing_speed", law->closing_speed, "m/s"))
        return false;
    REQUIRE(0.0 <= law->feedforward && law->feedforward <= 1.0, PSP_SENTENCE_feedforward, law->feedforward);
    REQUIRE(reach > law->closing_spacing, PSP_SENTENCE_reach, "closing_reach", reach, "closing_spacing",
            law->closing_spacing);
    if (!finite_each(front, "length", law->length, "m")) return false;
    for (int i = 0; i < PSP_N; i++) REQUIRE(law->length[i] > 0.0, PSP_SENTENCE_length, i + 1, law->length[i], i + 1);
    REQUIRE(!(law->kappa > 0.0) || law->kappa_reach > L, PSP_SENTENCE_reach, "kappa_reach", law->kappa_reach, "L", L);
    return true;
}

static bool check_actuation(Front *front, const Settings *settings)
{
    const Actuation *actuation = &settings->actuation;
    const double delay = actuation->actuation_delay;
    char name[32];
    if (!finite_or_log(front, "actuation_delay", delay, "s") || !not_negative(front, "actuation_delay", delay, "s"))
        return false;
    for (int i = 0; i < PSP_N; i++) {
        snprintf(name, sizeof name, "actuator_lag[%d]", i + 1);
        if (!finite_or_log(front, name, actuation->actuator_lag[i], "s") ||
            !not_negative(front, name, actuation->actuator_lag[i], "s"))
            return false;
    }
    for (int i = 0; i < PSP_N; i++) {
        const double least = actuation->a_min[i], most = actuation->a_max[i];
        REQUIRE(least < 0.0 && 0.0 < most, PSP_SENTENCE_command_limits, i + 1, least, i + 1, most);
    }
    return true;
}

static bool check_errors(Front *front, const Errors *errors)
{
    return finite_or_log(front, "error_s", errors->error_s, "m") && not_negative(front, "error_s", errors->error_s, "m") &&
           finite_or_log(front, "error_v", errors->error_v, "m/s") &&
           not_negative(front, "error_v", errors->error_v, "m/s");
}

/* Whether the law is evaluated at a predicted state, and what is remembered for that. */
static bool plan_prediction(Front *front, Settings *settings)
{
    const double delay = settings->actuation.actuation_delay, T = settings->T;
    settings->predicts = delay > 0.0 || settings->lags || settings->max_age <= PREDICTED_AGE;
    if (!settings->predicts) return true;
    settings->oldest = fmin(fmin(settings->max_age, PREDICTED_AGE), (PSP_QUEUE - 2) * T - delay);
    REQUIRE(settings->oldest >= 0.0, PSP_SENTENCE_dead_time, delay, PSP_QUEUE - 2, T);
    settings->rows = actuators_rows(settings->oldest + delay, T);
    if (settings->rows < 0) settings->rows = PSP_QUEUE; /* the quotient was rounded up */
    return true;
}

bool read_settings(Front *front, const double *read, Settings *settings)
{
    memset(settings, 0, sizeof *settings);
    settings->a_safe = read[PSP_a_safe];
    settings->max_age = read[PSP_max_age];
    settings->errors = (Errors){read[PSP_error_s], read[PSP_error_v]};
    if (!read_sampling(front, read, settings) || !read_constants(front, read, &settings->constants) ||
        !read_weights(front, read, &settings->weights) || !read_request(front, read, &settings->request) ||
        !read_cooperation(front, read, settings) ||
        !read_choice(front, "bad_input", read[PSP_bad_input], 1, 2, &settings->bad_input))
        return false;
    read_actuation(read, settings);
    if (!check_limits(front, settings) || !check_law(front, settings) || !check_actuation(front, settings) ||
        !check_errors(front, &settings->errors) || !plan_prediction(front, settings))
        return false;
    const Cooperation *law = &settings->cooperation;
    settings->plain = !settings->predicts && settings->errors.error_s == 0.0 && settings->errors.error_v == 0.0 &&
                      law->kappa == 0.0 && law->closing_speed == 0.0 && law->following == FOLLOW_NEAREST &&
                      spacings_are_model_spacings(&settings->constants, law, PSP_N);
    return settings->request.old || require_feasible(front, &settings->request.fixed, &settings->constants);
}

void nothing_decided(const Settings *settings, Command *now)
{
    const Shape old = {1.0, 0.0, 0.0, 0.0};
    memset(now, 0, sizeof *now);
    now->in_order = true;
    now->shape = settings->request.old ? old : settings->request.fixed;
}
