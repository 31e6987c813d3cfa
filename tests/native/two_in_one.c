/* Two native FMUs in one program, linked statically: each is found under its own prefix, as FMI 2.0 (2.1.1) has it.
 *
 * two_in_one GUID_1 GUID_2    every output of each FMU after each step, in hexadecimal: a line per step
 */
#include <stdio.h>
#include <stdlib.h>

#define FMI2_FUNCTION_PREFIX PspPlatoonNative_
#include "fmi2Functions.h"

#define DECLARE(prefix, name) extern fmi2##name##TYPE prefix##fmi2##name;
#define FMU(X, prefix)                                                                                                 \
    X(prefix, Instantiate) X(prefix, SetupExperiment) X(prefix, EnterInitializationMode) X(prefix, FreeInstance)       \
    X(prefix, ExitInitializationMode) X(prefix, DoStep) X(prefix, GetReal) X(prefix, Terminate)
FMU(DECLARE, PspControllerNative_)

typedef struct {
    fmi2InstantiateTYPE *Instantiate;
    fmi2SetupExperimentTYPE *SetupExperiment;
    fmi2EnterInitializationModeTYPE *EnterInitializationMode;
    fmi2FreeInstanceTYPE *FreeInstance;
    fmi2ExitInitializationModeTYPE *ExitInitializationMode;
    fmi2DoStepTYPE *DoStep;
    fmi2GetRealTYPE *GetReal;
    fmi2TerminateTYPE *Terminate;
} Functions;

#define ADDRESS(prefix, name) prefix##fmi2##name,
static const Functions PLATOON = {FMU(ADDRESS, PspPlatoonNative_)}, CONTROLLER = {FMU(ADDRESS, PspControllerNative_)};

static void say(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    (void)e, (void)category;
    fprintf(stderr, "%s %d %s\n", name, (int)status, text);
}

static void must(fmi2Status status)
{
    if (status != fmi2OK) exit(3);
}

static fmi2Component begin(const Functions *of, const char *guid, const fmi2CallbackFunctions *callbacks)
{
    fmi2Component c = of->Instantiate("one", fmi2CoSimulation, guid, "file:///x", callbacks, fmi2False, fmi2True);
    if (!c) exit(2);
    must(of->SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    must(of->EnterInitializationMode(c));
    must(of->ExitInitializationMode(c));
    return c;
}

static void step(const Functions *of, fmi2Component c, int k, int first, int count)
{
    must(of->DoStep(c, 0.01 * k, 0.01, fmi2True));
    for (int i = 0; i < count; i++) {
        const fmi2ValueReference reference = (fmi2ValueReference)(first + i);
        double value;
        must(of->GetReal(c, &reference, 1, &value));
        printf("%a ", value);
    }
}

int main(int count, char **words)
{
    const fmi2CallbackFunctions callbacks = {say, calloc, free, NULL, NULL};
    if (count < 7) return 1;
    fmi2Component one = begin(&PLATOON, words[1], &callbacks), other = begin(&CONTROLLER, words[2], &callbacks);
    for (int k = 0; k < 50; k++) {
        step(&PLATOON, one, k, atoi(words[3]), atoi(words[4]));
        step(&CONTROLLER, other, k, atoi(words[5]), atoi(words[6]));
        putchar('\n');
    }
    must(PLATOON.Terminate(one));
    must(CONTROLLER.Terminate(other));
    PLATOON.FreeInstance(one);
    CONTROLLER.FreeInstance(other);
    return 0;
}
