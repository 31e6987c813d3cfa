/* Lemma 1 and the exact period for what is known within bounds. */
#ifndef PSP_UNCERTAIN_H
#define PSP_UNCERTAIN_H

#include "vehicles.h"

typedef struct {
    double error_s, error_v; /* [m], [m/s] */
} Errors;

/* The bounds a time later, where all accelerations are known. */
Errors errors_carried(const Errors *errors, double horizon);

/* T_max and T_exact for n vehicles with accelerations about to be held; `before`: those of the actuators until then, NULL
 * where they act at once; `foreign`: those of vehicles that drive themselves, 0 for the others, NULL for 0. */
double uncertain_period(const Constants *constants, const Errors *errors, int n, const double *s, const double *v,
                        const double *a, const double *before);
double uncertain_exact_period(const Constants *constants, const Errors *errors, int n, const double *s, const double *v,
                              const double *a, const double *before, const double *foreign);

#endif
