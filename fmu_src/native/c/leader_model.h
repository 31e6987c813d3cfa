/* What the leader FMU holds beside its variables. */
#ifndef PSP_LEADER_MODEL_H
#define PSP_LEADER_MODEL_H

#include "vehicles.h"

/* As the parameters say; a profile has no speeds and no period of its own, its rows are in psp_profile.h. */
typedef struct {
    double T, high, low, begin, period;
} Part;

typedef int32_t Scratch; /* nothing */

#endif
