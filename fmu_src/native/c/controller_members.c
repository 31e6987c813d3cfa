/* Which vehicle is which, after one has joined or left: mirrors psp_model/controller/members.py and
 * psp_model/vehicles/membership.py. */
#include "controller.h"

#include <stddef.h>

static double square(double x) { return x * x; }

/* The sum of squares of values[k + 1] - others[k] from each k on, of `count` others. */
static void sums_behind(int count, const double *values, const double *others, double *sums)
{
    sums[count] = 0.0;
    for (int k = count - 1; k >= 0; k--) sums[k] = sums[k + 1] + square(values[k + 1] - others[k]);
}

/* The place of the vehicle, of m + 1 with m spacings, without which the others are those of another platoon, as nearly as can
 * be; of equals the last. */
static int odd_one_out(int m, const double *s, const double *v, const double *others_s, const double *others_v, Work *work)
{
    double ahead_s = 0.0, ahead_v = 0.0, least = 0.0;
    int found = 0;
    sums_behind(m - 1, s, others_s, work->behind_s);
    sums_behind(m, v, others_v, work->behind_v);
    for (int j = 0; j <= m; j++) {
        double of_spacings = j == 0 ? work->behind_s[0] : ahead_s;
        if (0 < j && j < m) of_spacings = ahead_s + square(s[j - 1] + s[j] - others_s[j - 1]) + work->behind_s[j];
        const double sum = of_spacings + (ahead_v + work->behind_v[j]);
        if (j == 0 || sum <= least) {
            least = sum;
            found = j;
        }
        if (0 < j && j < m) ahead_s += square(s[j - 1] - others_s[j - 1]);
        if (j < m) ahead_v += square(v[j] - others_v[j]);
    }
    return found;
}

void find_members(const Command *before, const Basis *now, int n, Work *work)
{
    const int rows = (int)before->remembered, change = n - rows;
    const bool known = now && before->n == before->remembered;
    const Basis *was = &before->basis;
    int odd = change < 0 ? n : rows; /* those at the end have left, or have joined */
    if (known && change == -1) odd = odd_one_out(rows - 1, was->s, was->v, now->s, now->v, work);
    if (known && change == 1) odd = odd_one_out(n - 1, now->s, now->v, was->s, was->v, work);
    for (int i = 0; i < n; i++) {
        if (i < odd) work->places[i] = i;
        else if (change < 0) work->places[i] = i + 1;
        else work->places[i] = i == odd || change != 1 ? -1 : i - 1;
    }
}

void give_commands(const Settings *settings, Actuators *issued, const Command *before, const Command *now, Work *work)
{
    const int n = (int)now->remembered;
    if (!settings->predicts) return;
    if (before->remembered > 0 && before->remembered != n) {
        find_members(before, now->in_order ? &now->basis : NULL, n, work);
        actuators_rearrange(issued, n, work->places);
    }
    issue(issued, &settings->actuation, settings->oldest, n, now->a, settings->T);
}
