/* A vehicle with a first-order lag under one command; mirrors psp_model/vehicles/ride.py. */
#ifndef PSP_RIDE_H
#define PSP_RIDE_H

#include "names.h"

/* Speed and distance after a time where the vehicle may come to a stop on the way, and may drive off again; what they are
 * where it does not is in them before.  a is the acceleration felt first. */
void ride_with_stop(double v, double a, double command, double lag, double span, double *then, double *moved);

/* A vehicle that keeps an acceleration, down to standstill. */
void ride_steadily(double v, double a, double span, double *speed, double *moved);

/* When the speed falls to 0, which it has at `low`. */
double first_stop(double v, double a, double command, double lag, double low);

#endif
