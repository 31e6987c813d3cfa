/* What the controller FMU holds beside its variables. */
#ifndef PSP_CONTROLLER_MODEL_H
#define PSP_CONTROLLER_MODEL_H

#include "controller.h"

typedef struct {
    Settings settings;
    double set_at;       /* [sampling periods] since the first sampling instant, when inputs were last set */
    int64_t sampled;     /* sampling instants that lie in the past */
    bool fresh;          /* inputs were set at this communication point */
    bool foreseen;       /* the command that is not held is the decision at the instant that the communication point is */
    int32_t held;        /* which command is */
    Command commands[2]; /* the other one may yet fail, and is nothing unless foreseen */
    Actuators issued;    /* by the commands held so far, `oldest` before the next sampling instant */
} Part;

typedef Work Scratch;

#define PART_ACTUATORS issued
#define PART_LATE PSP_T_exact, PSP_brake_margin /* take long, and are computed where they are read */

#endif
