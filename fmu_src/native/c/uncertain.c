/* Lemma 1 and the exact period for what is known within bounds: mirrors psp_model/sampling/uncertain.py. */
#include "uncertain.h"

#include <math.h>

#include "psp_kernels.h"

/* Accelerations between which one lies. */
typedef struct {
    double most, least;
} Span;

static inline double smaller(double a, double b) { return b < a ? b : a; }

Errors errors_carried(const Errors *errors, double horizon)
{
    const Errors later = {errors->error_s + 2.0 * horizon * errors->error_v, errors->error_v};
    return later;
}

static inline Span span_of(const double *a, const double *before, int i)
{
    const double now = a[i], was = before ? before[i] : now;
    const Span found = {now > was ? now : was, now < was ? now : was};
    return found;
}

static double of_speeds(const Constants *constants, const Errors *errors, int n, const double *v, const double *a,
                        const double *before)
{
    double least = INFINITY;
    for (int i = 0; i < n; i++) {
        const Span span = span_of(a, before, i);
        least = smaller(least, psp_speeds_bound(v[i], span.most, span.least, errors->error_v, constants->v_max));
    }
    return least;
}

double uncertain_period(const Constants *constants, const Errors *errors, int n, const double *s, const double *v,
                        const double *a, const double *before)
{
    double least = of_speeds(constants, errors, n, v, a, before);
    for (int i = 0; i < n - 1; i++)
        least = smaller(least, psp_spacing_bound(s[i], errors->error_s, constants->L, constants->v_max));
    return least;
}

double uncertain_exact_period(const Constants *constants, const Errors *errors, int n, const double *s, const double *v,
                              const double *a, const double *before, const double *foreign)
{
    double least = of_speeds(constants, errors, n, v, a, before);
    for (int i = 0; i < n - 1; i++) {
        const double ahead = span_of(a, before, i).least + (foreign ? foreign[i] : 0.0);
        const double behind = span_of(a, before, i + 1).most + (foreign ? foreign[i + 1] : 0.0);
        least = smaller(least, psp_contact_bound(s[i], v[i] - v[i + 1], ahead - behind, errors->error_s, errors->error_v,
                                                 constants->L));
    }
    return least;
}
