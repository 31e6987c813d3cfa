/* Lives of instances in two threads, for ThreadSanitizer and AddressSanitizer: each makes, runs, saves, restores and
 * frees its own.
 *
 * threads ROUNDS    exit status 0; 1 where a call failed or a restored state had another future
 */
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "psp_model.h"

enum { OUTPUTS = PSP_COUNT - PSP_FIRST_OUTPUT };

static int rounds;

static void ignore(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

static void must(bool holds, const char *what)
{
    if (holds) return;
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static fmi2Component begin(const fmi2CallbackFunctions *callbacks)
{
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, PSP_GUID, "file:///x", callbacks, fmi2False, fmi2False);
    must(c && fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) <= fmi2Warning, "no instance");
    must(fmi2EnterInitializationMode(c) <= fmi2Warning && fmi2ExitInitializationMode(c) <= fmi2Warning, "no beginning");
    return c;
}

static void live_once(const fmi2CallbackFunctions *callbacks)
{
    fmi2Component c = begin(callbacks);
    fmi2ValueReference all[OUTPUTS];
    double seen[OUTPUTS], again[OUTPUTS];
    fmi2FMUstate state = NULL, read = NULL;
    size_t size = 0;
    for (int i = 0; i < OUTPUTS; i++) all[i] = (fmi2ValueReference)(PSP_FIRST_OUTPUT + i);
    must(fmi2DoStep(c, 0.0, 0.05, fmi2True) <= fmi2Warning, "a step failed");
    must(fmi2GetFMUstate(c, &state) == fmi2OK && fmi2SerializedFMUstateSize(c, state, &size) == fmi2OK, "no state");
    char *bytes = malloc(size);
    must(bytes && fmi2SerializeFMUstate(c, state, bytes, size) == fmi2OK, "no bytes");
    must(fmi2DoStep(c, 0.05, 0.05, fmi2True) <= fmi2Warning, "a step failed");
    must(fmi2GetReal(c, all, OUTPUTS, seen) == fmi2OK, "no outputs");
    must(fmi2DeSerializeFMUstate(c, bytes, size, &read) == fmi2OK && fmi2SetFMUstate(c, read) == fmi2OK, "not back");
    must(fmi2DoStep(c, 0.05, 0.05, fmi2True) <= fmi2Warning, "a step failed");
    must(fmi2GetReal(c, all, OUTPUTS, again) == fmi2OK, "no outputs");
    for (int i = 0; i < OUTPUTS; i++) must(seen[i] == again[i], "another future");
    free(bytes);
    fmi2FreeInstance(c); /* with its states */
}

static void *live(void *unused)
{
    const fmi2CallbackFunctions callbacks = {ignore, calloc, free, NULL, NULL};
    for (int round = 0; round < rounds; round++) live_once(&callbacks);
    return unused;
}

int main(int words, char **word)
{
    pthread_t threads[2];
    rounds = words > 1 ? atoi(word[1]) : 10;
    for (int i = 0; i < 2; i++) pthread_create(&threads[i], NULL, live, NULL);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    return 0;
}
