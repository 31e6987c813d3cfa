/* The backend of the Python FMU: forwards to pythonfmu's library, which runs the slave in resources/.
 *
 * pythonfmu can return fmi2OK, fmi2Discard (do_step gave False) and fmi2Fatal (an exception) only.  The slave therefore
 * logs what went wrong with its status, and the front makes the worst status logged the status of the call.  After an
 * exception pythonfmu's instance holds freed Python objects: it is never touched again, not even to free it.
 * Its library stays loaded for good, because numpy cannot be loaded twice into one process.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "front.h"
#include "library.h"
#include "python_library.h"

#ifdef _WIN32
#include <windows.h>
#define EXPORT_LIBRARY "/binaries/win64/pythonfmu-export.dll"
#else
#define EXPORT_LIBRARY "/binaries/linux64/libpythonfmu-export.so"
#endif

#define FUNCTIONS(X)                                                                                                   \
    X(Instantiate) X(FreeInstance) X(SetupExperiment) X(EnterInitializationMode) X(ExitInitializationMode)             \
    X(Terminate) X(Reset) X(DoStep) X(GetReal) X(GetInteger) X(SetReal) X(SetInteger)       \
    X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate) X(SerializedFMUstateSize)                 \
    X(SerializeFMUstate) X(DeSerializeFMUstate)

enum { TIME_REFERENCE = 0x7fffffff }; /* under which our slaves tell us the time that they have come to; no host may ask */

struct Backend {
#define X(name) fmi2##name##TYPE *name;
    FUNCTIONS(X)
#undef X
    Front *front;
    fmi2Component component;
    fmi2CallbackFunctions callbacks; /* pythonfmu keeps a pointer to it */
    bool dead;                       /* pythonfmu failed fatally */
};

/* What pythonfmu logs is text, not a format. */
static void receive_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                            fmi2String message, ...)
{
    (void)name, (void)category;
    if (status < fmi2OK || status > fmi2Fatal) status = fmi2Error;
    front_log(environment, status, "%s", message ? message : "");
}

static FILE *open_resource(const char *resources, const char *name, const char *ending)
{
    char path[2048];
    const int length = snprintf(path, sizeof path, "%s/%s%s", resources, name, ending);
    return length > 0 && length < (int)sizeof path ? fopen(path, "r") : NULL;
}

/* The first line of a file in resources, "" if there is none. */
static const char *first_line(const char *resources, const char *name, char *buffer, size_t size)
{
    FILE *stream = resources ? open_resource(resources, name, "") : NULL;
    buffer[0] = '\0';
    if (stream) {
        if (fgets(buffer, (int)size, stream)) buffer[strcspn(buffer, "\r\n")] = '\0';
        fclose(stream);
    }
    return buffer;
}

/* A path that pythonfmu, which knows no Unicode on Windows, can open too: the short form of one that is not ASCII. */
static const char *openable(const char *resources, char *buffer, size_t size)
{
#ifdef _WIN32
    wchar_t wide[1024], brief[1024];
    bool ascii = true;
    for (const char *c = resources; *c; c++) ascii = ascii && (unsigned char)*c < 128;
    if (!ascii && MultiByteToWideChar(CP_UTF8, 0, resources, -1, wide, 1024) && GetShortPathNameW(wide, brief, 1024) &&
        WideCharToMultiByte(CP_UTF8, 0, brief, -1, buffer, (int)size, NULL, NULL))
        return buffer;
#endif
    (void)buffer, (void)size;
    return resources;
}

const char *backend_guid(const char *resources, char *buffer, size_t size)
{
    char path[2048];
    return first_line(resources ? openable(resources, path, sizeof path) : NULL, "guid.txt", buffer, size);
}

