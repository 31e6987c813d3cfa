/* The decision at a sampling instant: mirrors psp_model/controller.py. */
#include "controller.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { LONGEST_SENTENCE = 512 };

/* Puts a sentence into `text`; false. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static bool refuse(char *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    front_print(text, LONGEST_SENTENCE, format, arguments);
    va_end(arguments);
    return false;
}

static bool not_finite(char *text, const char *name, int vehicle, double value, const char *unit)
{
    char indexed[32];
    snprintf(indexed, sizeof indexed, "%s[%d]", name, vehicle);
    return refuse(text, PSP_SENTENCE_finite, indexed, printable(value), unit);
}

/* Whether gaps and speeds of n vehicles lie in the state space; if not, `text` says why. */
static bool inside(const Constants *c, int n, const Measurement *measured, char *text)
{
    for (int i = 0; i < n - 1; i++) {
        const double s = measured->s[i];
        if (s > c->L && s < INFINITY) continue;
        if (!isfinite(s)) return not_finite(text, "s", i + 2, s, "m");
        return refuse(text, PSP_SENTENCE_measured_gap, i + 2, s, c->L);
    }
    for (int i = 0; i < n; i++) {
        const double v = measured->v[i];
        if (v >= 0.0 && v <= c->v_max) continue;
        if (!isfinite(v)) return not_finite(text, "v", i + 1, v, "m/s");
        return refuse(text, PSP_SENTENCE_measured_speed, i + 1, v, c->v_max);
    }
    return true;
}

static bool is_count(double n) { return 1.0 <= n && n <= PSP_N && n == (double)(int)n; }

/* Whether the inputs are in order; if not, `text` says why. */
static bool in_order(const Settings *settings, const Measurement *measured, char *text)
{
    const double n = measured->n_active, v_max = settings->constants.v_max, desired = measured->v_desired;
    if (!is_count(n)) return refuse(text, PSP_SENTENCE_active, printable(n), PSP_N);
    if (!(measured->age <= settings->max_age))
        return refuse(text, PSP_SENTENCE_stale, printable(measured->age), settings->max_age);
    if (!isfinite(measured->resolve)) return refuse(text, PSP_SENTENCE_finite, "resolve", printable(measured->resolve), "1");
    if (!(desired < 0.0) && !(0.0 < desired && desired < v_max))
        return refuse(text, PSP_SENTENCE_v_desired, printable(desired), v_max);
    return inside(&settings->constants, (int)n, measured, text);
}

/* Everybody slows down by a_safe, but not below standstill where the speed is known. */
static void safe_action(const Settings *settings, const Measurement *measured, Command *now)
{
    const double n = measured->n_active;
    const int active = is_count(n) ? (int)n : PSP_N;
    for (int i = 0; i < PSP_N; i++) {
        const double v = measured->v[i], stop = isfinite(v) ? -fmax(v, 0.0) / settings->T : -INFINITY;
        now->a[i] = i < active ? fmax(settings->a_safe, stop) : 0.0;
        now->saturated[i] = 0.0;
    }
    now->in_order = false;
    now->T_max = 0.0;
    now->faults++;
}

/* The bounded feedback for n vehicles, and T_max for it. */
static void command(const Settings *settings, int n, const Measurement *measured, Command *now)
{
    Constants constants = settings->constants;
    bool bounded = false;
    if (measured->v_desired > 0.0) constants.v_star = measured->v_desired;
    now->T_max = feedback(&constants, &now->shape, n, measured->s, measured->v, now->a);
    for (int i = 0; i < PSP_N; i++) {
        const double wanted = i < n ? now->a[i] : 0.0;
        now->a[i] = fmin(fmax(wanted, settings->a_min), settings->a_max);
        now->saturated[i] = now->a[i] != wanted;
        bounded = bounded || now->a[i] != wanted;
    }
    if (bounded) now->T_max = largest_period(&constants, n, measured->s, measured->v, now->a);
}

static bool choose(const Settings *settings, Front *front, int n, const Measurement *measured, Command *now)
{
    Request request = settings->request;
    request.n = n;
    request.s = measured->s;
    request.v = measured->v;
    now->choices++;
    return choose_shape(front, &settings->constants, &settings->weights, settings->T, &request, &now->shape,
                        &now->in_domain);
}

static bool certify(const Settings *settings, Front *front, double time, const Command *before, Command *now)
{
    const double T = settings->T;
    if (now->T_max > T) return true;
    now->violations++;
    if (settings->policy == POLICY_ERROR || before->violations == 0 || before->T_max > T)
        front_log(front, settings->policy == POLICY_ERROR ? fmi2Error : fmi2Warning, PSP_SENTENCE_lemma1_controller, T,
                  now->T_max, time, now->T_max);
    return settings->policy != POLICY_ERROR;
}

bool decide(const Settings *settings, Front *front, double time, const Measurement *measured, const Command *before,
            Command *now)
{
    char text[LONGEST_SENTENCE];
    *now = *before;
    if (!in_order(settings, measured, text)) {
        if (settings->bad_input == BAD_INPUT_ERROR) REQUIRE(false, "%s", text);
        if (before->in_order) front_log(front, fmi2Warning, PSP_SENTENCE_safe_action, time, text);
        safe_action(settings, measured, now);
        return true;
    }
    const int n = (int)measured->n_active;
    if ((n != before->n || (measured->resolve > 0.5 && 0.5 >= before->resolve)) &&
        !choose(settings, front, n, measured, now))
        return false;
    command(settings, n, measured, now);
    now->in_order = true;
    now->n = n;
    now->resolve = measured->resolve;
    return certify(settings, front, time, before, now);
}
