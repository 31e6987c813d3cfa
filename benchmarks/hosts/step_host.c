/* A C host that measures doStep over one sampling period and getReal of all outputs.
 *
 * step_host LIBRARY RESOURCE_URI GUID VEHICLES OUTPUTS FIRST_OUTPUT S_START V_START SOURCE GAP
 * SOURCE < 0: an FMU without parameters.  Each line of input, a number of segments of 50 steps from the same start, is
 * answered with the seconds per step and the steps of a segment; 0 is answered with the outputs after one segment.
 */
#define _GNU_SOURCE
#include "host.h"

enum { STEPS = 50 };
static const double T = 0.01;

int main(int count, char **words)
{
    void *library = count > 10 ? dlopen(words[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) {
        fprintf(stderr, "%s\n", count > 10 ? dlerror() : "arguments are missing");
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
    fmi2Component c = Instantiate("speed", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2False);
    if (!c) return 2;
    const size_t n = (size_t)atoi(words[4]), outputs = (size_t)atoi(words[5]);
    const fmi2ValueReference source = (fmi2ValueReference)atoi(words[9]);
    const fmi2Integer fixed = 2;
    double *values = calloc(outputs, sizeof *values), *s = calloc(n, sizeof *s), *v = calloc(n, sizeof *v);
    fmi2ValueReference *all = calloc(outputs + 2 * n, sizeof *all), *spacings = all + outputs, *speeds = spacings + n;
    for (size_t i = 0; i < outputs; i++) all[i] = (fmi2ValueReference)(atoi(words[6]) + (int)i);
    for (size_t i = 0; i < n; i++) {
        spacings[i] = (fmi2ValueReference)(atoi(words[7]) + (int)i);
        speeds[i] = (fmi2ValueReference)(atoi(words[8]) + (int)i);
        s[i] = atof(words[10]) + 0.05 * (double)(i % 5);
        v[i] = 30.0 + 0.01 * (double)(i % 7);
    }
    puts("ready");
    fflush(stdout);
    for (int segments; scanf("%d", &segments) == 1;) {
        double seconds = 0.0;
        for (int k = 0; k < segments || k == 0; k++) {
            must(Reset(c));
            must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
            if (atoi(words[9]) >= 0) {
                must(SetInteger(c, &source, 1, &fixed));
                must(SetReal(c, spacings, n - 1, s));
                must(SetReal(c, speeds, n, v));
            }
            must(EnterInitializationMode(c));
            must(ExitInitializationMode(c));
            const double start = now();
            for (int i = 0; i < STEPS; i++) {
                must(DoStep(c, i * T, T, fmi2True));
                must(GetReal(c, all, outputs, values));
            }
            seconds += now() - start;
        }
        if (segments > 0) printf("%.9g %d", seconds / segments / STEPS, STEPS);
        for (size_t i = 0; segments == 0 && i < outputs; i++) printf("%.17g ", values[i]);
        putchar('\n');
        fflush(stdout);
    }
    return 0;
}