/* pythonfmu crashes on resources that it cannot read: true if it can. */
static bool readable(Front *front, const char *resources)
{
    char module[256];
    Excerpt excerpt;
    if (!resources || resources[0] == '\0') {
        front_fail(front, "fmi2Instantiate was called without a resource location: pass the URI of the FMU's resources");
        return false;
    }
    if (!text_is_utf8(resources)) { /* pythonfmu crashes on it */
        front_fail(front, "the FMU's resources lie in %s, whose name is no UTF-8: extract the FMU into another folder",
                   text_excerpt(resources, &excerpt));
        return false;
    }
    if (strstr(resources, "%20") || strstr(resources, "file://")) { /* pythonfmu would replace them */
        front_fail(front, "the FMU's resources lie in %s, and pythonfmu cannot open a path with '%%20' in it: extract the "
                          "FMU into another folder", text_excerpt(resources, &excerpt));
        return false;
    }
    first_line(resources, "slavemodule.txt", module, sizeof module);
    FILE *stream = module[0] ? open_resource(resources, module, ".py") : NULL;
    if (!stream) {
        front_fail(front, "the FMU's resources cannot be read in %s: extract the whole FMU and pass the URI of its folder "
                          "'resources'", text_excerpt(resources, &excerpt));
        return false;
    }
    fclose(stream);
    return true;
}

/* pythonfmu's library lets go of the same shared pointer twice when a process on Linux ends, and writes into freed memory:
 * its destructor function runs after the destructor of the pointer.  Letting go once before both is harmless. */
static void (*let_go)(void) = NULL; /* the library's, not an instance's */

static void let_go_at_exit(void) { let_go(); }

static bool load_pythonfmu(Backend *model, const char *resources)
{
    char path[2048], why[512];
    Excerpt excerpt;
    snprintf(path, sizeof path, "%s%s", resources, EXPORT_LIBRARY);
    void *library = library_open(path, false);
    bool found = library != NULL;
#define X(name) found = found && library_function(library, "fmi2" #name, &model->name);
    FUNCTIONS(X)
#undef X
    if (!found)
        front_fail(model->front, "%s cannot be loaded (%s): extract the whole FMU, and install what this message names",
                   text_excerpt(path, &excerpt), library_error(why, sizeof why));
    else if (!let_go && library_function(library, "finalizePythonInterpreter", &let_go))
        atexit(let_go_at_exit);
    return found;
}

Backend *backend_new(Front *front, const char *guid, const char *resources, bool visible)
{
    char path[2048];
    if (resources) resources = openable(resources, path, sizeof path);
    if (!readable(front, resources) || !python_is_running(front)) return NULL;
    Backend *model = calloc(1, sizeof *model);
    if (!model) return NULL;
    model->front = front;
    model->callbacks.logger = receive_message;
    model->callbacks.allocateMemory = calloc;
    model->callbacks.freeMemory = free;
    model->callbacks.componentEnvironment = front;
    if (load_pythonfmu(model, resources))
        model->component = model->Instantiate(front->name, fmi2CoSimulation, guid, resources, &model->callbacks, visible,
                                              fmi2True);
    if (model->component) return model;
    if (front->worst > fmi2Warning)
        front_fail(front, "the Python part of this FMU did not start, the message before says why: install what is missing "
                          "into that Python; `psp doctor` lists what the FMU needs");
    free(model);
    return NULL;
}

void backend_free(Backend *model)
{
    if (!model->dead) model->FreeInstance(model->component);
    free(model);
}

/* The status of a call into pythonfmu: after a fatal error nothing is forwarded any more. */
static fmi2Status judged(Backend *model, fmi2Status status)
{
    if (status >= fmi2Fatal || model->front->worst >= fmi2Fatal) {
        model->dead = true;
        return fmi2Fatal;
    }
    return status;
}

#define FORWARD(call) (model->dead ? fmi2Fatal : judged(model, call))

fmi2Status backend_setup(Backend *model, const double *tolerance, double start, const double *stop)
{
    return FORWARD(model->SetupExperiment(model->component, tolerance != NULL, tolerance ? *tolerance : 0.0, start,
                                          stop != NULL, stop ? *stop : 0.0));
}

fmi2Status backend_enter_initialization(Backend *model) { return FORWARD(model->EnterInitializationMode(model->component)); }

