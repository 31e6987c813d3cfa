/* Making, initialising and resetting instances of any native FMU; mirrors fmu_src/python/table_slave.py. */
#include <stdlib.h>
#include <string.h>

#include "native_model.h"

const char *backend_guid(const char *resources, char *buffer, size_t size)
{
    (void)resources, (void)buffer, (void)size;
    return PSP_GUID;
}

static void put_back(Model *model)
{
    memset(model, 0, offsetof(Model, part) + PART_SIZE);
    native_start_values(model->values);
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
    clock_begin(&backend->model.clock, start, 0.0, 1.0);
    return fmi2OK;
}

bool native_make_ready(Backend *backend)
{
    Model *model = &backend->model;
    if (!model->ready) model->ready = part_initialise(backend);
    return model->ready != 0;
}

fmi2Status backend_enter_initialization(Backend *backend)
{
    backend->model.initialising = 1;
    return fmi2OK;
}

fmi2Status backend_exit_initialization(Backend *backend)
{
    if (!native_make_ready(backend)) return fmi2Error;
    backend->model.initialising = 0;
    backend->model.stale = 1;
    return fmi2OK;
}
