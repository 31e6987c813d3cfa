/* V'(s), with a power only on the hill. */
#ifndef PSP_SLOPE_H
#define PSP_SLOPE_H

#include <math.h>

#include "psp_kernels.h"
#include "vehicles.h"

static inline double slope_at(const Constants *c, const Shape *h, double s)
{
    return h->hill != 0.0 && psp_on_hill(s, h->r) != 0.0 ? psp_slope(s, h->alpha, h->r, h->p, h->hill, c->L, c->lam)
                                                         : psp_slope_off_hill(s, h->alpha, c->L, c->lam);
}

#endif
