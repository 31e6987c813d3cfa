/* The FMI 2.0 front that all FMUs share: call order, argument checks, logging, saved states.
 *
 * The model behind it is a backend (backend.h).  All data of an instance is in its Front; what is static in
 * python_host.c belongs to the process.
 */
#ifndef PSP_FRONT_H
#define PSP_FRONT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "names.h" /* before all names that it changes */

#include "busy.h"
#include "fmi2Functions.h"

typedef struct Front Front;

/* The states of FMI 2.0's state machine of co-simulation that a slave without asynchronous steps can be in. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    STEP_FAILED = 8,
    TERMINATED = 16,
    IN_ERROR = 32,
    IN_FATAL = 64
} Mode;

/* What the front itself must remember in a saved state, beside the backend's part. */
typedef struct {
    double time;         /* the current communication point [s] */
    double stop;         /* [s], if has_stop */
    double last_success; /* [s] where the last step ended, or how far it got */
    double start;        /* [s] */
    double elapsed;      /* sum of the steps [s] */
    uint64_t steps;
    uint32_t mode;
    uint32_t has_stop;
    uint32_t last_step;
    uint32_t setup; /* fmi2SetupExperiment was called */
} Progress;

#include "backend.h"

typedef struct SavedState {
    struct SavedState *next;
    Progress progress;
    void *backend;
} SavedState;

struct Front {
    uint64_t magic;
    char *name;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    bool logging;
    unsigned categories; /* bit per log category asked for */
    uint64_t identity;   /* hash of the GUID, so that states of other builds are refused */
    Progress progress;
    fmi2Status worst; /* worst status logged during the current call */
    bool partly;      /* a step has got somewhere: an error from here on is fmi2Discard, as a shorter step would succeed */
    Busy busy;        /* a call is running (1), and another one is being refused (2); see front_enter */
    SavedState *states;
    Backend *backend;
};

/* front_check.c ---------------------------------------------------------------------------------------------- */

typedef enum {
    CALL_SET_DEBUG_LOGGING,
    CALL_FREE_INSTANCE,
    CALL_SETUP_EXPERIMENT,
    CALL_ENTER_INITIALIZATION,
    CALL_EXIT_INITIALIZATION,
    CALL_TERMINATE,
    CALL_RESET,
    CALL_GET_REAL,
    CALL_GET_INTEGER,
    CALL_GET_BOOLEAN,
    CALL_GET_STRING,
    CALL_SET_REAL,
    CALL_SET_INTEGER,
    CALL_SET_BOOLEAN,
    CALL_SET_STRING,
    CALL_GET_STATE,
    CALL_SET_STATE,
    CALL_FREE_STATE,
    CALL_STATE_SIZE,
    CALL_SERIALIZE_STATE,
    CALL_DESERIALIZE_STATE,
    CALL_DIRECTIONAL_DERIVATIVE,
    CALL_SET_INPUT_DERIVATIVES,
    CALL_GET_OUTPUT_DERIVATIVES,
    CALL_DO_STEP,
    CALL_CANCEL_STEP,
    CALL_GET_STATUS,
    CALL_GET_REAL_STATUS,
    CALL_GET_INTEGER_STATUS,
    CALL_GET_BOOLEAN_STATUS,
    CALL_GET_STRING_STATUS
} Call;

/* The instance behind `c` if `call` is allowed now, else NULL with the status to return in *refusal. */
Front *front_enter(fmi2Component c, Call call, fmi2Status *refusal);

/* The status of a call: the worse of `status` and of what was logged, a mere warning aside, which ends a run in several
 * hosts.  It also decides the state the instance is in. */
fmi2Status front_judge(Front *front, fmi2Status status);

/* What a step that fails now gives. */
fmi2Status front_failure(const Front *front);

/* Ends a call with that status; nothing of the instance may be touched behind it. */
fmi2Status front_leave(Front *front, fmi2Status status);

/* True if `count` is 0 or all of the pointers are there; else logs which function lacks an argument. */
bool front_has(Front *front, Call call, size_t count, const void *first, const void *second);

/* Logs fmi2Error and returns it, or fmi2Discard: see front_failure. */
fmi2Status front_fail(Front *front, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

const char *front_call_name(Call call);

/* front_log.c ------------------------------------------------------------------------------------------------ */

enum { LOG_ALL = 1u }; /* the category that holds all others */

/* Replaces the log categories asked for: all if `count` is 0.  Unknown ones are warned of. */
void front_choose_categories(Front *front, bool logging, size_t count, const fmi2String names[]);

void front_log_list(Front *front, fmi2Status status, const char *format, va_list arguments);

/* front_text.c ----------------------------------------------------------------------------------------------- */

bool text_is_utf8(const char *text);

/* A copy that a logger can show: '?' for what is no UTF-8 and for control characters; `clean` has room for as many bytes
 * as the text, twice as many if it is to be a format, in which each percent sign is doubled. */
void text_for_logger(const char *text, bool is_format, char *clean);

typedef struct {
    char text[256];
} Excerpt;

/* Beginning and end of a text that is too long for a sentence; the text itself if it is not. */
const char *text_excerpt(const char *text, Excerpt *excerpt);

/* resource_path.c -------------------------------------------------------------------------------------------- */

/* The path that a file URI (or a plain path) stands for, percent-decoded, without a slash at the end; freed by the
 * caller; NULL when there is no memory for it. */
char *resource_path(const char *uri);

/* front_state.c ---------------------------------------------------------------------------------------------- */

/* Frees all states that were saved and not freed. */
void front_free_states(Front *front);

/* Says that the bytes of a state hold what cannot be; fmi2Error. */
fmi2Status front_refuse_state(Front *front);

/* FNV-1a, 64 bits. */
uint64_t front_hash(const void *bytes, size_t size);

#endif
