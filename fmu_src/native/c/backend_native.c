/* The backend of the native FMU: variables, initialisation, steps and states over the platoon in C. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "native_model.h"

static const double STARTS[PSP_FIRST_OUTPUT] = PSP_STARTS;

const char *backend_guid(const char *resources, char *buffer, size_t size)
{
    (void)resources, (void)buffer, (void)size;
    return PSP_GUID;
}

static void put_back(Model *model)
{
    memset(model, 0, sizeof *model);
    memcpy(model->values, STARTS, sizeof STARTS);
    model->stale = 1;
}

Backend *backend_new(Front *front, const char *guid, const char *resources, bool visible)
{
    Backend *backend = calloc(1, sizeof *backend);
    (void)guid, (void)resources, (void)visible;
    if (!backend) {
        front_log(front, fmi2Error, "there is no memory left for another instance: free some of them");
        return NULL;
    }
    backend->front = front;
    put_back(&backend->model);
    return backend;
}

void backend_free(Backend *backend) { free(backend); }

fmi2Status backend_reset(Backend *backend)
{
    put_back(&backend->model);
    return fmi2OK;
}

fmi2Status backend_terminate(Backend *backend)
{
    (void)backend;
    return fmi2OK;
}

fmi2Status backend_setup(Backend *backend, const double *tolerance, double start, const double *stop)
{
    (void)tolerance, (void)stop;
    backend->model.start_time = start;
    return fmi2OK;
}

/* initialisation */

bool native_initialise(Backend *backend)
{
    Model *model = &backend->model;
    Request request;
    Platoon *platoon = &model->platoon;
    bool in_domain;
    if (!platoon_read(platoon, backend->front, model->values, &request)) return false;
    model->in_domain =
        network_for(request.n) && !outside_domain(request.n, request.s, request.v, &platoon->constants) ? 1.0 : 0.0;
    if (!choose_shape(backend->front, &platoon->constants, &platoon->weights, platoon->T, &request, &platoon->shape,
                      &in_domain))
        return false;
    model->period = 0;
    model->fraction = 0.0;
    model->has_platoon = platoon_start(&model->platoon, backend->front);
    return model->has_platoon != 0;
}

fmi2Status backend_enter_initialization(Backend *backend)
{
    backend->model.initialising = 1;
    return fmi2OK;
}

fmi2Status backend_exit_initialization(Backend *backend)
{
    if (!backend->model.has_platoon && !native_initialise(backend)) return fmi2Error;
    backend->model.initialising = 0;
    backend->model.stale = 1;
    return fmi2OK;
}

/* time */

fmi2Status backend_do_step(Backend *backend, double from, double size)
{
    Model *model = &backend->model;
    Platoon *platoon = &model->platoon;
    const double periods = locate(from + size - model->start_time, platoon->T, &model->fraction);
    if (!(fabs(periods) < PERIODS_MAX))
        return front_fail(backend->front, "fmi2DoStep was asked for a step of %.10g s, more sampling periods than can be "
                                          "counted: take a shorter step", size);
    model->stale = 1;
    model->period = (int64_t)periods;
    if (platoon_advance(platoon, backend->front, model->period, model->fraction)) return fmi2OK;
    model->period = platoon->now.period; /* the outputs then show the instant that was refused */
    model->fraction = platoon->now.fraction;
    return fmi2Error;
}

/* outputs */

/* The instant that belongs to the communication point: `now`, or `between` filled with the exact polynomial. */
static const Instant *observed(Backend *backend)
{
    const Model *model = &backend->model;
    const Platoon *platoon = &model->platoon;
    const double fraction = model->fraction - platoon->now.fraction;
    const double tau = ((double)(model->period - platoon->now.period) + fraction) * platoon->T;
    if (tau == 0.0) return &platoon->now;
    backend->between = platoon->now;
    pass_time(&platoon->weights, &backend->between, tau);
    return &backend->between;
}

/* Where an output stands among the outputs. */
#define AT(reference) ((reference) - PSP_FIRST_OUTPUT)

void native_put_out(Backend *backend, double *outputs)
{
    const Model *model = &backend->model;
    const Instant *seen = observed(backend);
    const Platoon *platoon = &model->platoon;
    double x = seen->x;
    outputs[AT(PSP_x)] = x;
    for (int i = 1; i < PSP_N; i++) outputs[AT(PSP_x) + i] = x -= seen->s[i - 1];
    memcpy(outputs + AT(PSP_v), seen->v, sizeof seen->v);
    memcpy(outputs + AT(PSP_a), seen->a, sizeof seen->a);
    memcpy(outputs + AT(PSP_s), seen->s, sizeof seen->s);
    outputs[AT(PSP_alpha)] = platoon->shape.alpha;
    outputs[AT(PSP_r)] = platoon->shape.r;
    outputs[AT(PSP_p)] = platoon->shape.p;
    outputs[AT(PSP_network_in_domain)] = model->in_domain;
    outputs[AT(PSP_T_max)] = platoon->now.T_max;
    outputs[AT(PSP_lemma1_ok)] = platoon->now.T_max > platoon->T ? 1.0 : 0.0;
    outputs[AT(PSP_lemma1_violations)] = (double)platoon->now.violations;
    outputs[AT(PSP_J)] = seen->cost_acceleration + seen->cost_gaps;
    outputs[AT(PSP_J_acceleration)] = seen->cost_acceleration;
    outputs[AT(PSP_J_gap)] = seen->cost_gaps;
}

bool native_refresh(Backend *backend)
{
    Model *model = &backend->model;
    if (!model->has_platoon && !model->initialising) return true; /* nothing to show yet */
    if (!model->has_platoon && !native_initialise(backend)) return false;
    native_put_out(backend, model->values + PSP_FIRST_OUTPUT);
    model->stale = 0;
    return true;
}
