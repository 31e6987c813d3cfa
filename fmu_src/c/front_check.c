/* Which function may be called when, and what a returned status does to the instance. */
#include <stdarg.h>
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
} CALLS[] = {
    [CALL_SET_DEBUG_LOGGING] = {"fmi2SetDebugLogging", ALIVE},
    [CALL_FREE_INSTANCE] = {"fmi2FreeInstance", ALIVE | IN_FATAL},
    [CALL_SETUP_EXPERIMENT] = {"fmi2SetupExperiment", INSTANTIATED},
    [CALL_ENTER_INITIALIZATION] = {"fmi2EnterInitializationMode", INSTANTIATED},
    [CALL_EXIT_INITIALIZATION] = {"fmi2ExitInitializationMode", INITIALIZATION},
    [CALL_TERMINATE] = {"fmi2Terminate", STEP_COMPLETE | STEP_FAILED},
    [CALL_RESET] = {"fmi2Reset", ALIVE},
    [CALL_GET_REAL] = {"fmi2GetReal", READABLE},
    [CALL_GET_INTEGER] = {"fmi2GetInteger", READABLE},
    [CALL_GET_BOOLEAN] = {"fmi2GetBoolean", READABLE},
    [CALL_GET_STRING] = {"fmi2GetString", READABLE},
    [CALL_SET_REAL] = {"fmi2SetReal", SETTABLE},
    [CALL_SET_INTEGER] = {"fmi2SetInteger", SETTABLE},
    [CALL_SET_BOOLEAN] = {"fmi2SetBoolean", SETTABLE},
    [CALL_SET_STRING] = {"fmi2SetString", SETTABLE},
    [CALL_GET_STATE] = {"fmi2GetFMUstate", ALIVE},
    [CALL_SET_STATE] = {"fmi2SetFMUstate", ALIVE},
    [CALL_FREE_STATE] = {"fmi2FreeFMUstate", ALIVE},
    [CALL_STATE_SIZE] = {"fmi2SerializedFMUstateSize", ALIVE},
    [CALL_SERIALIZE_STATE] = {"fmi2SerializeFMUstate", ALIVE},
    [CALL_DESERIALIZE_STATE] = {"fmi2DeSerializeFMUstate", ALIVE},
    [CALL_DIRECTIONAL_DERIVATIVE] = {"fmi2GetDirectionalDerivative", READABLE},
    [CALL_SET_INPUT_DERIVATIVES] = {"fmi2SetRealInputDerivatives", SETTABLE},
    [CALL_GET_OUTPUT_DERIVATIVES] = {"fmi2GetRealOutputDerivatives", STATUS_ASKED | IN_ERROR},
    [CALL_DO_STEP] = {"fmi2DoStep", STEP_COMPLETE},
    [CALL_CANCEL_STEP] = {"fmi2CancelStep", 0},
    [CALL_GET_STATUS] = {"fmi2GetStatus", STATUS_ASKED | IN_ERROR},
    [CALL_GET_REAL_STATUS] = {"fmi2GetRealStatus", STATUS_ASKED | IN_ERROR},
    [CALL_GET_INTEGER_STATUS] = {"fmi2GetIntegerStatus", STATUS_ASKED | IN_ERROR},
    [CALL_GET_BOOLEAN_STATUS] = {"fmi2GetBooleanStatus", STATUS_ASKED | IN_ERROR},
    [CALL_GET_STRING_STATUS] = {"fmi2GetStringStatus", STATUS_ASKED | IN_ERROR},
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

/* `busy` may be read by another thread than the one that wrote it; nothing is locked, as a lock would cost every call. */
#if defined(__GNUC__)
#define LOOK(flag) __atomic_load_n(&(flag), __ATOMIC_RELAXED)
#define PUT(flag, value) __atomic_store_n(&(flag), value, __ATOMIC_RELAXED)
static bool change(int32_t *flag, int32_t from, int32_t to)
{
    return __atomic_compare_exchange_n(flag, &from, to, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
}
#else
#define LOOK(flag) (*(volatile int32_t *)&(flag))
#define PUT(flag, value) (*(volatile int32_t *)&(flag) = (value))
static bool change(int32_t *flag, int32_t from, int32_t to)
{
    const bool changes = LOOK(*flag) == from;
    if (changes) PUT(*flag, to);
    return changes;
}
#endif

/* A call while another one of the same instance is running, from its logger or from another thread: it is refused, so that
 * nothing is freed under the running one's feet.  The running call's status is not touched. */
static void refuse_second(Front *front, Call call)
{
    char text[256];
    if (!front->logger || !change(&front->busy, 1, 2)) return; /* 2: the logger answers a refusal with yet another call */
    snprintf(text, sizeof text, "%s was called while another call of this instance is running, and was refused: wait until "
                                "that one returns", CALLS[call].name);
    front->logger(front->environment, front->name, fmi2Error, "logStatusError", "%s", text);
    change(&front->busy, 2, 1); /* unless the running call has ended meanwhile */
}

Front *front_enter(fmi2Component c, Call call, fmi2Status *refusal)
{
    Front *front = c;
    *refusal = fmi2Error;
    if (!front || front->magic != PSP_MAGIC) return NULL; /* not ours, or freed: nobody to tell */
    if (LOOK(front->busy)) {
        refuse_second(front, call);
        return NULL;
    }
    PUT(front->busy, 1);
    front->worst = fmi2OK;
    const uint32_t mode = front->progress.mode;
    if (CALLS[call].modes & mode) return front;
    front_log(front, fmi2Error, "%s was called in state '%s', where it is not allowed: %s", CALLS[call].name,
              mode_name(mode), remedy(mode, call));
    PUT(front->busy, 0);
    /* nothing has happened, so the state stays: a tool that asks too early can still go on as it should */
    *refusal = mode == IN_FATAL ? fmi2Fatal : fmi2Error;
    return NULL;
}

fmi2Status front_leave(Front *front, fmi2Status status)
{
    if (front->worst > status) status = front->worst;
    if (status == fmi2Error && front->progress.mode != IN_FATAL) front->progress.mode = IN_ERROR;
    if (status == fmi2Fatal) front->progress.mode = IN_FATAL;
    PUT(front->busy, 0);
    return status;
}

bool front_has(Front *front, Call call, size_t count, const void *first, const void *second)
{
    if (count == 0 || (first && second)) return true;
    front_fail(front, "%s was called with a null pointer for %lu values: pass arrays of that length",
               CALLS[call].name, (unsigned long)count);
    return false;
}

fmi2Status front_fail(Front *front, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    front_print(text, sizeof text, format, arguments);
    va_end(arguments);
    front_log(front, fmi2Error, "%s", text);
    return fmi2Error;
}

static char *copy_of(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, text, size) : NULL;
}

/* Why an instance cannot be made, logged; true if it can. */
static bool instantiable(Front *front, fmi2Type type, const char *guid, const char *resources)
{
    char buffer[128];
    const char *ours = backend_guid(resources, buffer, sizeof buffer);
    if (front->name[0] == '\0')
        front_fail(front, "fmi2Instantiate was called with an empty instance name: give the instance a name");
    else if (type != fmi2CoSimulation)
        front_fail(front, "fmi2Instantiate was asked for model exchange: this FMU does co-simulation only");
    else if (!guid || guid[0] == '\0')
        front_fail(front, "fmi2Instantiate was called without a GUID: pass the one of modelDescription.xml");
    else if (ours[0] != '\0' && strcmp(guid, ours) != 0)
        front_fail(front, "fmi2Instantiate was called with the GUID %.80s, but this FMU is %s: the model description "
                          "belongs to another build, extract the FMU again", guid, ours);
    else
        return true;
    return false;
}

static void discard(Front *front)
{
    if (front->backend) backend_free(front->backend);
    free(front->name);
    front->magic = 0;
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
    front->progress.mode = INSTANTIATED;
    front->name = copy_of(name ? name : "");
    if (front->name && instantiable(front, type, guid, resources)) {
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
