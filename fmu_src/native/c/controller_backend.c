/* The backend of the controller: its sampling instants lie at start + phase + k T.
 *
 * At a communication point that is one, the command is computed from the inputs set there: when the outputs are read after
 * inputs were set, at the latest when the next step begins.  Instants inside a communication step use the inputs from its
 * beginning.  Mirrors fmu_src/python/controller_slave.py. */
#include <math.h>
#include <string.h>

#include "native_model.h"

/* The communication point [sampling periods] since the first sampling instant. */
static double here(const Clock *clock)
{
    double fraction;
    const int64_t period = clock_at(clock, &fraction);
    return (double)period + fraction;
}

bool part_initialise(Backend *backend)
{
    Part *part = &backend->model.part;
    Clock *clock = &backend->model.clock;
    memset(part, 0, offsetof(Part, issued));
    if (!read_settings(backend->front, backend->model.values, &part->settings)) return false;
    actuators_begin(&part->issued, part->settings.rows);
    nothing_decided(&part->settings, &part->commands[part->held]);
    clock_begin(clock, clock->time, part->settings.phase, part->settings.T);
    part->set_at = here(clock);
    part->fresh = true;
    return true;
}

void part_changed(Backend *backend)
{
    Part *part = &backend->model.part;
    part->foreseen = false;
    part->fresh = true;
    part->set_at = here(&backend->model.clock);
}

/* Decides at the next sampling instant from the inputs as they are now, into the command that is not held. */
static bool sample(Backend *backend)
{
    Model *model = &backend->model;
    Part *part = &model->part;
    const double *read = model->values;
    const double T = part->settings.T, time = clock_time_of(&model->clock, part->sampled, T);
    const double taken = read[PSP_t_measured];
    const double age = taken < 0.0 ? ((double)part->sampled - part->set_at) * T : time - taken;
    const Measurement measured = {
        .s = read + PSP_s,
        .v = read + PSP_v,
        .n_active = read[PSP_n_active],
        .resolve = read[PSP_resolve],
        .age = age,
        .age_rounding = clock_age_rounding(&model->clock, age, T),
        .v_desired = read[PSP_v_desired],
        .a_desired = read[PSP_a_desired],
        .automated = read + PSP_automated,
        .a_measured = read + PSP_a_measured,
        .a_known = read + PSP_a_known,
    };
    return decide(&part->settings, backend->front, time, &measured, &part->issued, &part->commands[part->held],
                  &part->commands[1 - part->held], &backend->scratch);
}

/* The decision is held from now on. */
static void hold(Backend *backend)
{
    Part *part = &backend->model.part;
    give_commands(&part->settings, &part->issued, &part->commands[part->held], &part->commands[1 - part->held],
                  &backend->scratch);
    part->held = 1 - part->held;
    part->foreseen = false;
}

/* Where an instant behind another one of the step is refused: the step ends there, where newer inputs may come, and the
 * command held is shown. */
static fmi2Status end_early(Backend *backend, double from, double *reached)
{
    Model *model = &backend->model;
    Part *part = &model->part;
    if (backend->front->partly) {
        *reached = clock_time_of(&model->clock, part->sampled, part->settings.T);
        clock_pass(&model->clock, from, *reached - from, part->settings.T);
        part->fresh = false;
    }
    return front_failure(backend->front);
}

fmi2Status backend_do_step(Backend *backend, double from, double size, double *reached)
{
    Model *model = &backend->model;
    Part *part = &model->part;
    Clock clock = model->clock;
    double fraction;
    if (size <= 0.0) return fmi2OK;
    if (!clock_pass(&clock, from, size, part->settings.T))
        return front_fail(backend->front, PSP_SENTENCE_periods, from + size - clock.first, part->settings.T);
    const int64_t period = clock_at(&clock, &fraction);
    model->stale = 1;
    for (; part->sampled < period + (fraction > 0.0); part->sampled++) { /* at the end newer inputs may come */
        if (!part->foreseen && !sample(backend)) return end_early(backend, from, reached);
        hold(backend);
        backend->front->partly = true;
    }
    model->clock = clock;
    part->fresh = false;
    return fmi2OK;
}

/* The command to show: that of this instant, if it is one and inputs were set here, else the one held; NULL on failure. */
static const Command *shown(Backend *backend)
{
    Part *part = &backend->model.part;
    double fraction;
    if (!part->fresh || part->sampled > clock_at(&backend->model.clock, &fraction))
        return &part->commands[part->held];
    if (!part->foreseen) {
        if (!sample(backend)) return NULL;
        part->foreseen = true;
    }
    return &part->commands[1 - part->held];
}

/* Where an output stands among the outputs. */
#define AT(reference) ((reference) - PSP_FIRST_OUTPUT)

/* The state that a decision was based on, zeros behind the vehicles that there were. */
static void put_basis(const Command *command, double *outputs)
{
    const Basis *basis = &command->basis;
    const size_t n = (size_t)command->n, spacings = n > 0 ? n - 1 : 0, one = sizeof(double);
    double *const s = outputs + AT(PSP_s_predicted), *const v = outputs + AT(PSP_v_predicted);
    memcpy(s, basis->as_measured ? basis->s : basis->s_predicted, spacings * one);
    memset(s + spacings, 0, (PSP_N - 1 - spacings) * one);
    memcpy(v, basis->as_measured ? basis->v : basis->v_predicted, n * one);
    memset(v + n, 0, (PSP_N - n) * one);
}

bool part_put_out(Backend *backend, double *outputs)
{
    const Command *command = shown(backend);
    const Settings *settings = &backend->model.part.settings;
    if (!command) return false;
    memcpy(outputs + AT(PSP_a), command->a, sizeof command->a);
    memcpy(outputs + AT(PSP_saturated), command->saturated, sizeof command->saturated);
    outputs[AT(PSP_alpha)] = command->shape.alpha;
    outputs[AT(PSP_r)] = command->shape.r;
    outputs[AT(PSP_p)] = command->shape.p;
    outputs[AT(PSP_network_in_domain)] = command->in_domain ? 1.0 : 0.0;
    outputs[AT(PSP_T_max)] = fmin(command->T_max, LONGEST);
    outputs[AT(PSP_lemma1_ok)] = command->T_max > settings->T ? 1.0 : 0.0;
    outputs[AT(PSP_certified)] = certified_period(settings, command) > settings->T ? 1.0 : 0.0;
    outputs[AT(PSP_lemma1_violations)] = (double)command->violations;
    outputs[AT(PSP_input_ok)] = command->in_order ? 1.0 : 0.0;
    outputs[AT(PSP_input_faults)] = (double)command->faults;
    outputs[AT(PSP_choices)] = (double)command->choices;
    put_basis(command, outputs);
    followed_of(settings, command, outputs + AT(PSP_followed));
    return true;
}

bool part_put_late(Backend *backend, fmi2ValueReference reference, double *output)
{
    const Command *command = shown(backend);
    const Settings *settings = &backend->model.part.settings;
    if (!command) return false;
    if (reference == PSP_T_exact) *output = fmin(exact_of(settings, command), LONGEST);
    else *output = margin_of(settings, command, &backend->scratch);
    return true;
}

fmi2Status backend_directional_derivative(Backend *backend, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return front_fail(backend->front, "fmi2GetDirectionalDerivative is not provided by the controller: the closed loop, "
                                      "PspPlatoonNative, provides it");
}
