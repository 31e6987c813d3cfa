/* How long a sampling period may be: mirrors psp_model/sampling/period.py and psp_model/sampling/exact.py. */
#include "certificate.h"

#include <math.h>

#include "psp_kernels.h"

static double smaller(double a, double b) { return b < a ? b : a; }

static inline double room(const Constants *constants, const Cooperation *cooperation, int i, double s)
{
    return cooperation ? psp_contact_spacing(s, cooperation->length[i], constants->L) : s;
}

static double of_speeds(const Constants *constants, bool driven, int n, const double *v, const double *a)
{
    double least = INFINITY;
    for (int i = driven; i < n; i++) least = smaller(least, psp_speed_bound(v[i], a[i], constants->v_max));
    return least;
}

double lemma1_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                     const double *v, const double *a)
{
    double least = of_speeds(constants, driven, n, v, a);
    for (int i = 0; i < n - 1; i++)
        least = smaller(least, psp_gap_bound(room(constants, cooperation, i, s[i]), constants->L, constants->v_max));
    return least;
}

/* What T_exact is the least of: how long a gap lasts (its length ahead NULL for L), how long a speed does. */
static inline double contact_at(const Constants *constants, const Cooperation *cooperation, int i, const double *s,
                                const double *v, const double *a)
{
    return psp_first_contact(room(constants, cooperation, i, s[i]) - constants->L, v[i] - v[i + 1], a[i] - a[i + 1]);
}

static double bound_at(const Constants *constants, const Cooperation *cooperation, int n, int k, const double *s,
                       const double *v, const double *a)
{
    if (k < n - 1) return contact_at(constants, cooperation, k, s, v, a);
    return psp_speed_bound(v[k - n + 1], a[k - n + 1], constants->v_max);
}

/* How many of these bounds may be at or below a time: a product says so at less than the cost of root and quotient.  What
 * closes a gap by then is at least the speed and the acceleration that close it, without those that open it. */
static inline int count_below(const Constants *constants, const Cooperation *cooperation, bool driven, int n,
                              const double *restrict s, const double *restrict v, const double *restrict a, double time)
{
    const double beyond = time * (1.0 + 1e-9), half = 0.5 * beyond, v_max = constants->v_max;
    int count = 0;
    for (int i = driven; i < n; i++) count += !((a[i] > 0.0 ? v_max - v[i] : v[i]) > beyond * fabs(a[i]));
    for (int i = 0; i < n - 1; i++) {
        const double left = room(constants, cooperation, i, s[i]) - constants->L;
        const double b = v[i] - v[i + 1], c = a[i] - a[i + 1];
        const double closed = beyond * ((b < 0.0 ? b : 0.0) + half * (c < 0.0 ? c : 0.0));
        count += !(left + closed > 1e-9 * left);
    }
    return count;
}

static inline double exact_of(const Constants *constants, const Cooperation *cooperation, bool driven, int n,
                              const double *s, const double *v, const double *a, int *tightest)
{
    if (*tightest < 0 || *tightest >= 2 * n - 1 || (driven && *tightest == n - 1)) *tightest = 0;
    const double guess = n > 1 ? bound_at(constants, cooperation, n, *tightest, s, v, a) : INFINITY;
    if (guess < LONGEST && count_below(constants, cooperation, driven, n, s, v, a, guess) <= 1) return guess;
    double least = INFINITY;
    for (int k = 0; k < 2 * n - 1; k++) {
        if (driven && k == n - 1) continue;
        const double bound = bound_at(constants, cooperation, n, k, s, v, a);
        if (bound < least) *tightest = k;
        least = smaller(least, bound);
    }
    return least;
}

double exact_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                    const double *v, const double *a, int *tightest)
{
    if (n == PSP_N && !cooperation && !driven)
        return exact_of(constants, NULL, false, PSP_N, s, v, a, tightest);
    return exact_of(constants, cooperation, driven, n, s, v, a, tightest);
}
