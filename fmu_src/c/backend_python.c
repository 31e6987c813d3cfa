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
#include "python_host.h"
#include "python_library.h"
#include "python_resources.h"

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
    void (*let_go)(void);            /* see LET_GO; NULL if the library has no such function */
    void *generation;                /* of Python, see python_host.h */
    bool explained;                  /* the slave has said what is missing */
    bool dead;                       /* pythonfmu failed fatally, or Python has ended */
};

/* pythonfmu begins the text of an exception like this; what follows the second mark is a sentence of surroundings.py. */
#define FATAL_TEXT "Fatal py exception encountered: "
#define SENTENCE "\npsp: "

/* What pythonfmu logs is text, not a format. */
static void receive_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                            fmi2String message, ...)
{
    Backend *model = environment;
    const char *sentence = NULL;
    (void)name, (void)category;
    if (status < fmi2OK || status > fmi2Fatal) status = fmi2Error;
    if (!message) message = "";
    if (strncmp(message, FATAL_TEXT, strlen(FATAL_TEXT)) == 0) sentence = strstr(message, SENTENCE);
    if (sentence) model->explained = true;
    front_log(model->front, sentence ? fmi2Error : status, "%s", sentence ? sentence + strlen(SENTENCE) : message);
}

const char *backend_guid(const char *resources, char *buffer, size_t size)
{
    char path[2048];
    return first_line(resources ? openable(resources, path, sizeof path) : NULL, "guid.txt", buffer, size);
}

/* pythonfmu's library lets go of the same shared pointer twice when a process on Linux ends, and writes into freed memory:
 * its destructor function runs after the destructor of the pointer.  Nobody needs what it points to once there is an
 * instance, because Python is not started by pythonfmu: the pointer is let go of at once. */
#define LET_GO "finalizePythonInterpreter"

static bool load_pythonfmu(Backend *model, const char *resources)
{
    void *library = open_pythonfmu(model->front, resources);
    bool found = library != NULL;
#define X(name) found = found && library_function(library, "fmi2" #name, &model->name);
    FUNCTIONS(X)
#undef X
    if (library && !found) front_fail(model->front, "the library in %s is not pythonfmu's: extract the whole FMU", resources);
    if (!library || !library_function(library, LET_GO, &model->let_go)) model->let_go = NULL;
    return found;
}

/* Makes the slave; between python_enter and python_leave. */
static void instantiate(Backend *model, const char *guid, const char *resources, bool visible)
{
    Front *front = model->front;
    if (!load_pythonfmu(model, resources)) return;
    model->component = model->Instantiate(front->name, fmi2CoSimulation, guid, resources, &model->callbacks, visible, fmi2True);
    if (model->let_go) model->let_go();
    python_forget_path(resources); /* which pythonfmu put into sys.path, and everything is imported now */
    if (!model->component && !model->explained)
        front_fail(front, "the Python part of this FMU did not start, the message before, if there is one, says why: extract "
                          "the whole FMU, and look at what `psp doctor` says of it");
}

Backend *backend_new(Front *front, const char *guid, const char *resources, bool visible)
{
    char path[2048];
    PythonCall call;
    if (resources) resources = openable(resources, path, sizeof path);
    if (!readable(front, resources) || !python_is_running(front)) return NULL;
    Backend *model = calloc(1, sizeof *model);
    if (!model) return NULL;
    model->front = front;
    model->callbacks.logger = receive_message;
    model->callbacks.allocateMemory = calloc;
    model->callbacks.freeMemory = free;
    model->callbacks.componentEnvironment = model;
    if (!python_functions() || !python_enter(&call, true)) {
        front_fail(front, "the Python in this process has ended, or lacks functions of Python's stable interface: keep it "
                          "running for as long as there are instances, or use the native FMU");
    } else {
        model->generation = python_generation();
        instantiate(model, guid, resources, visible);
        python_leave(&call, !model->component);
    }
    if (model->component) return model;
    free(model);
    return NULL;
}

/* Enters Python; false if it is not the one any more in which the slave was made, of which nothing may be touched. */
static bool enter(Backend *model, PythonCall *call, bool look)
{
    if (model->dead || !python_enter(call, look)) return false;
    if (python_generation() == model->generation) return true;
    python_leave(call, false);
    return false;
}

void backend_free(Backend *model)
{
    PythonCall call;
    if (enter(model, &call, false)) {
        model->FreeInstance(model->component);
        python_leave(&call, false);
    }
    free(model);
}

