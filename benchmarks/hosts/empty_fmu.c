/* An FMU that does nothing, with OUTPUTS outputs: what calling any FMU costs. */
#include <stdlib.h>

#include "fmi2Functions.h"

typedef struct {
    fmi2Real values[OUTPUTS];
} Empty;

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return calloc(1, sizeof(Empty));
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return c ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean keep)
{
    (void)time, (void)step, (void)keep;
    return c ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    for (size_t i = 0; i < count; i++) {
        if (references[i] >= OUTPUTS) return fmi2Error;
        values[i] = ((Empty *)c)->values[references[i]];
    }
    return fmi2OK;
}

/* What hosts look for when they load an FMU, and nobody calls here. */
#define REFUSED(name, ...)                                                                                             \
    fmi2Status name(__VA_ARGS__) { return fmi2Error; }
#define C fmi2Component c
#define SOME const fmi2ValueReference r[], size_t n

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }
REFUSED(fmi2SetDebugLogging, C, fmi2Boolean on, size_t n, const fmi2String names[])
REFUSED(fmi2GetInteger, C, SOME, fmi2Integer v[])
REFUSED(fmi2GetBoolean, C, SOME, fmi2Boolean v[])
REFUSED(fmi2GetString, C, SOME, fmi2String v[])
REFUSED(fmi2SetReal, C, SOME, const fmi2Real v[])
REFUSED(fmi2SetInteger, C, SOME, const fmi2Integer v[])
REFUSED(fmi2SetBoolean, C, SOME, const fmi2Boolean v[])
REFUSED(fmi2SetString, C, SOME, const fmi2String v[])
REFUSED(fmi2GetFMUstate, C, fmi2FMUstate *s)
REFUSED(fmi2SetFMUstate, C, fmi2FMUstate s)
REFUSED(fmi2FreeFMUstate, C, fmi2FMUstate *s)
REFUSED(fmi2SerializedFMUstateSize, C, fmi2FMUstate s, size_t *n)
REFUSED(fmi2SerializeFMUstate, C, fmi2FMUstate s, fmi2Byte b[], size_t n)
REFUSED(fmi2DeSerializeFMUstate, C, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
REFUSED(fmi2GetDirectionalDerivative, C, SOME, const fmi2ValueReference k[], size_t m, const fmi2Real d[], fmi2Real e[])
REFUSED(fmi2SetRealInputDerivatives, C, SOME, const fmi2Integer o[], const fmi2Real v[])
REFUSED(fmi2GetRealOutputDerivatives, C, SOME, const fmi2Integer o[], fmi2Real v[])
REFUSED(fmi2CancelStep, C)
REFUSED(fmi2GetStatus, C, const fmi2StatusKind k, fmi2Status *v)
REFUSED(fmi2GetRealStatus, C, const fmi2StatusKind k, fmi2Real *v)
REFUSED(fmi2GetIntegerStatus, C, const fmi2StatusKind k, fmi2Integer *v)
REFUSED(fmi2GetBooleanStatus, C, const fmi2StatusKind k, fmi2Boolean *v)
REFUSED(fmi2GetStringStatus, C, const fmi2StatusKind k, fmi2String *v)
