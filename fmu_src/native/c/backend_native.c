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
    backend->model.start_time = backend->model.time = start;
    return fmi2OK;
}

/* initialisation */

bool native_initialise(Backend *backend)
{
    Model *model = &backend->model;
    Request request;
    if (!platoon_read(&model->platoon, backend->front, model->values, &request)) return false;
    model->in_domain = PSP_NETWORK && !outside_domain(request.s, request.v, &model->platoon.constants) ? 1.0 : 0.0;
    if (!platoon_choose(&model->platoon, backend->front, &request)) return false;
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

/* Period and fraction of the communication point. */
static bool locate_now(const Model *model, int64_t *period, double *fraction)
{
    const double periods = platoon_locate(model->time - model->start_time, model->platoon.T, fraction);
    if (!(fabs(periods) < PERIODS_MAX)) return false;
    *period = (int64_t)periods;
    return true;
}

fmi2Status backend_do_step(Backend *backend, double from, double size)
{
    Model *model = &backend->model;
    Platoon *platoon = &model->platoon;
    int64_t period = 0;
    double fraction;
    model->stale = 1;
    model->time = from + size;
    if (!locate_now(model, &period, &fraction)) {
        model->time = from;
        return front_fail(backend->front, "fmi2DoStep was asked for a step of %.10g s, more sampling periods than can be "
                                          "counted: take a shorter step", size);
    }
    if (platoon_advance(platoon, backend->front, period, fraction)) return fmi2OK;
    /* the outputs then show the instant that was refused */
    model->time = model->start_time + ((double)platoon->now.period + platoon->now.fraction) * platoon->T;
    return fmi2Error;
}

/* outputs */

/* The instant that belongs to the communication point: `now`, or `between` filled with the exact polynomial. */
static const Instant *observed(const Model *model, Instant *between)
{
    const Platoon *platoon = &model->platoon;
    int64_t period = 0;
    double fraction;
    locate_now(model, &period, &fraction);
    const double tau = ((double)(period - platoon->now.period) + (fraction - platoon->now.fraction)) * platoon->T;
    if (tau == 0.0) return &platoon->now;
    *between = platoon->now;
    platoon_pass(platoon, between, tau);
    return between;
}

static void put_out(Model *model, const Instant *seen)
{
    double *values = model->values;
    const Platoon *platoon = &model->platoon;
    double x = seen->x;
    values[PSP_x] = x;
    for (int i = 1; i < PSP_N; i++) values[PSP_x + i] = x -= seen->s[i - 1];
    memcpy(values + PSP_v, seen->v, sizeof seen->v);
    memcpy(values + PSP_a, seen->a, sizeof seen->a);
    memcpy(values + PSP_s, seen->s, sizeof seen->s);
    values[PSP_alpha] = platoon->shape.alpha;
    values[PSP_r] = platoon->shape.r;
    values[PSP_p] = platoon->shape.p;
    values[PSP_network_in_domain] = model->in_domain;
    values[PSP_T_max] = platoon->now.T_max;
    values[PSP_lemma1_ok] = platoon->now.T_max > platoon->T ? 1.0 : 0.0;
    values[PSP_lemma1_violations] = (double)platoon->now.violations;
    values[PSP_J] = seen->cost_acceleration + seen->cost_gaps;
    values[PSP_J_acceleration] = seen->cost_acceleration;
    values[PSP_J_gap] = seen->cost_gaps;
}

bool native_refresh(Backend *backend)
{
    Model *model = &backend->model;
    Instant between;
    if (!model->has_platoon && !model->initialising) return true; /* nothing to show yet */
    if (!model->has_platoon && !native_initialise(backend)) return false;
    put_out(model, observed(model, &between));
    model->stale = 0;
    return true;
}
