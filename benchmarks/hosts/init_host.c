/* A C host that measures how an FMU begins.
 *
 * init_host LIBRARY RESOURCE_URI GUID SOURCE VALUE      SOURCE < 0: an FMU without parameters
 * A line 0 is answered with the seconds from loading the library to the end of the first doStep, a line k with the
 * seconds per initialisation (enter and exit) over k of them, and 1.
 */
#define _GNU_SOURCE
#include <stdbool.h>

#include "host.h"

int main(int count, char **words)
{
    if (count < 6) return 1;
    const double began = now();
    void *library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(SetInteger);
    LOAD(Reset);
    const fmi2CallbackFunctions callbacks = {message, calloc, free, NULL, NULL};
    const fmi2ValueReference source = (fmi2ValueReference)atoi(words[4]);
    const fmi2Integer value = atoi(words[5]);
    fmi2Component c = Instantiate("start", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2False);
    if (!c) return 2;
    const bool chooses = atoi(words[4]) >= 0;
#define BEGIN()                                                                                                        \
    do {                                                                                                               \
        must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));                                                 \
        if (chooses) must(SetInteger(c, &source, 1, &value));                                                          \
    } while (0)
    BEGIN();
    must(EnterInitializationMode(c));
    must(ExitInitializationMode(c));
    must(DoStep(c, 0.0, 0.01, fmi2True));
    const double first = now() - began;
    puts("ready");
    fflush(stdout);
    for (int request; scanf("%d", &request) == 1;) {
        double seconds = 0.0;
        for (int k = 0; k < request; k++) {
            must(Reset(c));
            BEGIN();
            const double start = now();
            must(EnterInitializationMode(c));
            must(ExitInitializationMode(c));
            seconds += now() - start;
        }
        printf("%.9g 1\n", request ? seconds / request : first);
        fflush(stdout);
    }
    return 0;
}
