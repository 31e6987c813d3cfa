/* The backend of the leader: its speed is a function of time; mirrors fmu_src/python/leader_slave.py and
 * psp_model/vehicles/leader.py. */
#include <math.h>
#include <string.h>

#include "native_model.h"

#include "psp_kernels.h"
#include "psp_profile.h" /* generated: PSP_PROFILE, whether there is a profile, and its rows */

#define SECOND 1.0 /* [s] the period of its clock: it samples nothing, but meets whole seconds as others meet instants */

#if PSP_PROFILE

static bool read_leader(Front *front, const double *read, Part *part)
{
    part->begin = read[PSP_begin];
    return finite_or_log(front, "begin", part->begin, "s");
}

static double speed(const Part *part, double time)
{
    const double since = time - part->begin;
    int below = 0, above = PSP_PROFILE; /* rows at or before, and all from there on behind, that time */
    while (below < above) {
        const int middle = below + (above - below) / 2;
        if (since < PROFILE_TIMES[middle]) above = middle;
        else below = middle + 1;
    }
    if (below == 0) return PROFILE_SPEEDS[0];
    if (below == PSP_PROFILE) return PROFILE_SPEEDS[PSP_PROFILE - 1];
    return psp_on_line(since, PROFILE_TIMES[below - 1], PROFILE_TIMES[below], PROFILE_SPEEDS[below - 1],
                       PROFILE_SPEEDS[below]);
}

#else

#define TWO_PI 6.283185307179586 /* [1] */

static bool read_leader(Front *front, const double *read, Part *part)
{
    part->high = read[PSP_v_high];
    part->low = read[PSP_v_low];
    part->begin = read[PSP_begin];
    part->period = read[PSP_period];
    if (!finite_or_log(front, "v_high", part->high, "m/s") || !finite_or_log(front, "v_low", part->low, "m/s") ||
        !finite_or_log(front, "begin", part->begin, "s") || !finite_or_log(front, "period", part->period, "s"))
        return false;
    REQUIRE(part->low >= 0.0, PSP_SENTENCE_wave_backwards, part->low);
    REQUIRE(part->low <= part->high, PSP_SENTENCE_wave, part->low, part->high);
    REQUIRE(part->period > 0.0, PSP_SENTENCE_wave_period, part->period);
    return true;
}

static double speed(const Part *part, double time)
{
    if (time < part->begin) return part->high;
    const double angle = TWO_PI * (time - part->begin) / part->period;
    return psp_between(part->high, part->low, isfinite(angle) ? cos(angle) : 1.0); /* beyond what can be counted */
}

#endif

static bool take_parameters(Front *front, const double *values, Part *part)
{
    memset(part, 0, sizeof *part);
    return read_period(front, values, &part->T) && read_leader(front, values, part);
}

bool part_initialise(Backend *backend)
{
    return take_parameters(backend->front, backend->model.values, &backend->model.part);
}

void part_changed(Backend *backend) { (void)backend; } /* parameters are read when the leader is made */

fmi2Status backend_do_step(Backend *backend, double from, double size, double *reached)
{
    Model *model = &backend->model;
    (void)reached;
    if (!clock_pass(&model->clock, from, size, SECOND))
        return front_fail(backend->front, PSP_SENTENCE_periods, from + size - model->clock.first, SECOND);
    model->stale = 1;
    return fmi2OK;
}

bool part_put_out(Backend *backend, double *outputs)
{
    const Part *part = &backend->model.part;
    const double time = ((double)backend->model.clock.period + backend->model.clock.offset) * SECOND;
    const double now = speed(part, time);
    outputs[0] = now;
    outputs[1] = psp_held_for(now, speed(part, time + part->T), part->T);
    outputs[2] = 0.0; /* nothing is commanded to him */
    return true;
}

bool part_restore(Model *model, const Progress *progress)
{
    Front nobody = {0}; /* hears nothing */
    return take_parameters(&nobody, model->values, &model->part) &&
           (progress->mode != STEP_COMPLETE || progress->time == model->clock.time);
}

fmi2Status backend_directional_derivative(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return front_fail(backend->front, "fmi2GetDirectionalDerivative is not provided by the leader: the closed loop, "
                                      "PspPlatoonNative, provides it");
}
