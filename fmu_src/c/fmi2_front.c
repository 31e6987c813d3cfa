/* The functions of FMI 2.0 co-simulation, except making and freeing instances (front_check.c) and saved states. */
#include <float.h>
#include <math.h>

#include "front.h"

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean logging_on, size_t count, const fmi2String categories[])
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_SET_DEBUG_LOGGING, &status);
    if (!front) return status;
    if (!front_has(front, CALL_SET_DEBUG_LOGGING, count, categories, categories)) return front_leave(front, fmi2Error);
    front_choose_categories(front, logging_on != fmi2False, count, categories);
    return front_leave(front, fmi2OK);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_SETUP_EXPERIMENT, &status);
    if (!front) return status;
    if (!isfinite(start))
        front_fail(front, "fmi2SetupExperiment was called with startTime = %.10g s: give a finite time", start);
    else if (has_stop && !(stop >= start))
        front_fail(front, "fmi2SetupExperiment was called with stopTime = %.10g s before startTime = %.10g s: stop later",
                   stop, start);
    if (front->worst > fmi2Warning) return front_leave(front, fmi2Error);
    front->progress.setup = 1;
    front->progress.time = front->progress.last_success = front->progress.start = start;
    front->progress.has_stop = has_stop != fmi2False;
    front->progress.stop = has_stop ? stop : 0.0;
    return front_leave(front, backend_setup(front->backend, has_tolerance ? &tolerance : NULL, start,
                                            has_stop ? &stop : NULL));
}

/* Calls `action` of the backend and goes to `next` unless it fails. */
static fmi2Status change_mode(fmi2Component c, Call call, fmi2Status (*action)(Backend *), Mode next)
{
    fmi2Status status;
    Front *front = front_enter(c, call, &status);
    if (!front) return status;
    status = front_judge(front, action(front->backend));
    if (status == fmi2OK) {
        if (next == INSTANTIATED) front->progress = (Progress){.mode = INSTANTIATED};
        front->progress.mode = next;
    }
    return front_leave(front, status);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return change_mode(c, CALL_ENTER_INITIALIZATION, backend_enter_initialization, INITIALIZATION);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return change_mode(c, CALL_EXIT_INITIALIZATION, backend_exit_initialization, STEP_COMPLETE);
}

fmi2Status fmi2Terminate(fmi2Component c) { return change_mode(c, CALL_TERMINATE, backend_terminate, TERMINATED); }

fmi2Status fmi2Reset(fmi2Component c) { return change_mode(c, CALL_RESET, backend_reset, INSTANTIATED); }

#define VARIABLES(function, call, serve, type)                                                                         \
    fmi2Status function(fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[])                    \
    {                                                                                                                  \
        fmi2Status status;                                                                                             \
        Front *front = front_enter(c, call, &status);                                                                  \
        if (!front) return status;                                                                                     \
        if (!front_has(front, call, count, vr, value)) return front_leave(front, fmi2Error);                           \
        return front_leave(front, count == 0 ? fmi2OK : serve(front->backend, vr, count, value));                      \
    }

VARIABLES(fmi2GetReal, CALL_GET_REAL, backend_get_real, fmi2Real)
VARIABLES(fmi2GetInteger, CALL_GET_INTEGER, backend_get_integer, fmi2Integer)
VARIABLES(fmi2GetBoolean, CALL_GET_BOOLEAN, backend_get_boolean, fmi2Boolean)
VARIABLES(fmi2GetString, CALL_GET_STRING, backend_get_string, fmi2String)
VARIABLES(fmi2SetReal, CALL_SET_REAL, backend_set_real, const fmi2Real)
VARIABLES(fmi2SetInteger, CALL_SET_INTEGER, backend_set_integer, const fmi2Integer)
VARIABLES(fmi2SetBoolean, CALL_SET_BOOLEAN, backend_set_boolean, const fmi2Boolean)
VARIABLES(fmi2SetString, CALL_SET_STRING, backend_set_string, const fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
                                        const fmi2ValueReference knowns[], size_t known_count, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_DIRECTIONAL_DERIVATIVE, &status);
    if (!front) return status;
    if (!front_has(front, CALL_DIRECTIONAL_DERIVATIVE, unknown_count, unknowns, sensitivity) ||
        !front_has(front, CALL_DIRECTIONAL_DERIVATIVE, known_count, knowns, seed))
        return front_leave(front, fmi2Error);
    return front_leave(front, backend_directional_derivative(front->backend, unknowns, unknown_count, knowns,
                                                             known_count, seed, sensitivity));
}

/* No FMU interpolates inputs or has derivatives of outputs in time: only the empty request is served. */
static fmi2Status no_derivatives(fmi2Component c, Call call, size_t count)
{
    fmi2Status status;
    Front *front = front_enter(c, call, &status);
    if (!front) return status;
    if (count > 0)
        status = front_fail(front, "%s was called for %lu variables: this FMU has none of these derivatives, leave it out",
                            front_call_name(call), (unsigned long)count);
    else
        status = fmi2OK;
    return front_leave(front, status);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return no_derivatives(c, CALL_SET_INPUT_DERIVATIVES, count);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return no_derivatives(c, CALL_GET_OUTPUT_DERIVATIVES, count);
}

