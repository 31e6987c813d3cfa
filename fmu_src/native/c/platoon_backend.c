/* The backend of the closed loop: initialisation, steps and outputs over the platoon in C; mirrors
 * fmu_src/python/platoon_slave.py. */
#include <math.h>
#include <string.h>

#include "native_model.h"

bool part_initialise(Backend *backend)
{
    Part *part = &backend->model.part;
    Platoon *platoon = &part->platoon;
    Request request;
    const double *values = backend->model.values;
    double *room = backend->scratch.s;
    if (!platoon_read(platoon, backend->front, values, &request) ||
        !read_leader(backend->front, values, platoon->constants.v_max, &platoon->leader))
        return false;
    platoon_settle(platoon);
    contact_spacing(&platoon->constants, &platoon->cooperation, request.n, request.s, room);
    request.s = room;
    if (!choose_shape(backend->front, &platoon->constants, &platoon->weights, platoon->T, &request, &platoon->shape))
        return false;
    part->period = 0;
    part->fraction = 0.0;
    if (!platoon_sample(platoon, backend->front, 0.0, fmi2Error)) return false;
    part_begin(part, request.n, room);
    return true;
}

void part_changed(Backend *backend) { (void)backend; } /* parameters are read when the platoon is made */

/* time */

/* Makes the last instant the communication point of a step from `from`; its time [s], to which such a step passes the
 * instant in spite of rounding: an instant just behind a nominal one, as policy 3 has them, may have no time of its own. */
static double go_back(Model *model, const Clock *before, double from)
{
    Part *part = &model->part;
    const Instant *now = &part->platoon.now;
    const double T = part->platoon.T;
    double fraction;
    const int64_t period = clock_at(before, &fraction);
    double time = before->time + ((double)(now->period - period) + (now->fraction - fraction)) * T;
    for (int tries = 0; tries < 5; tries++) {
        model->clock = *before;
        clock_pass(&model->clock, from, time - from, T);
        part->period = clock_at(&model->clock, &part->fraction);
        if (part->period > now->period || (part->period == now->period && part->fraction >= now->fraction)) break;
        time = nextafter(time, INFINITY);
    }
    return time;
}

/* Takes what is told of the leader, unless there is nothing to take. */
static inline bool take_leader(Backend *backend)
{
    const double *values = backend->model.values;
    Part *part = &backend->model.part;
    Platoon *platoon = &part->platoon;
    const Instant *now = &platoon->now;
    if (values[PSP_leader_automated] == 1.0 && !platoon->leader.driven) return true;
    return platoon_take_leader(platoon, backend->front, values,
                               part->period == now->period && part->fraction == now->fraction);
}

fmi2Status backend_do_step(Backend *backend, double from, double size, double *reached)
{
    Model *model = &backend->model;
    Part *part = &model->part;
    Platoon *platoon = &part->platoon;
    model->stale = 1;
    if (size > 0.0 && (!take_leader(backend) || !part_make_changes(part, backend->front, model->values))) return fmi2Error;
    const Clock before = model->clock;
    fmi2Status status = fmi2Error;
    if (!clock_pass(&model->clock, from, size, platoon->T)) {
        front_fail(backend->front, PSP_SENTENCE_periods, from + size - model->clock.first, platoon->T);
    } else {
        part->period = clock_at(&model->clock, &part->fraction);
        status = platoon_advance(platoon, backend->front, part->period, part->fraction, &backend->scratch);
    }
    if (status == fmi2OK) return status;
    if (status == fmi2Discard) { /* the outputs then show the last instant that was in order */
        *reached = go_back(model, &before, from);
        return status;
    }
    part->period = platoon->now.period; /* the outputs then show the instant that was refused */
    part->fraction = platoon->now.fraction;
    return status;
}

/* outputs */

/* Where an output stands among the outputs. */
#define AT(reference) ((reference) - PSP_FIRST_OUTPUT)

static void put_motion(const Instant *seen, size_t n, double *outputs)
{
    const size_t missing = (PSP_N - n) * sizeof *outputs;
    double x = seen->x;
    outputs[AT(PSP_x)] = x;
    for (size_t i = 1; i < n; i++) outputs[AT(PSP_x) + i] = x -= seen->s[i - 1];
    memcpy(outputs + AT(PSP_v), seen->v, n * sizeof *outputs);
    memcpy(outputs + AT(PSP_a), seen->a, n * sizeof *outputs);
    memcpy(outputs + AT(PSP_s), seen->s, (n - 1) * sizeof *outputs);
    if (missing == 0) return;
    memset(outputs + AT(PSP_x) + n, 0, missing);
    memset(outputs + AT(PSP_v) + n, 0, missing);
    memset(outputs + AT(PSP_a) + n, 0, missing);
    memset(outputs + AT(PSP_s) + n - 1, 0, missing);
}

bool part_put_out(Backend *backend, double *outputs)
{
    const Part *part = &backend->model.part;
    const Platoon *platoon = &part->platoon;
    const Instant *seen = platoon_observe(platoon, part->period, part->fraction, &backend->scratch);
    if (seen->n == PSP_N) put_motion(seen, PSP_N, outputs);
    else put_motion(seen, (size_t)seen->n, outputs);
    outputs[AT(PSP_alpha)] = platoon->shape.alpha;
    outputs[AT(PSP_r)] = platoon->shape.r;
    outputs[AT(PSP_p)] = platoon->shape.p;
    outputs[AT(PSP_network_in_domain)] = part->in_domain;
    outputs[AT(PSP_T_max)] = platoon->now.T_max < LONGEST ? platoon->now.T_max : LONGEST;
    outputs[AT(PSP_lemma1_ok)] = platoon->now.T_max > platoon->T ? 1.0 : 0.0;
    outputs[AT(PSP_certified)] = platoon->now.bound > platoon->T ? 1.0 : 0.0;
    outputs[AT(PSP_lemma1_violations)] = (double)platoon->now.violations;
    outputs[AT(PSP_J)] = seen->cost_acceleration + seen->cost_spacings;
    outputs[AT(PSP_J_acceleration)] = seen->cost_acceleration;
    outputs[AT(PSP_J_gap)] = seen->cost_spacings;
    memcpy(outputs + AT(PSP_n_active), &part->members.told, sizeof part->members.told);
    return true;
}

bool part_put_late(Backend *backend, fmi2ValueReference reference, double *output)
{
    (void)reference; /* there is one */
    const Platoon *platoon = &backend->model.part.platoon;
    const double T_exact = platoon->certificate == CERTIFICATE_EXACT ? platoon->now.bound : platoon_exact(platoon);
    *output = T_exact < LONGEST ? T_exact : LONGEST;
    return true;
}
