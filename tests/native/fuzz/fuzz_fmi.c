/* libFuzzer harness of a native FMU: the input is a sequence of FMI calls with values, in any order.
 *
 * Built with AddressSanitizer and UBSan by tests/native/fuzz/run.py.  Only arguments that no host may pass, such as
 * freed instances or arrays shorter than announced, are left out.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "psp_model.h"

enum { STATES = 4, MOST = 64 };

typedef struct {
    const uint8_t *at, *end;
    fmi2Component component[2];
    fmi2FMUstate states[2][STATES];
    char *bytes; /* the last serialised state */
    size_t size;
    double time[2];
} Session;

static uint8_t byte(Session *session) { return session->at < session->end ? *session->at++ : 0; }

static double number(Session *session)
{
    static const double usual[] = {0.0,  0.01, 0.02,  1.0,   2.0,   3.0,      5.0,     5.5,      9.0,       10.0,
                                   11.0, 20.0, 1e-3,  30.0,  35.0,  -1.0,     1e300,   -1e300,   1e-300,    NAN,
                                   0.1,  0.5,  0.005, 1e-12, 1e100, INFINITY, -1e-320, 4.999999, 5.0000001, -INFINITY};
    const uint8_t kind = byte(session);
    double value = 0.0;
    if (kind < 200) return usual[kind % (sizeof usual / sizeof *usual)];
    if (kind < 228) return byte(session) / 8.0;
    for (size_t i = 0; i < sizeof value; i++) ((uint8_t *)&value)[i] = byte(session);
    return value;
}

/* A step that ends in finite time: at most some hundred sampling periods of the shortest T that initialisation takes. */
static double step_size(Session *session)
{
    static const double usual[] = {0.0, 0.01, 0.005, 0.037, 0.1, -0.01, 1e-9, NAN, INFINITY, 0.01};
    return usual[byte(session) % (sizeof usual / sizeof *usual)];
}

static size_t references(Session *session, fmi2ValueReference vr[MOST])
{
    const size_t count = byte(session) % MOST;
    for (size_t i = 0; i < count; i++) {
        const uint8_t b = byte(session);
        vr[i] = b == 255 ? UINT32_MAX : b == 254 ? PSP_COUNT : b;
    }
    return count;
}