static bool is_single(double value) { return fabs(value) < (double)FLT_MAX && (double)(float)value == value; }

#define LEAST_SLACK 1e-9 /* [s] */

/* Hosts round times: this much [s] is taken for equal; a part of the step at most, but for what a double cannot tell. */
static double slack(double time, double size)
{
    const double rounding = is_single(time) && is_single(size) ? fmin(FLT_EPSILON * fabs(time), 0.25 * size) : 0.0;
    const double printed = fmin(1e-12 * fabs(time), size / 64.0); /* times that went through text */
    return LEAST_SLACK + 1e-6 * size + fmax(4.0 * DBL_EPSILON * fabs(time), fmax(rounding, printed));
}

/* How far behind stopTime a step would end [s], by the host's time or by the sum of its steps, of which one drifts from
 * the other by some rounding in every step. */
static double overrun(const Progress *progress, double from, double size)
{
    const double end = fmin(from + size, progress->start + progress->elapsed + size);
    const double drift = fmin((double)progress->steps * DBL_EPSILON * fabs(end), 0.5 * size);
    return end - progress->stop - drift - slack(from, size);
}

static bool step_allowed(Front *front, double from, double size)
{
    const Progress *progress = &front->progress;
    if (!isfinite(from) || !isfinite(size) || size < 0.0)
        front_fail(front, "fmi2DoStep was called at t = %.10g s with a step of %.10g s: both must be finite and the step "
                          "not negative", from, size);
    else if (fabs(from - progress->time) > LEAST_SLACK && fabs(from - progress->time) > slack(from, size))
        front_fail(front, "fmi2DoStep was called at t = %.10g s, but the FMU is at t = %.10g s: continue from there, or "
                          "go back with fmi2SetFMUstate", from, progress->time);
    else if (progress->has_stop && from + size > progress->stop && overrun(progress, from, size) > 0.0)
        front_fail(front, "fmi2DoStep was called at t = %.10g s with a step of %.10g s, which goes beyond "
                          "stopTime = %.10g s: take a shorter step, or set a later stopTime", from, size, progress->stop);
    return front->worst <= fmi2Warning;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from, fmi2Real size, fmi2Boolean no_set_state)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_DO_STEP, &status);
    if (!front) return status;
    (void)no_set_state;
    double reached = from;
    if (!step_allowed(front, from, size)) return front_leave(front, fmi2Error);
    status = front_judge(front, backend_do_step(front->backend, from, size, &reached));
    front->progress.last_step = status;
    if (status == fmi2OK) {
        front->progress.time = front->progress.last_success = from + size;
        front->progress.elapsed += size;
        front->progress.steps++;
    }
    if (status == fmi2Discard) {
        front->progress.mode = STEP_FAILED;
        front->progress.last_success = reached;
    }
    return front_leave(front, status);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_CANCEL_STEP, &status);
    return front ? front_leave(front, fmi2Error) : status;
}

/* Ends a status inquiry: OK if it could be `answered`. */
static fmi2Status inquiry(Front *front, Call call, bool answered, int kind)
{
    if (!answered)
        front_log(front, fmi2Discard, "%s has nothing to say about status kind %d, or has no place to put it: steps are "
                                      "never pending here", front_call_name(call), kind);
    return front_leave(front, answered ? fmi2OK : fmi2Discard);
}

#define INQUIRY(function, call, type, asked, answer)                                                                   \
    fmi2Status function(fmi2Component c, const fmi2StatusKind kind, type *value)                                       \
    {                                                                                                                  \
        fmi2Status status;                                                                                             \
        Front *front = front_enter(c, call, &status);                                                                  \
        if (!front) return status;                                                                                     \
        const bool answered = value && (asked);                                                                        \
        if (answered) *value = (answer);                                                                               \
        return inquiry(front, call, answered, (int)kind);                                                              \
    }

INQUIRY(fmi2GetStatus, CALL_GET_STATUS, fmi2Status, kind == fmi2DoStepStatus, (fmi2Status)front->progress.last_step)
INQUIRY(fmi2GetRealStatus, CALL_GET_REAL_STATUS, fmi2Real, kind == fmi2LastSuccessfulTime, front->progress.last_success)
INQUIRY(fmi2GetIntegerStatus, CALL_GET_INTEGER_STATUS, fmi2Integer, false, 0)
INQUIRY(fmi2GetBooleanStatus, CALL_GET_BOOLEAN_STATUS, fmi2Boolean, kind == fmi2Terminated, fmi2False)
INQUIRY(fmi2GetStringStatus, CALL_GET_STRING_STATUS, fmi2String, false, "")