/* Begins a call into pythonfmu; after a fatal error, and after Python's end, nothing is forwarded any more. */
static bool begin(Backend *model, PythonCall *call, bool look)
{
    if (enter(model, call, look)) return true;
    if (!model->dead)
        front_log(model->front, fmi2Fatal, "Python has ended in this process, and with it this instance: free the "
                                           "instances before Python ends, or use the native FMU");
    model->dead = true;
    return false;
}

/* Ends it: the status of the call. */
static fmi2Status end(Backend *model, PythonCall *call, fmi2Status status)
{
    if (status >= fmi2Fatal || model->front->worst >= fmi2Fatal) {
        model->dead = true;
        status = fmi2Fatal;
    }
    python_leave(call, status > fmi2Warning || model->front->worst > fmi2Warning);
    return status;
}

#define FORWARD(look, action)                                                                                          \
    do {                                                                                                               \
        PythonCall call;                                                                                               \
        return begin(model, &call, look) ? end(model, &call, (action)) : fmi2Fatal;                                    \
    } while (0)

fmi2Status backend_setup(Backend *model, const double *tolerance, double start, const double *stop)
{
    FORWARD(true, model->SetupExperiment(model->component, tolerance != NULL, tolerance ? *tolerance : 0.0, start,
                                         stop != NULL, stop ? *stop : 0.0));
}

fmi2Status backend_enter_initialization(Backend *model) { FORWARD(true, model->EnterInitializationMode(model->component)); }

fmi2Status backend_exit_initialization(Backend *model) { FORWARD(true, model->ExitInitializationMode(model->component)); }

fmi2Status backend_terminate(Backend *model) { FORWARD(false, model->Terminate(model->component)); }

fmi2Status backend_reset(Backend *model) { FORWARD(true, model->Reset(model->component)); }

static fmi2Status do_step(Backend *model, double from, double size)
{
    FORWARD(true, model->DoStep(model->component, from, size, fmi2False));
}

static fmi2Status get_real(Backend *model, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    FORWARD(false, model->GetReal(model->component, vr, count, value));
}

fmi2Status backend_do_step(Backend *model, double from, double size, double *reached)
{
    static const fmi2ValueReference time = TIME_REFERENCE;
    const fmi2Status status = do_step(model, from, size);
    if (status != fmi2Discard) return status;
    if (model->front->worst == fmi2Discard) return get_real(model, &time, 1, reached);
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
        FORWARD(false, model->name(model->component, vr, count, value));                                               \
    }

fmi2Status backend_get_real(Backend *model, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    for (size_t i = 0; i < count; i++) {
        if (vr[i] == TIME_REFERENCE) return no_variable(model, vr[i], "Real");
    }
    return get_real(model, vr, count, value);
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

fmi2Status backend_get_state(Backend *model, void **state) { FORWARD(false, model->GetFMUstate(model->component, state)); }

fmi2Status backend_set_state(Backend *model, void *state) { FORWARD(false, model->SetFMUstate(model->component, state)); }

void backend_free_state(Backend *model, void *state)
{
    PythonCall call;
    if (!enter(model, &call, false)) return;
    model->FreeFMUstate(model->component, &state);
    python_leave(&call, false);
}

fmi2Status backend_state_size(Backend *model, void *state, size_t *size)
{
    FORWARD(false, model->SerializedFMUstateSize(model->component, state, size));
}

fmi2Status backend_write_state(Backend *model, void *state, char *bytes, size_t size)
{
    FORWARD(false, model->SerializeFMUstate(model->component, state, bytes, size));
}

static fmi2Status read_state(Backend *model, const char *bytes, size_t size, void **state)
{
    FORWARD(false, model->DeSerializeFMUstate(model->component, bytes, size, state));
}

fmi2Status backend_read_state(Backend *model, const Progress *progress, const char *bytes, size_t size, void **state)
{
    fmi2Status status = read_state(model, bytes, size, state);
    (void)progress; /* the slave needs none of it to be safe: it raises no exception that it does not catch */
    if (status != fmi2OK) return status;
    status = backend_set_state(model, *state); /* our slaves check what was read, and do not set it */
    if (!model->dead && model->front->worst >= fmi2Error) backend_free_state(model, *state);
    return status;
}

fmi2Status backend_directional_derivative(Backend *model, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)sensitivity;
    return front_fail(model->front, "fmi2GetDirectionalDerivative is not provided by the Python FMU: use the native one");
}
