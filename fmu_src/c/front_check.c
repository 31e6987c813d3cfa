/* Which function may be called when, and what a returned status does to the instance. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "front.h"

#define PSP_MAGIC UINT64_C(0x5053505f46524f4e)

enum {
    ALIVE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | STEP_FAILED | TERMINATED | IN_ERROR,
    SETTABLE = INSTANTIATED | INITIALIZATION | STEP_COMPLETE,
    READABLE = INITIALIZATION | STEP_COMPLETE | STEP_FAILED | TERMINATED | IN_ERROR,
    STATUS_ASKED = STEP_COMPLETE | STEP_FAILED | TERMINATED
};

/* FMI 2.0.1, section 4.2.4, the table of functions allowed in each state. */
static const struct {
    const char *name;
    unsigned modes;
    bool cleans_up;
} CALLS[] = {
    [CALL_SET_DEBUG_LOGGING] = {"fmi2SetDebugLogging", ALIVE, false},
    [CALL_FREE_INSTANCE] = {"fmi2FreeInstance", ALIVE | IN_FATAL, true},
    [CALL_SETUP_EXPERIMENT] = {"fmi2SetupExperiment", INSTANTIATED, false},
    [CALL_ENTER_INITIALIZATION] = {"fmi2EnterInitializationMode", INSTANTIATED, false},
    [CALL_EXIT_INITIALIZATION] = {"fmi2ExitInitializationMode", INITIALIZATION, false},
    [CALL_TERMINATE] = {"fmi2Terminate", STEP_COMPLETE | STEP_FAILED, true},
    [CALL_RESET] = {"fmi2Reset", ALIVE, true},
    [CALL_GET_REAL] = {"fmi2GetReal", READABLE, false},
    [CALL_GET_INTEGER] = {"fmi2GetInteger", READABLE, false},
    [CALL_GET_BOOLEAN] = {"fmi2GetBoolean", READABLE, false},
    [CALL_GET_STRING] = {"fmi2GetString", READABLE, false},
    [CALL_SET_REAL] = {"fmi2SetReal", SETTABLE, false},
    [CALL_SET_INTEGER] = {"fmi2SetInteger", SETTABLE, false},
    [CALL_SET_BOOLEAN] = {"fmi2SetBoolean", SETTABLE, false},
    [CALL_SET_STRING] = {"fmi2SetString", SETTABLE, false},
    [CALL_GET_STATE] = {"fmi2GetFMUstate", ALIVE, false},
    [CALL_SET_STATE] = {"fmi2SetFMUstate", ALIVE, false},
    [CALL_FREE_STATE] = {"fmi2FreeFMUstate", ALIVE, true},
    [CALL_STATE_SIZE] = {"fmi2SerializedFMUstateSize", ALIVE, false},
    [CALL_SERIALIZE_STATE] = {"fmi2SerializeFMUstate", ALIVE, false},
    [CALL_DESERIALIZE_STATE] = {"fmi2DeSerializeFMUstate", ALIVE, false},
    [CALL_DIRECTIONAL_DERIVATIVE] = {"fmi2GetDirectionalDerivative", READABLE, false},
    [CALL_SET_INPUT_DERIVATIVES] = {"fmi2SetRealInputDerivatives", SETTABLE, false},
    [CALL_GET_OUTPUT_DERIVATIVES] = {"fmi2GetRealOutputDerivatives", STATUS_ASKED | IN_ERROR, false},
    [CALL_DO_STEP] = {"fmi2DoStep", STEP_COMPLETE, false},
    [CALL_CANCEL_STEP] = {"fmi2CancelStep", 0, false},
    [CALL_GET_STATUS] = {"fmi2GetStatus", STATUS_ASKED | IN_ERROR, false},
    [CALL_GET_REAL_STATUS] = {"fmi2GetRealStatus", STATUS_ASKED | IN_ERROR, false},
    [CALL_GET_INTEGER_STATUS] = {"fmi2GetIntegerStatus", STATUS_ASKED | IN_ERROR, false},
    [CALL_GET_BOOLEAN_STATUS] = {"fmi2GetBooleanStatus", STATUS_ASKED | IN_ERROR, false},
    [CALL_GET_STRING_STATUS] = {"fmi2GetStringStatus", STATUS_ASKED | IN_ERROR, false},
};

static const char *mode_name(uint32_t mode)
{
    switch (mode) {
    case INSTANTIATED: return "instantiated";
    case INITIALIZATION: return "initialization mode";
    case STEP_COMPLETE: return "step complete";
    case STEP_FAILED: return "step failed";
    case TERMINATED: return "terminated";
    case IN_ERROR: return "error";
    default: return "fatal";
    }
}

static const char *remedy(uint32_t mode, Call call)
{
    if (call == CALL_CANCEL_STEP) return "leave the call out, a step is always finished when fmi2DoStep returns";
    switch (mode) {
    case INSTANTIATED: return "call fmi2EnterInitializationMode and fmi2ExitInitializationMode first";
    case INITIALIZATION: return "call fmi2ExitInitializationMode first";
    case STEP_COMPLETE: return "call fmi2Reset first, it belongs before or into initialization";
    case STEP_FAILED: return "call fmi2SetFMUstate with an earlier state, fmi2Reset or fmi2Terminate first";
    case TERMINATED: return "call fmi2Reset to run once more, or fmi2FreeInstance";
    case IN_ERROR: return "call fmi2Reset, or fmi2SetFMUstate with a state saved before the error";
    default: return "only fmi2FreeInstance is left, then instantiate anew";
    }
}

const char *front_call_name(Call call) { return CALLS[call].name; }

