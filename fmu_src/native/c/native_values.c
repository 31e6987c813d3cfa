/* The variables of any native FMU by value reference; mirrors fmu_src/python/table_slave.py. */
#include <math.h>
#include <string.h>

#include "native_model.h"

#include "psp_table.h" /* generated: start values and names */

void native_start_values(double *values) { memcpy(values, STARTS, sizeof STARTS); }

static fmi2Status unknown_reference(Backend *backend, fmi2ValueReference reference, const char *type)
{
    return front_fail(backend->front, PSP_SENTENCE_reference, (int)reference, type);
}

/* Whether these are all the outputs in order, as when a host reads everything in one go. */
static bool are_all_outputs(const fmi2ValueReference vr[], size_t count)
{
    fmi2ValueReference apart = 0;
    if (count != PSP_COUNT - PSP_FIRST_OUTPUT) return false;
    for (size_t i = 0; i < count; i++) apart |= vr[i] ^ (fmi2ValueReference)(PSP_FIRST_OUTPUT + i);
    return apart == 0;
}

#ifdef PART_LATE
static const fmi2ValueReference LATE[] = {PART_LATE};

enum { LATE_COUNT = sizeof LATE / sizeof *LATE };

static bool is_late(fmi2ValueReference reference)
{
    bool late = false;
    for (int i = 0; i < LATE_COUNT; i++) late = late || reference == LATE[i];
    return late;
}

static bool put_late(Backend *backend, double *outputs)
{
    for (int i = 0; i < LATE_COUNT; i++) {
        if (!part_put_late(backend, LATE[i], outputs + (LATE[i] - PSP_FIRST_OUTPUT))) return false;
    }
    return true;
}

/* What nobody has read yet is no number in `values`. */
static void forget_late(Model *model)
{
    for (int i = 0; i < LATE_COUNT; i++) model->values[LATE[i]] = NAN;
}

static bool require_late(Backend *backend, fmi2ValueReference reference)
{
    Model *model = &backend->model;
    double *value = &model->values[reference];
    return !model->ready || !isnan(*value) || part_put_late(backend, reference, value);
}
#else
static bool is_late(fmi2ValueReference reference) { return (void)reference, false; }
static bool put_late(Backend *backend, double *outputs) { return (void)backend, (void)outputs, true; }
static void forget_late(Model *model) { (void)model; }
static bool require_late(Backend *backend, fmi2ValueReference reference) { return (void)backend, (void)reference, true; }
#endif

/* Brings the outputs in `values` up to date; false on failure, which has been logged. */
static bool refresh(Backend *backend)
{
    Model *model = &backend->model;
    if (!model->ready && !model->initialising) return true; /* nothing to show yet */
    if (!native_make_ready(backend) || !part_put_out(backend, model->values + PSP_FIRST_OUTPUT)) return false;
    forget_late(model);
    model->stale = 0;
    return true;
}

fmi2Status backend_get_real(Backend *backend, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    const Model *model = &backend->model;
    const double *values = model->values;
    if (model->ready && are_all_outputs(vr, count)) /* without a stop in `values` */
        return part_put_out(backend, value) && put_late(backend, value) ? fmi2OK : fmi2Error;
    if (model->stale && !refresh(backend)) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        if (vr[i] >= PSP_COUNT || native_is_integer(vr[i])) return unknown_reference(backend, vr[i], "Real");
        if (is_late(vr[i]) && !require_late(backend, vr[i])) return fmi2Error;
        value[i] = values[vr[i]];
    }
    return fmi2OK;
}

fmi2Status backend_get_integer(Backend *backend, const fmi2ValueReference vr[], size_t count, fmi2Integer value[])
{
    if (backend->model.stale && !refresh(backend)) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        if (!native_is_integer(vr[i])) return unknown_reference(backend, vr[i], "Integer");
        value[i] = (fmi2Integer)backend->model.values[vr[i]];
    }
    return fmi2OK;
}

/* Whether a variable may be set now; logs why not. */
static bool settable(Backend *backend, fmi2ValueReference reference, bool integer)
{
    if (reference >= PSP_COUNT || native_is_integer(reference) != integer)
        unknown_reference(backend, reference, integer ? "Integer" : "Real");
    else if (reference >= PSP_FIRST_OUTPUT)
        front_fail(backend->front, PSP_SENTENCE_output, PSP_VARIABLE_NAMES[reference]);
    else if (reference < PSP_FIRST_INPUT && backend->model.ready && !backend->model.initialising)
        front_fail(backend->front, PSP_SENTENCE_fixed, PSP_VARIABLE_NAMES[reference]);
    else
        return true;
    return false;
}

#define SET(function, type, integer)                                                                                   \
    fmi2Status function(Backend *backend, const fmi2ValueReference vr[], size_t count, const type value[])             \
    {                                                                                                                  \
        bool parameters = false;                                                                                       \
        for (size_t i = 0; i < count; i++) {                                                                           \
            if (!settable(backend, vr[i], integer)) return fmi2Error;                                                  \
            parameters = parameters || vr[i] < PSP_FIRST_INPUT;                                                        \
        }                                                                                                              \
        for (size_t i = 0; i < count; i++) backend->model.values[vr[i]] = (double)value[i];                            \
        if (parameters) backend->model.ready = 0;                                                                      \
        backend->model.stale = 1;                                                                                      \
        part_changed(backend);                                                                                         \
        return fmi2OK;                                                                                                 \
    }

SET(backend_set_real, fmi2Real, false)
SET(backend_set_integer, fmi2Integer, true)

/* The FMU has no Boolean and no String variables. */
#define NONE(function, type, name)                                                                                     \
    fmi2Status function(Backend *backend, const fmi2ValueReference vr[], size_t count, type value[])                   \
    {                                                                                                                  \
        (void)count, (void)value;                                                                                      \
        return unknown_reference(backend, vr[0], name);                                                                \
    }

NONE(backend_get_boolean, fmi2Boolean, "Boolean")
NONE(backend_get_string, fmi2String, "String")
NONE(backend_set_boolean, const fmi2Boolean, "Boolean")
NONE(backend_set_string, const fmi2String, "String")
