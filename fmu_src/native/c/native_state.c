/* Saved states and directional derivatives of the native FMU. */
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

/* Outputs that depend on how alpha, r, p were chosen. */
static bool depends_on_choice(fmi2ValueReference reference)
{
    return (reference >= PSP_a && reference < PSP_a + PSP_N) || reference == PSP_alpha || reference == PSP_r ||
           reference == PSP_p || reference == PSP_T_max;
}

static bool derivable(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                      const fmi2ValueReference knowns[], size_t known_count)
{
    const double *values = backend->model.values;
    const bool chosen = values[PSP_potential] == 2.0 && values[PSP_parameter_source] != 2.0;
    for (size_t i = 0; i < known_count; i++) {
        if (knowns[i] >= PSP_FIRST_OUTPUT || native_is_integer(knowns[i])) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative knows no derivative with respect to value reference "
                                       "%d: name Real parameters", (int)knowns[i]);
            return false;
        }
    }
    for (size_t i = 0; i < unknown_count; i++) {
        if (unknowns[i] < PSP_FIRST_OUTPUT || unknowns[i] >= PSP_COUNT) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative knows no derivative of value reference %d: name "
                                       "outputs", (int)unknowns[i]);
            return false;
        }
        if (chosen && known_count > 0 && depends_on_choice(unknowns[i])) {
            front_fail(backend->front, "fmi2GetDirectionalDerivative has no derivative of %s while alpha, r, p come from "
                                       "the network: set parameter_source to 2", PSP_VARIABLE_NAMES[unknowns[i]]);
            return false;
        }
    }
    return true;
}

fmi2Status backend_directional_derivative(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    Model *model = &backend->model;
    if (!derivable(backend, unknowns, unknown_count, knowns, known_count)) return fmi2Error;
    if (known_count > 0 && !model->initialising)
        return front_fail(backend->front, "fmi2GetDirectionalDerivative with respect to initial values is for "
                                          "initialization mode: this FMU has no inputs to derive by afterwards");
    if (model->initialising && !model->has_platoon && !native_initialise(backend)) return fmi2Error;
    double *work = calloc(2 * PSP_COUNT, sizeof *work); /* a seed and a change for every variable */
    if (!work) return front_fail(backend->front, "there is no memory left for derivatives: free some instances");
    for (size_t i = 0; i < known_count; i++) work[knowns[i]] += seed[i];
    if (known_count > 0) platoon_tangent(&model->platoon, work, work + PSP_COUNT);
    for (size_t i = 0; i < unknown_count; i++) sensitivity[i] = work[PSP_COUNT + unknowns[i]];
    free(work);
    return fmi2OK;
}