fmi2Status backend_exit_initialization(Backend *model) { return FORWARD(model->ExitInitializationMode(model->component)); }

fmi2Status backend_terminate(Backend *model) { return FORWARD(model->Terminate(model->component)); }

fmi2Status backend_reset(Backend *model) { return FORWARD(model->Reset(model->component)); }

fmi2Status backend_do_step(Backend *model, double from, double size, double *reached)
{
    static const fmi2ValueReference time = TIME_REFERENCE;
    fmi2Status status = FORWARD(model->DoStep(model->component, from, size, fmi2False));
    if (status != fmi2Discard) return status;
    if (model->front->worst == fmi2Discard) return FORWARD(model->GetReal(model->component, &time, 1, reached));
    if (model->front->worst > fmi2Discard) return model->front->worst;
    return front_fail(model->front, "the step at t = %.10g s failed without a reason given: look at the messages before",
                      from);
}

static fmi2Status no_variable(Backend *model, fmi2ValueReference reference, const char *type)
{
    return front_fail(model->front, "value reference %d belongs to no %s variable of this FMU: take it from "
                                    "modelDescription.xml", (int)reference, type);
}

#define VARIABLES(function, name, type)                                                                                \
    fmi2Status function(Backend *model, const fmi2ValueReference vr[], size_t count, type value[])                     \
    {                                                                                                                  \
        return FORWARD(model->name(model->component, vr, count, value));                                               \
    }

fmi2Status backend_get_real(Backend *model, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    for (size_t i = 0; i < count; i++) {
        if (vr[i] == TIME_REFERENCE) return no_variable(model, vr[i], "Real");
    }
    return FORWARD(model->GetReal(model->component, vr, count, value));
}

VARIABLES(backend_get_integer, GetInteger, fmi2Integer)
VARIABLES(backend_set_real, SetReal, const fmi2Real)
VARIABLES(backend_set_integer, SetInteger, const fmi2Integer)

/* Our FMUs have no Boolean and no String variables, and pythonfmu would fail fatally on them. */
#define NONE(function, type, name)                                                                                     \
    fmi2Status function(Backend *model, const fmi2ValueReference vr[], size_t count, type value[])                     \
    {                                                                                                                  \
        (void)count, (void)value;                                                                                      \
        return no_variable(model, vr[0], name);                                                                        \
    }

NONE(backend_get_boolean, fmi2Boolean, "Boolean")
NONE(backend_get_string, fmi2String, "String")
NONE(backend_set_boolean, const fmi2Boolean, "Boolean")
NONE(backend_set_string, const fmi2String, "String")

fmi2Status backend_get_state(Backend *model, void **state) { return FORWARD(model->GetFMUstate(model->component, state)); }

fmi2Status backend_set_state(Backend *model, void *state) { return FORWARD(model->SetFMUstate(model->component, state)); }

void backend_free_state(Backend *model, void *state)
{
    if (!model->dead) model->FreeFMUstate(model->component, &state);
}

fmi2Status backend_state_size(Backend *model, void *state, size_t *size)
{
    return FORWARD(model->SerializedFMUstateSize(model->component, state, size));
}

fmi2Status backend_write_state(Backend *model, void *state, char *bytes, size_t size)
{
    return FORWARD(model->SerializeFMUstate(model->component, state, bytes, size));
}

fmi2Status backend_read_state(Backend *model, const Progress *progress, const char *bytes, size_t size, void **state)
{
    (void)progress; /* before it steps the slave compares its time with the front's */
    fmi2Status status = FORWARD(model->DeSerializeFMUstate(model->component, bytes, size, state));
    if (status != fmi2OK) return status;
    status = FORWARD(model->SetFMUstate(model->component, *state)); /* our slaves check what was read, and do not set it */
    if (model->front->worst >= fmi2Error) backend_free_state(model, *state);
    return status;
}

fmi2Status backend_directional_derivative(Backend *model, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return front_fail(model->front, "fmi2GetDirectionalDerivative is not provided by the Python FMU: use the native one");
}
