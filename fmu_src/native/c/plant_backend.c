/* The backend of the plant; mirrors fmu_src/python/plant_slave.py. */
#include <math.h>
#include <string.h>

#include "native_model.h"

bool part_initialise(Backend *backend) { return plant_begin(&backend->model.part, backend->front, backend->model.values); }

void part_changed(Backend *backend) { (void)backend; } /* parameters are read when the plant is made, inputs in a step */

static bool are_finite(Front *front, const char *name, const double *values, const char *unit)
{
    for (int i = 0; i < PSP_N; i++) {
        if (!finite_element(front, name, i + 1, values[i], unit)) return false;
    }
    return true;
}

fmi2Status backend_do_step(Backend *backend, double from, double size, double *reached)
{
    Model *model = &backend->model;
    Plant *plant = &model->part;
    const double *a = model->values + PSP_a, *automated = model->values + PSP_automated;
    double fraction;
    (void)reached;
    if (!are_finite(backend->front, "a", a, "m/s2") || !are_finite(backend->front, "automated", automated, "1"))
        return fmi2Error;
    if (!clock_pass(&model->clock, from, size, plant->T))
        return front_fail(backend->front, PSP_SENTENCE_periods, from + size - model->clock.first, plant->T);
    plant_advance(plant, clock_at(&model->clock, &fraction), a, automated, &backend->scratch);
    model->stale = 1;
    return fmi2OK;
}

/* Where an output stands among the outputs. */
#define AT(reference) ((reference) - PSP_FIRST_OUTPUT)

bool part_put_out(Backend *backend, double *outputs)
{
    const Plant *plant = &backend->model.part;
    double x = plant->x;
    outputs[AT(PSP_x)] = x;
    for (int i = 1; i < PSP_N; i++) {
        outputs[AT(PSP_x) + i] = x -= plant->s[i - 1];
        outputs[AT(PSP_clearance) + i - 1] = plant->s[i - 1] - plant->length[i - 1];
    }
    memcpy(outputs + AT(PSP_v), plant->v, sizeof plant->v);
    memcpy(outputs + AT(PSP_s), plant->s, sizeof plant->s);
    for (int i = 0; i < PSP_N; i++) outputs[AT(PSP_acceleration) + i] = plant_acceleration(plant, i);
    return true;
}

fmi2Status backend_directional_derivative(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return front_fail(backend->front, "fmi2GetDirectionalDerivative is not provided by the plant: the closed loop, "
                                      "PspPlatoonNative, provides it");
}
