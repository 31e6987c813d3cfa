/* Saved states of any native FMU. */
#include <stdlib.h>
#include <string.h>

#include "native_model.h"

fmi2Status backend_get_state(Backend *backend, void **state)
{
    Model *copy = malloc(sizeof *copy);
    if (!copy) return front_fail(backend->front, "there is no memory left for another saved state: free some of them");
    memcpy(copy, &backend->model, sizeof *copy);
    *state = copy;
    return fmi2OK;
}

fmi2Status backend_set_state(Backend *backend, void *state)
{
    memcpy(&backend->model, state, sizeof backend->model);
    return fmi2OK;
}

void backend_free_state(Backend *backend, void *state)
{
    (void)backend;
    free(state);
}

fmi2Status backend_state_size(Backend *backend, void *state, size_t *size)
{
    (void)backend, (void)state;
    *size = sizeof(Model);
    return fmi2OK;
}

fmi2Status backend_write_state(Backend *backend, void *state, char *bytes, size_t size)
{
    (void)backend;
    memcpy(bytes, state, size);
    return fmi2OK;
}

fmi2Status backend_read_state(Backend *backend, const char *bytes, size_t size, void **state)
{
    Model *copy = size == sizeof *copy ? malloc(sizeof *copy) : NULL;
    if (!copy) return front_fail(backend->front, "the saved state has %lu bytes, not the %lu of this FMU: save it again with "
                                                     "this very build", (unsigned long)size, (unsigned long)sizeof *copy);
    memcpy(copy, bytes, size);
    *state = copy;
    return fmi2OK;
}
