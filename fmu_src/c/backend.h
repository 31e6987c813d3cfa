/* What the FMI 2.0 front needs of a model.  Each FMU links exactly one backend.
 *
 * The front checks call order, pointers and handles before it calls any of these.  A backend that fails says why with
 * one front_log(front, fmi2Error, ...): the worst status logged during a call is the status of the call, but a warning alone
 * leaves it fmi2OK.
 */
#ifndef PSP_BACKEND_H
#define PSP_BACKEND_H

typedef struct Backend Backend;

/* Passes one sentence to the host's logger, as text. */
void front_log(Front *front, fmi2Status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* vsnprintf for sentences, with a decimal point in every locale: where two numbers that differ would look alike ("35 is
 * above 35"), all are printed with 17 digits instead of 10, as psp_model/errors.py does.  In front_text.c. */
int front_print(char *text, size_t size, const char *format, va_list arguments);

/* The GUID that modelDescription.xml carries, or "" if it is not known; lives as long as the buffer.
 * `resources` may be NULL. */
const char *backend_guid(const char *resources, char *buffer, size_t size);

/* NULL on failure, which has been logged.  `resources` is a plain path, NULL if the host gave none. */
Backend *backend_new(Front *front, const char *guid, const char *resources, bool visible);
void backend_free(Backend *model);

fmi2Status backend_setup(Backend *model, const double *tolerance, double start, const double *stop);
fmi2Status backend_enter_initialization(Backend *model);
fmi2Status backend_exit_initialization(Backend *model);
fmi2Status backend_terminate(Backend *model);
fmi2Status backend_reset(Backend *model);
/* fmi2Discard where the step failed behind an instant at which it could have ended well: the model is there, *reached is
 * that time [s], and a step that ends there succeeds.  fmi2Error where it failed before any. */
fmi2Status backend_do_step(Backend *model, double from, double size, double *reached);

/* Setting: the backend refuses what may not be set after initialisation. */
fmi2Status backend_get_real(Backend *model, const fmi2ValueReference vr[], size_t n, fmi2Real value[]);
fmi2Status backend_get_integer(Backend *model, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]);
fmi2Status backend_get_boolean(Backend *model, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]);
fmi2Status backend_get_string(Backend *model, const fmi2ValueReference vr[], size_t n, fmi2String value[]);
fmi2Status backend_set_real(Backend *model, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]);
fmi2Status backend_set_integer(Backend *model, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]);
fmi2Status backend_set_boolean(Backend *model, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]);
fmi2Status backend_set_string(Backend *model, const fmi2ValueReference vr[], size_t n, const fmi2String value[]);

/* Copies of the whole state of the model. */
fmi2Status backend_get_state(Backend *model, void **state);
fmi2Status backend_set_state(Backend *model, void *state);
void backend_free_state(Backend *model, void *state);
fmi2Status backend_state_size(Backend *model, void *state, size_t *size);
fmi2Status backend_write_state(Backend *model, void *state, char *bytes, size_t size);
/* The front has checked the sum of the bytes, which anybody can compute: every field is to be checked.  `progress` is what
 * the front remembers with them. */
fmi2Status backend_read_state(Backend *model, const Progress *progress, const char *bytes, size_t size, void **state);

fmi2Status backend_directional_derivative(Backend *model, const fmi2ValueReference unknowns[], size_t unknown_count,
                                          const fmi2ValueReference knowns[], size_t known_count,
                                          const fmi2Real seed[], fmi2Real sensitivity[]);

#endif
