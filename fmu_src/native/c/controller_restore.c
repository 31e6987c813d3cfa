/* Whether the controller can be as bytes say: mirrors fmu_src/python/controller_state.py.  What follows from
 * the parameters is computed anew, the rest is checked. */
#include <math.h>
#include <string.h>

#include "native_model.h"

static bool are_finite(int64_t n, const double *values)
{
    for (int64_t i = 0; i < n; i++) {
        if (!isfinite(values[i])) return false;
    }
    return true;
}

static bool not_below_0(int64_t n, const double *values)
{
    for (int64_t i = 0; i < n; i++) {
        if (!(values[i] >= 0.0 && values[i] < INFINITY)) return false;
    }
    return true;
}

/* The basis of a decision on n vehicles; where nothing is predicted the arrays for that are not read. */
static bool can_be_basis(const Basis *basis, int64_t n, const Settings *settings)
{
    if (!state_is_flag(&basis->as_measured) || !state_is_flag(&basis->all_automated)) return false;
    if (n == 0) return true; /* there is none */
    if (!not_below_0(n - 1, basis->s) || !not_below_0(n, basis->v)) return false;
    if (!(0.0 <= basis->age && basis->age <= settings->oldest)) return false;
    for (int64_t i = 0; !basis->all_automated && i < n; i++) {
        if (basis->automated[i] != 0.0 && basis->automated[i] != 1.0) return false;
    }
    return basis->as_measured || (are_finite(n - 1, basis->s_predicted) && not_below_0(n, basis->v_predicted) &&
                                  are_finite(n, basis->a_predicted));
}

static bool can_be_memory(const Command *command, const Settings *settings)
{
    const int64_t n = command->remembered;
    const Watched *watched = &command->watched;
    if (!state_is_flag(&command->watches) || !(0 <= n && n <= PSP_N)) return false;
    if (!command->watches) return settings->predicts || n == 0;
    return n > 0 && are_finite(n, watched->v) && are_finite(n, watched->a) && are_finite(n, watched->closing);
}

static bool can_be_command(const Command *command, const Settings *settings)
{
    if (!(0 <= command->n && command->n <= PSP_N) || !state_is_count((double)command->violations, 0.0)) return false;
    if (!state_is_count((double)command->faults, 0.0) || !state_is_count((double)command->choices, 0.0)) return false;
    if (!state_is_flag(&command->in_order) || !state_is_flag(&command->in_domain)) return false;
    if (isnan(command->T_max) || isnan(command->T_exact) || !isfinite(command->resolve)) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!isfinite(command->a[i]) || (command->saturated[i] != 0.0 && command->saturated[i] != 1.0)) return false;
    }
    return can_be_basis(&command->basis, command->n, settings) && can_be_memory(command, settings) &&
           state_is_shape(&command->shape, &settings->constants, settings->request.old);
}

/* Whether the communication point is the one that the front remembers and the next sampling instant is near it, to a
 * period or two: a step from elsewhere would pass instants without end. */
static bool can_be_here(const Part *part, const Progress *progress, const Clock *clock)
{
    return fabs((double)(part->sampled - clock->period)) <= 2.0 && progress->time == clock->time;
}

bool part_restore(Model *model, const Progress *progress)
{
    Front nobody = {0}; /* hears nothing */
    Part *part = &model->part;
    if (!read_settings(&nobody, model->values, &part->settings)) return false;
    if (!state_is_flag(&part->fresh) || !state_is_flag(&part->foreseen) || (part->held != 0 && part->held != 1)) return false;
    Command *held = &part->commands[part->held], *other = &part->commands[1 - part->held];
    if (!part->foreseen) *other = *held; /* nobody reads it */
    if (!can_be_command(held, &part->settings) || !can_be_command(other, &part->settings)) return false;
    if (!actuators_can_be(&part->issued, part->settings.rows)) return false;
    if (!isfinite(part->set_at) || !(part->set_at <= (double)model->clock.period + model->clock.offset + 1.0)) return false;
    if (!state_is_count((double)part->sampled, 0.0)) return false;
    return progress->mode != STEP_COMPLETE || can_be_here(part, progress, &model->clock);
}
