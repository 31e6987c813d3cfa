/* A vehicle with a first-order lag under one command: mirrors psp_model/vehicles/ride.py. */
#include "ride.h"

#include <math.h>
#include <stdbool.h>

#include "psp_kernels.h"

enum { NEWTON_STEPS = 30 };

double first_stop(double v, double a, double command, double lag, double low)
{
    double t = a < command ? 0.0 : low, before = -1.0;
    for (int left = NEWTON_STEPS; left > 0; left--) {
        const double nearer = lag > 0.0 ? psp_nearer_stop(v, a, command, lag, t, low)
                                        : psp_nearer_stop_at_once(v, command, t, low);
        if (nearer == before) return left % 2 ? nearer : t; /* between two numbers, and so it would go on */
        if (nearer == t) break;                             /* and so it would stay */
        before = t;
        t = nearer;
    }
    return t;
}

/* A vehicle that may reverse; without a lag a is the command. */
static inline void uninterrupted(double v, double a, double command, double lag, double span, double *speed, double *moved)
{
    if (lag > 0.0) psp_uninterrupted(v, a, command, lag, span, speed, moved);
    else psp_unstopped_at_once(v, command, span, speed, moved);
}

void ride_with_stop(double v, double a, double command, double lag, double span, double *then, double *moved)
{
    const bool again = a < 0.0 && command > 0.0;
    const double turn = again ? psp_turning(a, command, lag) : 0.0;
    const double low = again ? fmin(turn, span) : span;
    double speed, until, further;
    uninterrupted(v, a, command, lag, low, &speed, &until);
    if (!(speed < 0.0)) {
        *then = fmax(*then, 0.0);
        return;
    }
    uninterrupted(v, a, command, lag, first_stop(v, a, command, lag, low), &speed, &until);
    uninterrupted(0.0, 0.0, command, lag, again ? fmax(span - turn, 0.0) : 0.0, &speed, &further);
    *then = fmax(speed, 0.0);
    *moved = until + further;
}

void ride_steadily(double v, double a, double span, double *speed, double *moved)
{
    psp_unstopped_at_once(v, a, span, speed, moved);
    if (v + span * fmin(a, 0.0) < 0.0) ride_with_stop(v, a, a, 0.0, span, speed, moved);
}
