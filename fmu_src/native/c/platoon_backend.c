/* The backend of the closed loop: initialisation, steps and outputs over the platoon in C. */
#include <math.h>
#include <string.h>

#include "native_model.h"

bool part_initialise(Backend *backend)
{
    Part *part = &backend->model.part;
    Platoon *platoon = &part->platoon;
    Request request;
    bool in_domain;
    if (!platoon_read(platoon, backend->front, backend->model.values, &request)) return false;
    part->in_domain =
        network_for(request.n) && !outside_domain(request.n, request.s, request.v, &platoon->constants) ? 1.0 : 0.0;
    if (!choose_shape(backend->front, &platoon->constants, &platoon->weights, platoon->T, &request, &platoon->shape,
                      &in_domain))
        return false;
    part->period = 0;
    part->fraction = 0.0;
    return platoon_start(platoon, backend->front);
}

void part_changed(Backend *backend) { (void)backend; } /* parameters are read when the platoon is made */

/* time */

fmi2Status backend_do_step(Backend *backend, double from, double size)
{
    Model *model = &backend->model;
    Part *part = &model->part;
    Platoon *platoon = &part->platoon;
    const double periods = locate(from + size - model->start_time, platoon->T, &part->fraction);
    if (!(fabs(periods) < PERIODS_MAX))
        return front_fail(backend->front, "fmi2DoStep was asked for a step of %.10g s, more sampling periods than can be "
                                          "counted: take a shorter step", size);
    model->stale = 1;
    part->period = (int64_t)periods;
    if (platoon_advance(platoon, backend->front, part->period, part->fraction)) return fmi2OK;
    part->period = platoon->now.period; /* the outputs then show the instant that was refused */
    part->fraction = platoon->now.fraction;
    return fmi2Error;
}

/* outputs */

/* The instant that belongs to the communication point: `now`, or the scratch filled with the exact polynomial. */
static const Instant *observed(Backend *backend)
{
    const Part *part = &backend->model.part;
    const Platoon *platoon = &part->platoon;
    const double fraction = part->fraction - platoon->now.fraction;
    const double tau = ((double)(part->period - platoon->now.period) + fraction) * platoon->T;
    if (tau == 0.0) return &platoon->now;
    backend->scratch = platoon->now;
    pass_time(&platoon->weights, &backend->scratch, tau);
    return &backend->scratch;
}

/* Where an output stands among the outputs. */
#define AT(reference) ((reference) - PSP_FIRST_OUTPUT)

bool part_put_out(Backend *backend, double *outputs)
{
    const Part *part = &backend->model.part;
    const Instant *seen = observed(backend);
    const Platoon *platoon = &part->platoon;
    double x = seen->x;
    outputs[AT(PSP_x)] = x;
    for (int i = 1; i < PSP_N; i++) outputs[AT(PSP_x) + i] = x -= seen->s[i - 1];
    memcpy(outputs + AT(PSP_v), seen->v, sizeof seen->v);
    memcpy(outputs + AT(PSP_a), seen->a, sizeof seen->a);
    memcpy(outputs + AT(PSP_s), seen->s, sizeof seen->s);
    outputs[AT(PSP_alpha)] = platoon->shape.alpha;
    outputs[AT(PSP_r)] = platoon->shape.r;
    outputs[AT(PSP_p)] = platoon->shape.p;
    outputs[AT(PSP_network_in_domain)] = part->in_domain;
    outputs[AT(PSP_T_max)] = platoon->now.T_max;
    outputs[AT(PSP_lemma1_ok)] = platoon->now.T_max > platoon->T ? 1.0 : 0.0;
    outputs[AT(PSP_lemma1_violations)] = (double)platoon->now.violations;
    outputs[AT(PSP_J)] = seen->cost_acceleration + seen->cost_gaps;
    outputs[AT(PSP_J_acceleration)] = seen->cost_acceleration;
    outputs[AT(PSP_J_gap)] = seen->cost_gaps;
    return true;
}
