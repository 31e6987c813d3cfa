/* The decision at a sampling instant: mirrors psp_model/controller/deciding.py and psp_model/controller/sampled.py. */
#include "controller.h"

#include <math.h>
#include <string.h>

/* Everybody slows down by a_safe, but not below standstill where the speed is known; who drives himself is not told. */
static void safe_action(const Settings *settings, const Measurement *measured, const Command *before, Command *now)
{
    const int active = said_to_be_active(measured);
    for (int i = 0; i < PSP_N; i++) {
        const double v = measured->v[i], stop = isfinite(v) ? -fmax(v, 0.0) / settings->T : -INFINITY;
        now->a[i] = i < active && !(measured->automated[i] <= 0.5) ? fmax(settings->a_safe, stop) : 0.0;
        now->saturated[i] = 0.0;
    }
    if (before->n > 0) now->basis = before->basis;
    now->remembered = settings->predicts ? active : 0;
    now->watches = now->in_order = false;
    now->T_max = now->T_exact = 0.0;
    now->faults++;
}

static bool choose(const Settings *settings, Front *front, int n, Command *now, Work *work)
{
    Request request = settings->request;
    contact_spacing(&settings->constants, &settings->cooperation, n, now->basis.s, work->contact);
    request.n = n;
    request.s = work->contact;
    request.v = now->basis.v;
    now->choices++;
    now->in_domain = lies_in_domain(n, request.s, request.v, &settings->constants);
    return choose_shape(front, &settings->constants, &settings->weights, settings->T, &request, &now->shape);
}

/* Why T is not certified: the smallest spacing, or else speeds and commands. */
static void log_violation(const Settings *settings, Front *front, double time, const Command *now, Work *work)
{
    const fmi2Status status = settings->policy == POLICY_ERROR ? fmi2Error : fmi2Warning;
    const Constants *c = &settings->constants;
    const Basis *basis = &now->basis;
    const double T = settings->T, T_max = now->T_max;
    if (settings->certificate == CERTIFICATE_EXACT) {
        front_log(front, status, PSP_SENTENCE_exact_controller, T, now->T_exact, time, now->T_exact);
        return;
    }
    const double *shown = basis->as_measured ? basis->s : basis->s_predicted, *s = work->spacing;
    const double horizon = basis->age + settings->actuation.actuation_delay;
    const double error_s = errors_carried(&settings->errors, horizon).error_s;
    const char *kind = settings->predicts ? "predicted" : "measured";
    const int spacings = (int)now->n - 1;
    int i = 0;
    model_spacing(c, &settings->cooperation, spacings + 1, shown, basis->as_measured ? basis->v : basis->v_predicted,
                  work->spacing);
    for (int k = 1; k < spacings; k++) {
        if (s[k] < s[i]) i = k;
    }
    if (spacings > 0 && fmax(s[i] - error_s - c->L, 0.0) / c->v_max <= T_max)
        front_log(front, status, PSP_SENTENCE_lemma1_controller_spacing, T, T_max, time, kind, i + 2, shown[i],
                  c->L + c->v_max * T + (shown[i] - s[i] + error_s), T_max);
    else front_log(front, status, PSP_SENTENCE_lemma1_controller, T, T_max, time, kind, T_max);
}

static bool certify(const Settings *settings, Front *front, double time, const Command *before, Command *now, Work *work)
{
    if (certified_period(settings, now) > settings->T) return true;
    now->violations++;
    if (settings->policy == POLICY_ERROR || before->violations == 0 || certified_period(settings, before) > settings->T)
        log_violation(settings, front, time, now, work);
    return settings->policy != POLICY_ERROR;
}

bool decide(const Settings *settings, Front *front, double time, const Measurement *measured, const Actuators *issued,
            const Command *before, Command *now, Work *work)
{
    char text[LONGEST_SENTENCE];
    Seen seen;
    memcpy(now, before, offsetof(Command, a)); /* the arrays are written anew */
    if (!take(settings, measured, &now->basis, &seen, work, text)) {
        if (settings->bad_input == BAD_INPUT_ERROR) REQUIRE(false, "%s", text);
        if (before->in_order) front_log(front, fmi2Warning, PSP_SENTENCE_safe_action, time, text);
        safe_action(settings, measured, before, now);
        return true;
    }
    if ((seen.n != before->n || (measured->resolve > 0.5 && 0.5 >= before->resolve)) &&
        !choose(settings, front, seen.n, now, work))
        return false;
    command_regularly(settings, &seen, issued, before, now, work);
    now->in_order = true;
    now->n = seen.n;
    now->resolve = measured->resolve;
    return certify(settings, front, time, before, now, work);
}
