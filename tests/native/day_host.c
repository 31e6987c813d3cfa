/* A C host that runs an FMU for a day and asks after every step whether its sampling instant was met.
 *
 * day_host LIBRARY RESOURCE_URI GUID START STEP STEPS KIND COUNTER INPUT [r|i VR VALUE]...
 * KIND: 0: t += h, 1: with differences of times as sizes.  COUNTER: an output that counts sampling instants.  INPUT: is set
 * to 0 after each step; -1: none.  Parameters follow.  Prints the first step after which the count is wrong, or 0.
 * Exit status 0; 2 if the instance cannot be made, 3 if a call fails.
 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

static void print_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                          fmi2String message, ...)
{
    (void)environment, (void)category;
    if (status > fmi2Warning) fprintf(stderr, "%s %d: %s\n", name, (int)status, message);
}

static void must(fmi2Status status, const char *what)
{
    if (status <= fmi2Warning) return;
    fprintf(stderr, "%s gave status %d\n", what, (int)status);
    exit(3);
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)

int main(int count, char **words)
{
    void *library = count < 10 ? NULL : dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return 1;
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetReal);
    LOAD(SetReal);
    LOAD(SetInteger);
    LOAD(FreeInstance);
    const fmi2CallbackFunctions callbacks = {print_message, calloc, free, NULL, NULL};
    const double start = atof(words[4]), h = atof(words[5]), zero = 0.0;
    const long steps = atol(words[6]), kind = atol(words[7]), input = atol(words[9]);
    const fmi2ValueReference counter = (fmi2ValueReference)atol(words[8]), set = (fmi2ValueReference)input;
    double t = start, counted = 0.0;
    fmi2Component c = Instantiate("day", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2False);
    if (!c) return 2;
    must(SetupExperiment(c, fmi2False, 0.0, start, fmi2True, start + (double)steps * h), "fmi2SetupExperiment");
    for (int i = 10; i + 2 < count; i += 3) {
        const fmi2ValueReference vr = (fmi2ValueReference)atol(words[i + 1]);
        const double real = atof(words[i + 2]);
        const int whole = atoi(words[i + 2]);
        must(words[i][0] == 'r' ? SetReal(c, &vr, 1, &real) : SetInteger(c, &vr, 1, &whole), "setting a parameter");
    }
    must(EnterInitializationMode(c), "fmi2EnterInitializationMode");
    must(ExitInitializationMode(c), "fmi2ExitInitializationMode");
    for (long k = 1; k <= steps; k++) {
        const double next = t + h;
        must(DoStep(c, t, kind == 1 ? next - t : h, fmi2True), "fmi2DoStep");
        if (input >= 0) must(SetReal(c, &set, 1, &zero), "fmi2SetReal");
        must(GetReal(c, &counter, 1, &counted), "fmi2GetReal");
        if (counted != (double)(k + 1)) {
            printf("%ld\n", k);
            return 0;
        }
        t = next;
    }
    printf("0\n");
    FreeInstance(c);
    return 0;
}
