/* All native FMUs in one program, linked statically: each is found under its own prefix, as FMI 2.0 (2.1.1) has it.
 *
 * all_in_one [GUID FIRST COUNT]...    of each FMU, with the references of its outputs: every output of each FMU after each
 *                                     step, in hexadecimal: a line per step
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
FMU(DECLARE, PspPlantNative_)
FMU(DECLARE, PspLeaderNative_)

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
static const Functions ALL[] = {
    {FMU(ADDRESS, PspPlatoonNative_)},
    {FMU(ADDRESS, PspControllerNative_)},
    {FMU(ADDRESS, PspPlantNative_)},
    {FMU(ADDRESS, PspLeaderNative_)},
};

enum { FMUS = sizeof ALL / sizeof *ALL };

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
    fmi2Component made[FMUS];
    if (count < 1 + 3 * FMUS) return 1;
    for (int i = 0; i < FMUS; i++) made[i] = begin(&ALL[i], words[1 + 3 * i], &callbacks);
    for (int k = 0; k < 50; k++) {
        for (int i = 0; i < FMUS; i++) step(&ALL[i], made[i], k, atoi(words[2 + 3 * i]), atoi(words[3 + 3 * i]));
        putchar('\n');
    }
    for (int i = 0; i < FMUS; i++) {
        must(ALL[i].Terminate(made[i]));
        ALL[i].FreeInstance(made[i]);
    }
    return 0;
}
