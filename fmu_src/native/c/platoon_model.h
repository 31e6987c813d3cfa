/* What the FMU of the closed loop holds beside its variables. */
#ifndef PSP_PLATOON_MODEL_H
#define PSP_PLATOON_MODEL_H

#include "platoon.h"

/* The outputs on joining and leaving, in the order of the table; vehicles are numbers, leader first, then zeros. */
typedef struct {
    double n_active, vehicles[PSP_N], change_ok, gap_offered, changes, refusals;
} Told;

typedef struct {
    Told told;
    double insert, remove; /* the triggers when the last step began */
    int64_t joined;        /* vehicles there have been */
} Members;

typedef struct {
    double in_domain;
    int64_t period; /* the communication point as whole sampling periods and a fraction */
    double fraction;
    Members members;
    Platoon platoon;
} Part;

#define PART_LATE PSP_T_exact /* takes long, and matters to nobody who does not read it or goes by it */

typedef Instant Scratch; /* outputs between two sampling instants: no room on a stack for many vehicles */

/* platoon_membership.c: the members at the start, and whether they lie in the network's domain, with their spacings of which
 * the lengths ahead are taken for L; the changes whose triggers have risen, at the communication point: false on failure,
 * which has been logged; a refusal is none. */
void part_begin(Part *part, int n, const double *room);
bool part_make_changes(Part *part, Front *front, const double *values);

#endif
