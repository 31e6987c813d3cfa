/* What is reported of a decision: mirrors psp_model/controller/decision.py. */
#include "controller.h"

#include <string.h>

#include "braking.h"

double exact_of(const Settings *settings, const Command *command)
{
    const Basis *basis = &command->basis;
    const bool later = command->in_order && command->n > 0 && basis->as_measured; /* nobody has asked for it */
    if (!later || settings->certificate == CERTIFICATE_EXACT) return command->T_exact;
    return exact_period(&settings->constants, NULL, false, (int)command->n, basis->s, basis->v, command->a);
}

double margin_of(const Settings *settings, const Command *command, Work *work)
{
    const Basis *basis = &command->basis;
    const int n = (int)command->n;
    const double dead_time = basis->age + settings->actuation.actuation_delay;
    if (!command->in_order) return 0.0;
    if (n == 0) return BRAKE_MARGIN_MOST;
    for (int i = 0; i < n; i++) {
        if (basis->as_measured) work->before[i] = 0.0;
        else if (dead_time > 0.0) work->before[i] = (basis->v_predicted[i] - basis->v[i]) / dead_time;
        else work->before[i] = basis->a_predicted[i];
    }
    const Braking vehicles = {.v = basis->v,
                              .a = work->before,
                              .lag = settings->actuation.actuator_lag,
                              .a_min = settings->actuation.a_min,
                              .dead_time = dead_time};
    clearances(&settings->constants, &settings->cooperation, n, basis->s, work->contact);
    return brake_margin(n, work->contact, &vehicles, basis->all_automated ? NULL : basis->automated);
}

void followed_of(const Settings *settings, const Command *command, double *followed)
{
    const int n = (int)command->n;
    if (n > 0)
        followed_by(n, command->basis.all_automated ? NULL : command->basis.automated, settings->cooperation.following,
                    followed);
    memset(followed + n, 0, (size_t)(PSP_N - n) * sizeof *followed);
}
