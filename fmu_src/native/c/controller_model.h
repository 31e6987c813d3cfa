/* What the controller FMU holds beside its variables. */
#ifndef PSP_CONTROLLER_MODEL_H
#define PSP_CONTROLLER_MODEL_H

#include "controller.h"

typedef struct {
    Settings settings;
    double set_at;   /* [sampling periods] since the first sampling instant, when inputs were last set */
    int64_t sampled; /* sampling instants that lie in the past */
    bool fresh;      /* inputs were set at this communication point */
    bool foreseen;   /* `ahead` is the decision at the instant that the communication point is */
    Command now, ahead;
} Part;

typedef Decision Scratch; /* it may yet fail */

#endif
