/* What the FMU of the closed loop holds beside its variables. */
#ifndef PSP_PLATOON_MODEL_H
#define PSP_PLATOON_MODEL_H

#include "platoon.h"

typedef struct {
    double in_domain;
    int64_t period; /* the communication point as whole sampling periods and a fraction */
    double fraction;
    Platoon platoon;
} Part;

typedef Instant Scratch; /* outputs between two sampling instants: no room on a stack for many vehicles */

#endif
