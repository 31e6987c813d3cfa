/* The bounds that speeds set to a sampling period. */
#ifndef PSP_SPEEDS_H
#define PSP_SPEEDS_H

#include <math.h>

#include "psp_kernels.h"

#define BEYOND (1.0 + 1e-9) /* far more than rounding makes of a bound */

static inline double smaller(double a, double b) { return b < a ? b : a; }

/* The less of a period and of how long the speeds of vehicles `first` to n - 1 stay inside their bounds.  Few of them set it:
 * a product says so at less than the cost of a quotient, and with the same result. */
static inline double with_speeds(double period, double v_max, int first, int n, const double *v, const double *a)
{
    for (int i = first; i < n; i++) {
        const double room = a[i] > 0.0 ? v_max - v[i] : v[i];
        if (room > BEYOND * period * fabs(a[i])) continue;
        period = smaller(period, psp_speed_bound(v[i], a[i], v_max));
    }
    return period;
}

#endif
