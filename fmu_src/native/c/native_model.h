/* What an instance of any native FMU holds: variables by value reference, and the part of the component. */
#ifndef PSP_NATIVE_MODEL_H
#define PSP_NATIVE_MODEL_H

#include "clock.h"
#include "front.h"
#include "psp_model.h" /* generated: the table of variables, sentences, and PSP_COMPONENT, the component's header */

#include PSP_COMPONENT /* Part: the component's share of the state; Scratch: what it computes in.  PART_ACTUATORS: the name
                        * of the last member, if that has a queue of commands, of which saved states hold what is in use. */

/* The whole state of an instance; a saved state is a copy of it, up to the rows of a queue that are not in use. */
typedef struct {
    double values[PSP_COUNT]; /* by value reference: parameters and inputs as set, outputs as last computed */
    Clock clock;              /* before initialisation it stands at the start */
    int32_t initialising;
    int32_t ready; /* the part is what the parameters describe */
    int32_t stale; /* the outputs in values lag behind the part */
    int32_t unused;
    Part part;
} Model;

struct Backend {
    Front *front;
    Model model;
    Scratch scratch; /* not part of the state */
};

#ifdef PART_ACTUATORS
#define PART_SIZE offsetof(Part, PART_ACTUATORS.queue)
#define PART_ROWS(part) ((part)->PART_ACTUATORS.rows)
#define PART_QUEUE(part) actuators_ring(&(part)->PART_ACTUATORS)
#define PART_MOST_ROWS PSP_QUEUE
#else
#define PART_SIZE sizeof(Part)
#define PART_ROWS(part) ((void)(part), 0)
#define PART_QUEUE(part) ((void)(part), (size_t)0)
#define PART_MOST_ROWS 0
#endif

extern const char *const PSP_VARIABLE_NAMES[PSP_COUNT];

/* native_values.c: the start values of parameters and inputs. */
void native_start_values(double *values);

/* What a component provides, beside backend_do_step and backend_directional_derivative; false on failure, which has been
 * logged. */

/* Makes the part that the parameters describe. */
bool part_initialise(Backend *backend);

/* Takes notice of values that were set. */
void part_changed(Backend *backend);

/* Writes all outputs, in the order of their references; the part is ready. */
bool part_put_out(Backend *backend, double *outputs);

#ifdef PART_LATE
/* One of the outputs PART_LATE, which part_put_out leaves alone because they are computed only where they are read. */
bool part_put_late(Backend *backend, fmi2ValueReference reference, double *output);
#endif

/* Whether a model that bytes were read into, which is ready, can be; the front remembers `progress` with it. */
bool part_restore(Model *model, const Progress *progress);

/* native_state.c: how many bytes of a model count; no others are touched but those of the queue.  For part_restore: whether a byte is a bool; a number is whole, not below `least` and not above what can
 * be counted; a shape is one that can have been chosen. */
size_t native_size(const Model *model);
bool state_is_flag(const bool *flag);
bool state_is_count(double value, double least);
bool state_is_shape(const Shape *shape, const Constants *constants, bool old);

/* native_instance.c: makes the part ready unless it is; false on failure, which has been logged. */
bool native_make_ready(Backend *backend);

static inline bool native_is_integer(fmi2ValueReference reference)
{
#if PSP_INTEGER_COUNT
    return reference - PSP_FIRST_INTEGER < PSP_INTEGER_COUNT;
#else
    return (void)reference, false;
#endif
}

#endif
