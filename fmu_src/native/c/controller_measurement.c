/* What the controller is told at a sampling instant, and whether that is in order: mirrors
 * psp_model/controller/measurement.py. */
#include "controller.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "psp_kernels.h"

#define ROUNDING 1e-6 /* [1] of L or v_max, as in psp_model/controller/measurement.py */

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

static bool bad_spacing(const Settings *settings, char *text, int vehicle, double spacing)
{
    const double L = settings->constants.L, ahead = settings->cooperation.length[vehicle - 2];
    if (!isfinite(spacing)) return not_finite(text, "s", vehicle, spacing, "m");
    if (spacing <= 0.0) return refuse(text, PSP_SENTENCE_measured_order, vehicle, spacing, vehicle, vehicle - 1);
    if (ahead != L) return refuse(text, PSP_SENTENCE_measured_clearance, vehicle, spacing, vehicle - 1, ahead);
    return refuse(text, PSP_SENTENCE_measured_spacing, vehicle, spacing, L);
}

static bool bad_speed(char *text, int vehicle, double speed, double v_max)
{
    if (!isfinite(speed)) return not_finite(text, "v", vehicle, speed, "m/s");
    if (speed < 0.0) return refuse(text, PSP_SENTENCE_measured_backwards, vehicle, speed);
    return refuse(text, PSP_SENTENCE_measured_speed, vehicle, speed, v_max);
}

static double clipped(double value, double low, double high) { return fmin(fmax(value, low), high); }

/* Takes spacings and speeds of n vehicles, those that miss the state space by rounding as its bounds.  Under policy 1, which
 * asks for spacings above L + v_max T, one of L or less is refused all the same.  With lengths, L is where vehicles touch. */
static bool take_motion(const Settings *settings, int n, const Measurement *measured, Basis *basis, char *text)
{
    const double L = settings->constants.L, v_max = settings->constants.v_max, above_L = nextafter(L, INFINITY);
    const double least = settings->policy == POLICY_ERROR ? above_L : L - ROUNDING * L;
    for (int i = 0; i < n - 1; i++) {
        const double s = measured->s[i], contact = psp_contact_spacing(s, settings->cooperation.length[i], L);
        if (!(contact >= least && s > 0.0 && s < INFINITY)) return bad_spacing(settings, text, i + 2, s);
        basis->s[i] = contact >= above_L ? s : s + (above_L - contact);
    }
    for (int i = 0; i < n; i++) {
        const double v = measured->v[i];
        if (!(v >= -ROUNDING * v_max && v <= v_max + ROUNDING * v_max)) return bad_speed(text, i + 1, v, v_max);
        basis->v[i] = clipped(v, 0.0, v_max);
    }
    return true;
}

static bool take_desired(double desired, double v_max, Seen *seen, char *text)
{
    seen->v_desired = -1.0;
    if (desired <= -1.0) return true;
    if (!isfinite(desired)) return refuse(text, PSP_SENTENCE_v_desired_finite, printable(desired), v_max);
    if (desired < -ROUNDING * v_max) return refuse(text, PSP_SENTENCE_v_desired_backwards, desired);
    if (desired > v_max + ROUNDING * v_max) return refuse(text, PSP_SENTENCE_v_desired, desired, v_max);
    seen->v_desired = clipped(desired, 0.0, v_max);
    return true;
}

static bool are_all_automated(const double *automated, int n)
{
    for (int i = 0; i < n; i++) {
        if (automated[i] != 1.0) return false;
    }
    return true;
}

/* A value that is used has to be finite; none may be a NaN. */
static bool usable(char *text, const char *name, int i, double value, bool used, const char *unit)
{
    return isfinite(value) || !(used || isnan(value)) ? true : not_finite(text, name, i + 1, value, unit);
}

/* Takes who drives himself, and what they communicate. */
static bool take_others(const Measurement *measured, Basis *basis, Seen *seen, Work *work, char *text)
{
    const int n = seen->n;
    const double *automated = measured->automated, *known = measured->a_known, *a = measured->a_measured;
    seen->automated = NULL;
    basis->all_automated = true;
    if (are_all_automated(automated, n)) return true;
    for (int i = 0; i < n; i++) {
        if (!usable(text, "automated", i, automated[i], true, "1")) return false;
        basis->automated[i] = automated[i] <= 0.5 ? 0.0 : 1.0;
    }
    if (are_all_automated(basis->automated, n)) return true;
    for (int i = 0; i < n; i++) {
        if (!usable(text, "a_known", i, known[i], automated[i] <= 0.5, "1")) return false;
        work->a_known[i] = automated[i] <= 0.5 && known[i] > 0.5 ? 1.0 : 0.0;
    }
    for (int i = 0; i < n; i++) {
        const bool used = work->a_known[i] != 0.0;
        if (!usable(text, "a_measured", i, a[i], used, "m/s2")) return false;
        work->a_measured[i] = used ? a[i] : 0.0;
    }
    seen->automated = basis->automated;
    basis->all_automated = false;
    return true;
}

static bool is_count(double n) { return 1.0 <= n && n <= PSP_N && n == (double)(int)n; }

int said_to_be_active(const Measurement *measured)
{
    return is_count(measured->n_active) ? (int)measured->n_active : PSP_N;
}

bool take(const Settings *settings, const Measurement *measured, Basis *basis, Seen *seen, Work *work, char *text)
{
    const double n = measured->n_active, age = measured->age, rounding = measured->age_rounding;
    if (!is_count(n)) return refuse(text, PSP_SENTENCE_active, printable(n), PSP_N);
    if (!isfinite(age)) return refuse(text, PSP_SENTENCE_age, printable(age));
    if (!(age <= settings->max_age + rounding)) return refuse(text, PSP_SENTENCE_stale, age, settings->max_age);
    if (settings->predicts && !(age <= settings->oldest + rounding))
        return refuse(text, PSP_SENTENCE_older_input, age, settings->oldest);
    if (!isfinite(measured->resolve)) return refuse(text, PSP_SENTENCE_finite, "resolve", printable(measured->resolve), "1");
    if (!isfinite(measured->a_desired))
        return refuse(text, PSP_SENTENCE_finite, "a_desired", printable(measured->a_desired), "m/s2");
    seen->n = (int)n;
    seen->a_desired = measured->a_desired;
    seen->age = basis->age = clipped(age, 0.0, settings->oldest);
    return take_others(measured, basis, seen, work, text) &&
           take_desired(measured->v_desired, settings->constants.v_max, seen, text) &&
           take_motion(settings, seen->n, measured, basis, text);
}
