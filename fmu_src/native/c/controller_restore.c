/* Whether the controller can be as bytes say: mirrors fmu_src/python/controller_slave.py.  What follows from
 * the parameters is computed anew, the rest is checked. */
#include <math.h>
#include <string.h>

#include "native_model.h"

static bool can_be_command(const Command *command, const Settings *settings)
{
    if (!(0 <= command->n && command->n <= PSP_N) || !state_is_count((double)command->violations, 0.0)) return false;
    if (!state_is_count((double)command->faults, 0.0) || !state_is_count((double)command->choices, 0.0)) return false;
    if (!state_is_flag(&command->in_order) || !state_is_flag(&command->in_domain)) return false;
    if (isnan(command->T_max) || !isfinite(command->resolve)) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!isfinite(command->a[i]) || (command->saturated[i] != 0.0 && command->saturated[i] != 1.0)) return false;
    }
    return state_is_shape(&command->shape, &settings->constants, settings->request.old);
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
    if (!state_is_flag(&part->fresh) || !state_is_flag(&part->foreseen)) return false;
    if (!part->foreseen) part->ahead = part->now; /* nobody reads it */
    if (!can_be_command(&part->now, &part->settings) || !can_be_command(&part->ahead, &part->settings)) return false;
    if (!isfinite(part->set_at) || !(part->set_at <= (double)model->clock.period + model->clock.offset + 1.0)) return false;
    if (!state_is_count((double)part->sampled, 0.0)) return false;
    return progress->mode != STEP_COMPLETE || can_be_here(part, progress, &model->clock);
}
