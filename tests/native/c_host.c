/* A small C host without Python: loads an FMU's library, initialises it, steps, prints what it reads.
 *
 * c_host LIBRARY RESOURCE_URI GUID STEP STEPS VR...     one line per step: time and the Real variables VR
 * Exit status 0; 2 if the instance cannot be made, 3 if a call fails.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define SYMBOL(library, name) ((void *)(size_t)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define SYMBOL(library, name) dlsym(library, name)
#endif

static void print_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                          fmi2String message, ...)
{
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s %d %s: ", name, (int)status, category ? category : "");
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void must(fmi2Status status, const char *what)
{
    if (status <= fmi2Warning) return;
    fprintf(stderr, "%s gave status %d\n", what, (int)status);
    exit(3);
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)SYMBOL(library, "fmi2" #name)

int main(int count, char **words)
{
    if (count < 6) return 1;
    void *library = OPEN(words[1]);
    if (!library) {
        fprintf(stderr, "cannot load %s\n", words[1]);
        return 1;
    }
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetReal);
    LOAD(Terminate);
    LOAD(FreeInstance);
    const fmi2CallbackFunctions callbacks = {print_message, calloc, free, NULL, NULL};
    const double step = atof(words[4]);
    const int steps = atoi(words[5]);
    fmi2Component c = Instantiate("host", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2True);
    if (!c) return 2;
    must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0), "fmi2SetupExperiment");
    must(EnterInitializationMode(c), "fmi2EnterInitializationMode");
    must(ExitInitializationMode(c), "fmi2ExitInitializationMode");
    for (int k = 0; k <= steps; k++) {
        if (k > 0) must(DoStep(c, (k - 1) * step, step, fmi2True), "fmi2DoStep");
        printf("%.17g", k * step);
        for (int i = 6; i < count; i++) {
            const fmi2ValueReference vr = (fmi2ValueReference)atoi(words[i]);
            fmi2Real value = 0.0;
            must(GetReal(c, &vr, 1, &value), "fmi2GetReal");
            printf(" %.17g", value);
        }
        putchar('\n');
    }
    must(Terminate(c), "fmi2Terminate");
    FreeInstance(c);
    return 0;
}
