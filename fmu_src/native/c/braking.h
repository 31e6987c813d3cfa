/* How hard the vehicles ahead may brake from now on without a collision. */
#ifndef PSP_BRAKING_H
#define PSP_BRAKING_H

#include "names.h"

#define BRAKE_MARGIN_MOST 12.0 /* [m/s2] as in psp_model/vehicles/braking.py */

/* Vehicles that keep their accelerations for a dead time and then brake to standstill. */
typedef struct {
    const double *v, *a, *lag, *a_min;
    double dead_time;
} Braking;

/* The largest b so that all of n vehicles that drive themselves, or without any the leader, may brake with b to standstill
 * and those behind do not collide; n - 1 clearances; `automated` is NULL where all are. */
double brake_margin(int n, const double *clearance, const Braking *vehicles, const double *automated);

#endif
