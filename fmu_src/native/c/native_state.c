/* Saved states of any native FMU; mirrors fmu_src/python/table_slave.py and fmu_src/python/state_check.py. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "native_model.h"

size_t native_size(const Model *model)
{
    return offsetof(Model, part) + PART_SIZE + (model->ready ? PART_QUEUE(&model->part) : 0);
}

fmi2Status backend_get_state(Backend *backend, void **state)
{
    const size_t size = native_size(&backend->model);
    Model *copy = malloc(size);
    if (!copy) return front_fail(backend->front, "there is no memory left for another saved state: free some of them");
    memcpy(copy, &backend->model, size);
    *state = copy;
    return fmi2OK;
}

fmi2Status backend_set_state(Backend *backend, void *state)
{
    memcpy(&backend->model, state, native_size(state));
    return fmi2OK;
}

void backend_free_state(Backend *backend, void *state)
{
    (void)backend;
    free(state);
}

fmi2Status backend_state_size(Backend *backend, void *state, size_t *size)
{
    (void)backend;
    *size = native_size(state);
    return fmi2OK;
}

fmi2Status backend_write_state(Backend *backend, void *state, char *bytes, size_t size)
{
    (void)backend;
    memcpy(bytes, state, size);
    return fmi2OK;
}

bool state_is_flag(const bool *flag)
{
    unsigned char byte; /* a bool may not even be read where it is neither 0 nor 1 */
    memcpy(&byte, flag, sizeof byte);
    return byte <= 1;
}

bool state_is_count(double value, double least) { return least <= value && value <= PERIODS_MAX && value == floor(value); }

bool state_is_shape(const Shape *shape, const Constants *constants, bool old)
{
    if (old) return shape->alpha == 1.0 && shape->r == 0.0 && shape->p == 0.0 && shape->hill == 0.0;
    return shape->hill == 1.0 && PSP_ALPHA_MIN <= shape->alpha && shape->alpha <= PSP_ALPHA_MAX &&
           PSP_P_MIN <= shape->p && shape->p <= PSP_P_MAX && constants->L < shape->r && shape->r <= constants->lam;
}

static bool is_flag(int32_t value) { return value == 0 || value == 1; }

/* Whether the flags are those that a model has in this state of the front. */
static bool can_be_in(const Model *model, uint32_t mode)
{
    if (!is_flag(model->initialising) || !is_flag(model->ready) || !is_flag(model->stale) || model->unused != 0) return false;
    switch (mode) {
    case INSTANTIATED: return !model->initialising && !model->ready;
    case INITIALIZATION: return model->initialising != 0;
    case IN_ERROR: return true;
    default: return !model->initialising && model->ready;
    }
}

/* Whether the model can be as bytes say, whose sum anybody can forge; leaves nothing in it that was not checked. */
static bool restore(Model *model, const Progress *progress)
{
    const bool begins = (progress->mode & (INSTANTIATED | INITIALIZATION)) != 0;
    if (!can_be_in(model, progress->mode) || !clock_can_be(&model->clock)) return false;
    if (begins && !(progress->time == model->clock.time && clock_is_fresh(&model->clock))) return false;
    for (unsigned i = 0; i < PSP_FIRST_OUTPUT; i++) {
        if (!native_is_integer(i)) continue;
        const double value = model->values[i];
        if (!(INT_MIN <= value && value <= INT_MAX && value == floor(value))) return false;
    }
    if (model->ready) return part_restore(model, progress);
    memset(&model->part, 0, PART_SIZE); /* is made anew before anybody looks at it */
    return true;
}

/* Whether so many bytes can be a model, and are as many as it says. */
static bool has_size(const Model *model, size_t size)
{
    const int64_t rows = PART_ROWS(&model->part);
    return is_flag(model->ready) && 0 <= rows && rows <= PART_MOST_ROWS && size == native_size(model);
}

fmi2Status backend_read_state(Backend *backend, const Progress *progress, const char *bytes, size_t size, void **state)
{
    const size_t least = offsetof(Model, part) + PART_SIZE;
    if (size < least || size > sizeof(Model))
        return front_fail(backend->front, "the saved state has %lu bytes, not the %lu of this FMU: save it again with "
                                          "this very build", (unsigned long)size, (unsigned long)least);
    Model *copy = malloc(size);
    if (!copy) return front_fail(backend->front, "there is no memory left for another saved state: free some of them");
    memcpy(copy, bytes, size);
    *state = copy;
    if (has_size(copy, size) && restore(copy, progress)) return fmi2OK;
    free(copy);
    return front_refuse_state(backend->front);
}