/* A call while another one of the same instance is running, from its logger or from another thread: it is refused, so that
 * nothing is freed under the running one's feet.  The running call's status is not touched. */
static void refuse_second(Front *front, Call call)
{
    char text[256];
    if (!front->logger || !busy_change(&front->busy, 1, 2)) return; /* 2: the logger answers a refusal with another call */
    snprintf(text, sizeof text, "%s was called while another call of this instance is running, and was refused: wait until "
                                "that one returns", CALLS[call].name);
    front->logger(front->environment, front->name, fmi2Error, "logStatusError", text);
    busy_change(&front->busy, 2, 1); /* unless the running call has ended meanwhile */
}

Front *front_enter(fmi2Component c, Call call, fmi2Status *refusal)
{
    Front *front = c;
    *refusal = fmi2Error;
    if (!front || front->magic != PSP_MAGIC) return NULL; /* not ours, or freed: nobody to tell */
    if (!busy_change(&front->busy, 0, 1)) {
        refuse_second(front, call);
        return NULL;
    }
    front->worst = fmi2OK;
    front->partly = false;
    const uint32_t mode = front->progress.mode;
    if (CALLS[call].modes & mode) return front;
    if (!(CALLS[call].cleans_up && (mode & (IN_ERROR | IN_FATAL)))) /* the error has been told already */
        front_log(front, fmi2Error, "%s was called in state '%s', where it is not allowed: %s", CALLS[call].name,
                  mode_name(mode), remedy(mode, call));
    busy_put(&front->busy, 0);
    /* nothing has happened, so the state stays: a tool that asks too early can still go on as it should */
    *refusal = mode == IN_FATAL ? fmi2Fatal : fmi2Error;
    return NULL;
}

fmi2Status front_judge(Front *front, fmi2Status status)
{
    if (front->worst > status) status = front->worst;
    if (status == fmi2Error && front->progress.mode != IN_FATAL) front->progress.mode = IN_ERROR;
    if (status == fmi2Fatal) front->progress.mode = IN_FATAL;
    return status == fmi2Warning ? fmi2OK : status;
}

fmi2Status front_failure(const Front *front) { return front->partly ? fmi2Discard : fmi2Error; }

fmi2Status front_leave(Front *front, fmi2Status status)
{
    status = front_judge(front, status);
    busy_put(&front->busy, 0);
    return status;
}

bool front_has(Front *front, Call call, size_t count, const void *first, const void *second)
{
    if (count == 0 || (first && second)) return true;
    front_fail(front, "%s was called with a null pointer for %lu values: pass arrays of that length",
               CALLS[call].name, (unsigned long)count);
    return false;
}

/* The name that is handed to the logger: as it is, unless it is no UTF-8. */
static char *copy_of(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy && text_is_utf8(text)) memcpy(copy, text, size);
    else if (copy) text_for_logger(text, false, copy);
    return copy;
}

static bool is_utf8(Front *front, const char *what, const char *text)
{
    Excerpt excerpt;
    if (text_is_utf8(text)) return true;
    front_fail(front, "fmi2Instantiate was called with %s %s, which is no UTF-8: pass it in UTF-8, which FMI 2.0 wants", what,
               text_excerpt(text, &excerpt));
    return false;
}

/* Why an instance cannot be made, logged; true if it can. */
static bool instantiable(Front *front, const char *name, fmi2Type type, const char *guid, const char *resources)
{
    char buffer[128];
    Excerpt excerpt;
    const char *ours = backend_guid(resources, buffer, sizeof buffer);
    if (!name || name[0] == '\0')
        front_fail(front, "fmi2Instantiate was called with an empty instance name: give the instance a name");
    else if (!is_utf8(front, "the instance name", name) || !is_utf8(front, "the GUID", guid ? guid : ""))
        return false;
    else if (type != fmi2CoSimulation)
        front_fail(front, "fmi2Instantiate was asked for model exchange: this FMU does co-simulation only");
    else if (!guid || guid[0] == '\0')
        front_fail(front, "fmi2Instantiate was called without a GUID: pass the one of modelDescription.xml");
    else if (ours[0] != '\0' && strcmp(guid, ours) != 0)
        front_fail(front, "fmi2Instantiate was called with the GUID %s, but this FMU is %s: the model description "
                          "belongs to another build, extract the FMU again", text_excerpt(guid, &excerpt), ours);
    else
        return true;
    return false;
}

static void discard(Front *front)
{
    if (front->backend) backend_free(front->backend);
    free(front->name);
    for (size_t i = 0; i < sizeof *front; i++) ((volatile unsigned char *)front)[i] = 0; /* plain stores would be left out */
    free(front);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging_on)
{
    Front *front = functions ? calloc(1, sizeof *front) : NULL;
    if (!front) return NULL; /* nobody to tell */
    char *resources = location ? resource_path(location) : NULL;
    front->magic = PSP_MAGIC;
    front->logger = functions->logger;
    front->environment = functions->componentEnvironment;
    front->logging = logging_on != fmi2False;
    front->categories = LOG_ALL;
    front->progress.mode = INSTANTIATED;
    front->name = copy_of(name ? name : "");
    if (front->name && instantiable(front, name, type, guid, resources)) {
        front->identity = front_hash(guid, strlen(guid));
        front->backend = backend_new(front, guid, resources, visible != fmi2False);
    }
    free(resources);
    if (front->backend) return front;
    discard(front);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c)
{
    fmi2Status refusal;
    Front *front = front_enter(c, CALL_FREE_INSTANCE, &refusal);
    if (!front) return;
    front_free_states(front);
    discard(front);
}
