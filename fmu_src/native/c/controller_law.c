/* The bounded law for vehicles that are in order, and what certifies it: mirrors psp_model/controller/deciding.py and
 * psp_model/vehicles/road_law.py. */
#include "controller.h"

#include <math.h>
#include <string.h>

#include "psp_kernels.h"

/* What is remembered of others, with `places` as for watch(); nothing where all are automated and none closes up. */
static void watch_others(const Settings *settings, const Seen *seen, const int32_t *places, const Command *before,
                         Command *now, Work *work)
{
    const Cooperation *law = &settings->cooperation;
    const Basis *basis = &now->basis;
    const bool idle = law->closing_speed == 0.0;
    now->watches = seen->automated || !idle;
    if (!now->watches) return;
    if (idle) memset(work->wanted, 0, (size_t)seen->n * sizeof *work->wanted);
    else {
        model_spacing(&settings->constants, law, seen->n, basis->s, basis->v, work->spacing);
        closing_speeds(law, seen->n, work->spacing, seen->automated, work->wanted);
    }
    watch(&now->watched, before->watches ? &before->watched : NULL, places, seen->n, basis->v, work->wanted, settings->T);
}

/* The law at the predicted state, before it is limited, into now->a. */
static void ask_the_law(const Settings *settings, const Seen *seen, const Actuators *issued, const Command *before,
                        Command *now, Work *work)
{
    const int n = seen->n;
    const bool others = before->remembered > 0 && before->remembered != n;
    Basis *basis = &now->basis;
    Foreign drivers = {seen->automated, work->a_foreign}, *foreign = NULL;
    if (others) find_members(before, basis, n, work);
    watch_others(settings, seen, others ? work->places : NULL, before, now, work);
    if (seen->automated) {
        foreign = &drivers;
        accelerations(&now->watched, n, work->a_measured, work->a_known, work->a_foreign);
    }
    const Predicted predicted = {basis->s_predicted, basis->v_predicted, basis->a_predicted};
    const Issued known = {issued, others ? work->places : NULL, &settings->actuation, settings->oldest, settings->lags};
    predict(&known, n, basis->s, basis->v, seen->age, foreign, &predicted, &work->ahead);
    const Traffic traffic = {
        .automated = seen->automated,
        .v_desired = seen->v_desired,
        .a_desired = seen->a_desired,
        .closing = settings->cooperation.closing_speed == 0.0 ? NULL : now->watched.closing,
    };
    predictive_command(&settings->constants, &now->shape, &settings->cooperation, &traffic, &known, n, &predicted,
                       &work->ahead, now->a);
    for (int i = 0; seen->automated && i < n; i++) now->a[i] = seen->automated[i] > 0.5 ? now->a[i] : 0.0;
}

/* The commands inside the limits; whether one was cut. */
static bool limit(const Settings *settings, int n, Command *now)
{
    const Actuation *actuation = &settings->actuation;
    bool any = false;
    for (int i = 0; i < n; i++) {
        const double wanted = now->a[i], a = psp_limited(wanted, actuation->a_min[i], actuation->a_max[i]);
        now->a[i] = a;
        now->saturated[i] = a != wanted;
        any |= a != wanted;
    }
    for (int i = n; i < PSP_N; i++) now->a[i] = now->saturated[i] = 0.0;
    return any;
}

/* T_max in the model spacings and T_exact for contact, at the predicted state with its errors. */
static void certify_periods(const Settings *settings, const Seen *seen, Command *now, Work *work)
{
    const Constants *c = &settings->constants;
    const Cooperation *law = &settings->cooperation;
    const Basis *basis = &now->basis;
    const int n = seen->n;
    const double horizon = seen->age + settings->actuation.actuation_delay, *automated = seen->automated;
    const Errors errors = errors_carried(&settings->errors, horizon);
    double *const v = work->speed, *const before = work->before, *const foreign = work->foreign;
    for (int i = 0; i < n; i++) v[i] = fmin(basis->v_predicted[i], c->v_max); /* which is where the law is evaluated */
    model_spacing(c, law, n, basis->s_predicted, v, work->spacing);
    contact_spacing(c, law, n, basis->s_predicted, work->contact);
    if (!settings->lags && !automated && errors.error_s == 0.0 && errors.error_v == 0.0) { /* the same, faster */
        now->T_max = lemma1_period(c, NULL, false, n, work->spacing, v, now->a);
        now->T_exact = exact_period(c, NULL, false, n, work->contact, v, now->a);
        return;
    }
    for (int i = 0; i < n; i++) {
        const double a = basis->a_predicted[i], own = automated ? automated[i] : 1.0;
        before[i] = a * own;
        foreign[i] = a * (1.0 - own);
    }
    const double *was = settings->lags ? before : NULL;
    now->T_max = uncertain_period(c, &errors, n, work->spacing, v, now->a, was);
    now->T_exact = uncertain_exact_period(c, &errors, n, work->contact, v, now->a, was, automated ? foreign : NULL);
}

/* Where the law is the paper's: the same, without anything predicted. */
static void command_plainly(const Settings *settings, const Seen *seen, Command *now)
{
    const Constants *c = &settings->constants;
    const double *s = now->basis.s, *v = now->basis.v;
    const int n = seen->n;
    now->watches = false;
    now->basis.as_measured = true;
    now->T_max = seen->v_desired < 0.0 ? feedback(c, &now->shape, n, s, v, now->a)
                                       : feedback_towards(c, &now->shape, n, s, v, seen->v_desired, now->a);
    if (limit(settings, n, now)) now->T_max = largest_period(c, n, s, v, now->a);
    if (settings->certificate == CERTIFICATE_EXACT) now->T_exact = exact_period(c, NULL, false, n, s, v, now->a);
}

void command_regularly(const Settings *settings, const Seen *seen, const Actuators *issued, const Command *before,
                       Command *now, Work *work)
{
    if (settings->plain && !seen->automated && seen->a_desired == 0.0) command_plainly(settings, seen, now);
    else {
        now->basis.as_measured = false;
        ask_the_law(settings, seen, issued, before, now, work);
        limit(settings, seen->n, now);
        certify_periods(settings, seen, now, work);
    }
    now->remembered = settings->predicts || now->watches ? seen->n : 0;
}
