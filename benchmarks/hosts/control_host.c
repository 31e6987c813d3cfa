/* A C host that measures a controller: in every sampling period all spacings and speeds are set, a step is made, and some
 * outputs are read.
 *
 * control_host LIBRARY RESOURCE_URI GUID VEHICLES S V READ COUNT [r|i REFERENCE VALUE]...
 * S and V: references of the first spacing and the first speed; READ and COUNT: of the first output and how many; behind them
 * Real and Integer parameters.  Each line of input, a number of segments of 50 steps, is answered with the seconds per step
 * and the steps of a segment.  200 steps before each segment are not measured: by then commands are on their way.
 */
#define _GNU_SOURCE
#include "host.h"

enum { STEPS = 50, BEFORE = 200, FIXED = 9 };
static const double T = 0.01;

int main(int count, char **words)
{
    void *library = count >= FIXED ? dlopen(words[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) {
        fprintf(stderr, "%s\n", count >= FIXED ? dlerror() : "arguments are missing");
        return 1;
    }
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetReal);
    LOAD(SetReal);
    LOAD(SetInteger);
    LOAD(Reset);
    const fmi2CallbackFunctions callbacks = {message, calloc, free, NULL, NULL};
    fmi2Component c = Instantiate("control", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2False);
    if (!c) return 2;
    const size_t n = (size_t)atoi(words[4]), outputs = (size_t)atoi(words[8]);
    double *values = calloc(outputs, sizeof *values), *seen = calloc(2 * n, sizeof *seen);
    fmi2ValueReference *read = calloc(outputs + 2 * n, sizeof *read), *set = read + outputs;
    for (size_t i = 0; i < outputs; i++) read[i] = (fmi2ValueReference)(atoi(words[7]) + (int)i);
    for (size_t i = 0; i < n; i++) {
        if (i < n - 1) set[i] = (fmi2ValueReference)(atoi(words[5]) + (int)i);
        set[n - 1 + i] = (fmi2ValueReference)(atoi(words[6]) + (int)i);
    }
    puts("ready");
    fflush(stdout);
    for (int segments; scanf("%d", &segments) == 1;) {
        double seconds = 0.0;
        for (int k = 0; k < segments || k == 0; k++) {
            must(Reset(c));
            must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
            for (int i = FIXED; i + 2 < count; i += 3) {
                const fmi2ValueReference reference = (fmi2ValueReference)atoi(words[i + 1]);
                const double real = atof(words[i + 2]);
                const fmi2Integer integer = (fmi2Integer)real;
                must(words[i][0] == 'i' ? SetInteger(c, &reference, 1, &integer) : SetReal(c, &reference, 1, &real));
            }
            for (int i = -BEFORE; i < STEPS; i++) {
                const double from = (i + BEFORE) * T;
                for (size_t j = 0; j < n - 1; j++) seen[j] = 12.0 + 0.05 * (double)(j % 5) + 1e-3 * (double)(i % 3);
                for (size_t j = 0; j < n; j++) seen[n - 1 + j] = 29.0 + 0.01 * (double)(j % 7) + 1e-3 * (double)(i % 2);
                if (i == -BEFORE) {
                    must(EnterInitializationMode(c));
                    must(SetReal(c, set, 2 * n - 1, seen));
                    must(ExitInitializationMode(c));
                }
                const double start = now();
                must(SetReal(c, set, 2 * n - 1, seen));
                must(DoStep(c, from, T, fmi2True));
                must(GetReal(c, read, outputs, values));
                if (i >= 0) seconds += now() - start;
            }
        }
        printf("%.9g %d\n", seconds / (segments ? segments : 1) / STEPS, STEPS);
        fflush(stdout);
    }
    return 0;
}