static void ignore(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

static const fmi2CallbackFunctions CALLBACKS = {ignore, calloc, free, NULL, NULL};

static void open_instance(Session *session, int which)
{
    if (!session->component[which])
        session->component[which] = fmi2Instantiate("fuzz", fmi2CoSimulation, PSP_GUID, byte(session) & 1 ? NULL : "file:///x",
                                                    &CALLBACKS, fmi2False, byte(session) & 1);
}

static void close_instance(Session *session, int which)
{
    fmi2FreeInstance(session->component[which]);
    session->component[which] = NULL;
    memset(session->states[which], 0, sizeof session->states[which]); /* freed with the instance */
}

static void variables(Session *session, fmi2Component c, int call)
{
    fmi2ValueReference vr[MOST];
    double reals[MOST] = {0};
    int integers[MOST] = {0};
    const char *texts[MOST] = {NULL};
    const size_t count = references(session, vr);
    if (call == 0) fmi2GetReal(c, vr, count, reals);
    if (call == 1) fmi2GetInteger(c, vr, count, integers);
    if (call == 2) {
        for (size_t i = 0; i < count; i++) reals[i] = vr[i] == PSP_T ? 0.01 : number(session);
#ifdef PSP_rollout_horizon
        for (size_t i = 0; i < count; i++) {
            if (vr[i] == PSP_rollout_horizon) reals[i] = 0.05;
        }
#endif
        fmi2SetReal(c, vr, count, reals);
    }
    if (call == 3) {
        for (size_t i = 0; i < count; i++) integers[i] = (int8_t)byte(session);
        fmi2SetInteger(c, vr, count, integers);
    }
    if (call == 4) fmi2GetBoolean(c, vr, count, integers);
    if (call == 5) fmi2SetString(c, vr, count, texts);
    if (call == 6) fmi2GetReal(c, count & 1 ? NULL : vr, count, NULL);
    if (call == 7) fmi2GetDirectionalDerivative(c, vr, count / 2, vr + count / 2, count - count / 2, reals, reals + MOST / 2);
}

/* Makes the checksum fit what was changed (fmu_src/c/front_state.c), as a forger would. */
static void seal(char *bytes, size_t size)
{
    enum { SUM = 8, SUMMED = 16 };
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t i = SUMMED; i < size; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
    memcpy(bytes + SUM, &sum, sizeof sum);
}

static void states(Session *session, fmi2Component c, int which, int call)
{
    fmi2FMUstate *state = &session->states[which][byte(session) % STATES];
    size_t size = 0;
    if (call == 0) fmi2GetFMUstate(c, state);
    if (call == 1) fmi2SetFMUstate(c, *state);
    if (call == 2) fmi2FreeFMUstate(c, state);
    if (call == 3 && fmi2SerializedFMUstateSize(c, *state, &size) == fmi2OK) {
        char *bytes = malloc(size);
        if (fmi2SerializeFMUstate(c, *state, bytes, size - (byte(session) & 1)) == fmi2OK) {
            free(session->bytes);
            session->bytes = bytes;
            session->size = size;
        } else {
            free(bytes);
        }
    }
    if (call == 4 && session->bytes) {
        fmi2FMUstate read = NULL;
        const size_t cut = byte(session) % 3 ? 0 : byte(session) % session->size;
        const size_t place = byte(session) % 2 ? (byte(session) * 37u) % session->size : session->size;
        if (place < session->size) session->bytes[place] ^= (char)(1 << (byte(session) % 8));
        if (byte(session) % 2) seal(session->bytes, session->size);
        if (fmi2DeSerializeFMUstate(c, session->bytes, session->size - cut, &read) == fmi2OK) {
            fmi2SetFMUstate(c, read);
            fmi2FreeFMUstate(c, &read);
        }
    }
}

static void any_call(Session *session)
{
    static const fmi2String categories[] = {"logAll", "logStatusError", "nonsense", NULL};
    const uint8_t code = byte(session);
    const int which = code >> 7;
    fmi2Component c = session->component[which];
    const int call = code & 127;
    double size, real;
    int integer;
    fmi2Status status;
    switch (call % 24) {
    case 0: open_instance(session, which); break;
    case 1: close_instance(session, which); break;
    case 2: fmi2SetupExperiment(c, 0, 0.0, session->time[which] = number(session), byte(session) & 1, number(session)); break;
    case 3: fmi2EnterInitializationMode(c); break;
    case 4: fmi2ExitInitializationMode(c); break;
    case 5: fmi2Terminate(c); break;
    case 6: fmi2Reset(c), session->time[which] = 0.0; break;
    case 7: fmi2SetDebugLogging(c, byte(session) & 1, byte(session) % 5, categories); break;
    case 8: fmi2GetStatus(c, (fmi2StatusKind)(byte(session) % 4), &status); break;
    case 9: fmi2GetRealStatus(c, (fmi2StatusKind)(byte(session) % 4), &real); break;
    case 10: fmi2GetBooleanStatus(c, (fmi2StatusKind)(byte(session) % 4), &integer); break;
    case 11: fmi2CancelStep(c); break;
    case 12: fmi2GetRealOutputDerivatives(c, NULL, byte(session) % 2, NULL, NULL); break;
    case 13: states(session, c, which, byte(session) % 5); break;
    case 14: case 15: states(session, c, which, byte(session) % 2); break;
    case 16: case 17: case 18: variables(session, c, byte(session) % 8); break;
    case 19: /* as a well-behaved host would begin */
        open_instance(session, which);
        fmi2EnterInitializationMode(session->component[which]);
        fmi2ExitInitializationMode(session->component[which]);
        break;
    default:
        size = step_size(session);
        if (fmi2DoStep(c, session->time[which], size, 1) <= fmi2Warning) session->time[which] += size;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Session session = {.at = data, .end = data + size};
    for (int calls = 0; session.at < session.end && calls < 100; calls++) any_call(&session);
    close_instance(&session, 0);
    close_instance(&session, 1);
    free(session.bytes);
    return 0;
}
