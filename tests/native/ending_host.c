/* A C host with a Python of its own, which ends before the FMU's instance is freed.
 *
 * ending_host LIBPYTHON LIBRARY RESOURCE_URI GUID [again]     exit status 0 if all went as it must; `again`: Python is
 * started once more before the instance is freed
 */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

static void print_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                          fmi2String message, ...)
{
    (void)environment, (void)name, (void)category, (void)message;
    fprintf(stderr, "status %d\n", (int)status);
}

static void must(int true_, const char *what)
{
    if (true_) return;
    fprintf(stderr, "not so: %s\n", what);
    exit(3);
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)

int main(int count, char **words)
{
    if (count < 5) return 1;
    void *python = dlopen(words[1], RTLD_NOW | RTLD_GLOBAL);
    void *library = python ? dlopen(words[2], RTLD_NOW | RTLD_LOCAL) : NULL;
    must(library != NULL, "both libraries can be loaded");
    void (*Py_Initialize)(void) = (void (*)(void))dlsym(python, "Py_Initialize");
    int (*Py_FinalizeEx)(void) = (int (*)(void))dlsym(python, "Py_FinalizeEx");
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetFMUstate);
    LOAD(FreeInstance);
    const fmi2CallbackFunctions callbacks = {print_message, calloc, free, NULL, NULL};
    fmi2FMUstate state = NULL;
    Py_Initialize();
    fmi2Component c = Instantiate("host", fmi2CoSimulation, words[4], words[3], &callbacks, fmi2False, fmi2True);
    must(c != NULL, "there is an instance");
    must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) == fmi2OK, "it is set up");
    must(EnterInitializationMode(c) == fmi2OK && ExitInitializationMode(c) == fmi2OK, "it is initialised");
    must(DoStep(c, 0.0, 0.01, fmi2True) == fmi2OK && GetFMUstate(c, &state) == fmi2OK, "it runs");
    Py_FinalizeEx();
    if (count > 5) Py_Initialize();
    else must(DoStep(c, 0.01, 0.01, fmi2True) == fmi2Fatal, "a step without Python is fatal");
    FreeInstance(c);
    return 0;
}
