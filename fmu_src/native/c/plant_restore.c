/* Whether the plant can be as bytes say: mirrors fmu_src/python/plant_slave.py.  What follows from the parameters is
 * computed anew, the rest is checked. */
#include <math.h>

#include "native_model.h"

static bool can_be_motion(const Plant *plant)
{
    if (!isfinite(plant->x)) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!isfinite(plant->v[i]) || plant->v[i] < 0.0) return false;
        if (i < PSP_N - 1 && !isfinite(plant->s[i])) return false;
    }
    return true;
}

/* Whether the current period is that of the communication point, to one or two: a step from elsewhere would pass periods
 * without end. */
static bool can_be_here(const Plant *plant, const Progress *progress, const Clock *clock)
{
    return fabs((double)(plant->period - clock->period)) <= 2.0 && progress->time == clock->time;
}

bool part_restore(Model *model, const Progress *progress)
{
    Front nobody = {0}; /* hears nothing */
    Plant *plant = &model->part;
    int64_t rows;
    if (!plant_take_vehicles(plant, &nobody, model->values, &rows) || !can_be_motion(plant) ||
        !actuators_can_be(&plant->actuators, rows) || !state_is_count((double)plant->period, 0.0))
        return false;
    return progress->mode != STEP_COMPLETE || can_be_here(plant, progress, &model->clock);
}
