/* How long a sampling period may be: mirrors psp_model/sampling/period.py and psp_model/sampling/exact.py. */
#include "certificate.h"

#include <math.h>

#include "psp_kernels.h"
#include "speeds.h"

static inline double room(const Constants *constants, const Cooperation *cooperation, int i, double s)
{
    return cooperation ? psp_contact_spacing(s, cooperation->length[i], constants->L) : s;
}

double lemma1_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                     const double *v, const double *a)
{
    double least = INFINITY; /* the smallest spacing sets the least of the spacings' bounds */
    for (int i = 0; i < n - 1; i++) least = smaller(least, room(constants, cooperation, i, s[i]));
    return with_speeds(psp_spacing_period(least, constants->L, constants->v_max), constants->v_max, driven, n, v, a);
}

/* Most spacings do not set it: what closes one by then is at most the speed and the acceleration that close it, without those
 * that open it, and that is computed without root and quotient. */
static inline double exact_of(const Constants *constants, const Cooperation *cooperation, bool driven, int n,
                              const double *s, const double *v, const double *a)
{
    double period = with_speeds(INFINITY, constants->v_max, driven, n, v, a);
    for (int i = 0; i < n - 1; i++) {
        const double left = room(constants, cooperation, i, s[i]) - constants->L, b = v[i] - v[i + 1], c = a[i] - a[i + 1];
        const double beyond = BEYOND * period;
        if (left + beyond * ((b < 0.0 ? b : 0.0) + 0.5 * beyond * (c < 0.0 ? c : 0.0)) > 0.0) continue;
        period = smaller(period, psp_first_contact(left, b, c));
    }
    return period;
}

double exact_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                    const double *v, const double *a)
{
    return n == PSP_N && !cooperation && !driven ? exact_of(constants, NULL, false, PSP_N, s, v, a)
                                                 : exact_of(constants, cooperation, driven, n, s, v, a);
}
