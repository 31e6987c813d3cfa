/* How long a sampling period may be: mirrors psp_model/sampling/period.py and psp_model/sampling/exact.py. */
#include "certificate.h"

#include <math.h>

#include "psp_kernels.h"

static double smaller(double a, double b) { return b < a ? b : a; }

static inline double room(const Constants *constants, const Cooperation *cooperation, int i, double s)
{
    return cooperation ? psp_contact_spacing(s, cooperation->length[i], constants->L) : s;
}

double speed_period(const Constants *constants, bool driven, int n, const double *v, const double *a)
{
    double least = INFINITY;
    for (int i = driven; i < n; i++) least = smaller(least, psp_speed_bound(v[i], a[i], constants->v_max));
    return least;
}

double lemma1_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                     const double *v, const double *a)
{
    double least = speed_period(constants, driven, n, v, a);
    for (int i = 0; i < n - 1; i++)
        least = smaller(least, psp_gap_bound(room(constants, cooperation, i, s[i]), constants->L, constants->v_max));
    return least;
}

static inline double contact_of(const Constants *constants, const Cooperation *cooperation, int n, const double *restrict s,
                                const double *restrict v, const double *restrict a)
{
    double least = INFINITY;
    for (int i = 0; i < n - 1; i++) {
        const double left = room(constants, cooperation, i, s[i]) - constants->L;
        least = smaller(least, psp_first_contact(left, v[i] - v[i + 1], a[i] - a[i + 1]));
    }
    return least;
}

double contact_period(const Constants *constants, const Cooperation *cooperation, int n, const double *s, const double *v,
                      const double *a)
{
    return n == PSP_N && !cooperation ? contact_of(constants, NULL, PSP_N, s, v, a)
                                      : contact_of(constants, cooperation, n, s, v, a);
}
