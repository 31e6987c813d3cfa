/* The decision at a sampling instant: mirrors psp_model/controller.py. */
#include "controller.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "psp_kernels.h"

enum { LONGEST_SENTENCE = 512 };

#define ROUNDING 1e-6 /* [1] of L or v_max, as in psp_model/controller.py */

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

static bool bad_gap(char *text, int vehicle, double gap, double L)
{
    if (!isfinite(gap)) return not_finite(text, "s", vehicle, gap, "m");
    if (gap <= 0.0) return refuse(text, PSP_SENTENCE_measured_order, vehicle, gap, vehicle, vehicle - 1);
    return refuse(text, PSP_SENTENCE_measured_gap, vehicle, gap, L);
}

static bool bad_speed(char *text, int vehicle, double speed, double v_max)
{
    if (!isfinite(speed)) return not_finite(text, "v", vehicle, speed, "m/s");
    if (speed < 0.0) return refuse(text, PSP_SENTENCE_measured_backwards, vehicle, speed);
    return refuse(text, PSP_SENTENCE_measured_speed, vehicle, speed, v_max);
}

static double clipped(double value, double low, double high) { return fmin(fmax(value, low), high); }

/* Takes gaps and speeds of n vehicles, those that miss the state space by rounding as its bounds; if more is amiss, `text`
 * says what.  Under policy 1, which asks for gaps above L + v_max T, a gap of L or less is refused all the same. */
static bool take_motion(const Settings *settings, int n, const Measurement *measured, Decision *decision, char *text)
{
    const double L = settings->constants.L, v_max = settings->constants.v_max, above_L = nextafter(L, INFINITY);
    const double least = settings->policy == POLICY_ERROR ? above_L : L - ROUNDING * L;
    for (int i = 0; i < n - 1; i++) {
        const double s = measured->s[i];
        if (!(s >= least && s < INFINITY)) return bad_gap(text, i + 2, s, L);
        decision->s[i] = fmax(s, above_L);
    }
    for (int i = 0; i < n; i++) {
        const double v = measured->v[i];
        if (!(v >= -ROUNDING * v_max && v <= v_max + ROUNDING * v_max)) return bad_speed(text, i + 1, v, v_max);
        decision->v[i] = clipped(v, 0.0, v_max);
    }
    return true;
}

static bool take_desired(double desired, double v_max, Decision *decision, char *text)
{
    decision->v_desired = -1.0;
    if (desired <= -1.0) return true;
    if (!isfinite(desired)) return refuse(text, PSP_SENTENCE_v_desired_finite, printable(desired), v_max);
    if (desired < -ROUNDING * v_max) return refuse(text, PSP_SENTENCE_v_desired_backwards, desired);
    if (desired > v_max + ROUNDING * v_max) return refuse(text, PSP_SENTENCE_v_desired, desired, v_max);
    decision->v_desired = clipped(desired, 0.0, v_max);
    return true;
}

static bool is_count(double n) { return 1.0 <= n && n <= PSP_N && n == (double)(int)n; }

/* Takes the inputs if they are in order; if not, `text` says why. */
static bool take(const Settings *settings, const Measurement *measured, Decision *decision, char *text)
{
    const double n = measured->n_active, age = measured->age;
    if (!is_count(n)) return refuse(text, PSP_SENTENCE_active, printable(n), PSP_N);
    if (!isfinite(age)) return refuse(text, PSP_SENTENCE_age, printable(age));
    if (!(age <= settings->max_age + measured->age_rounding))
        return refuse(text, PSP_SENTENCE_stale, age, settings->max_age);
    if (!isfinite(measured->resolve)) return refuse(text, PSP_SENTENCE_finite, "resolve", printable(measured->resolve), "1");
    return take_desired(measured->v_desired, settings->constants.v_max, decision, text) &&
           take_motion(settings, (int)n, measured, decision, text);
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
static void command(const Settings *settings, int n, Decision *decision)
{
    const Constants *c = &settings->constants;
    const double *s = decision->s, *v = decision->v, desired = decision->v_desired;
    Command *now = &decision->now;
    bool bounded = false;
    now->T_max = desired < 0.0 ? feedback(c, &now->shape, n, s, v, now->a)
                               : feedback_towards(c, &now->shape, n, s, v, desired, now->a);
    for (int i = 0; i < PSP_N; i++) {
        const double wanted = i < n ? now->a[i] : 0.0;
        now->a[i] = clipped(wanted, settings->a_min, settings->a_max);
        now->saturated[i] = now->a[i] != wanted;
        bounded = bounded || now->a[i] != wanted;
    }
    if (bounded) now->T_max = largest_period(c, n, s, v, now->a);
}

static bool choose(const Settings *settings, Front *front, int n, Decision *decision)
{
    Request request = settings->request;
    request.n = n;
    request.s = decision->s;
    request.v = decision->v;
    decision->now.choices++;
    decision->now.in_domain = lies_in_domain(n, decision->s, decision->v, &settings->constants);
    return choose_shape(front, &settings->constants, &settings->weights, settings->T, &request, &decision->now.shape);
}

/* Why T is not certified: the smallest gap, or else speeds and commands. */
static void log_violation(const Settings *settings, Front *front, double time, const Decision *decision)
{
    const fmi2Status status = settings->policy == POLICY_ERROR ? fmi2Error : fmi2Warning;
    const double L = settings->constants.L, v_max = settings->constants.v_max, T = settings->T, *s = decision->s;
    const double T_max = decision->now.T_max;
    const int gaps = (int)decision->now.n - 1;
    int i = 0;
    for (int k = 1; k < gaps; k++) {
        if (s[k] < s[i]) i = k;
    }
    if (gaps > 0 && psp_gap_bound(s[i], L, v_max) <= T_max)
        front_log(front, status, PSP_SENTENCE_lemma1_controller_gap, T, T_max, time, i + 2, s[i], L + v_max * T, T_max);
    else front_log(front, status, PSP_SENTENCE_lemma1_controller, T, T_max, time, T_max);
}

static bool certify(const Settings *settings, Front *front, double time, const Command *before, Decision *decision)
{
    Command *now = &decision->now;
    if (now->T_max > settings->T) return true;
    now->violations++;
    if (settings->policy == POLICY_ERROR || before->violations == 0 || before->T_max > settings->T)
        log_violation(settings, front, time, decision);
    return settings->policy != POLICY_ERROR;
}

bool decide(const Settings *settings, Front *front, double time, const Measurement *measured, const Command *before,
            Decision *decision)
{
    char text[LONGEST_SENTENCE];
    Command *now = &decision->now;
    *now = *before;
    if (!take(settings, measured, decision, text)) {
        if (settings->bad_input == BAD_INPUT_ERROR) REQUIRE(false, "%s", text);
        if (before->in_order) front_log(front, fmi2Warning, PSP_SENTENCE_safe_action, time, text);
        safe_action(settings, measured, now);
        return true;
    }
    const int n = (int)measured->n_active;
    if ((n != before->n || (measured->resolve > 0.5 && 0.5 >= before->resolve)) && !choose(settings, front, n, decision))
        return false;
    command(settings, n, decision);
    now->in_order = true;
    now->n = n;
    now->resolve = measured->resolve;
    return certify(settings, front, time, before, decision);
}
