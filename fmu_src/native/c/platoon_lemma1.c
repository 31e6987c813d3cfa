/* Who keeps T from being certified: mirrors psp_model/sampling/lemma1.py. */
#include "platoon.h"

#include <math.h>

#include "psp_kernels.h"

void platoon_log_violation(const Platoon *platoon, Front *front, fmi2Status status)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, v_max = platoon->constants.v_max, T = platoon->T;
    const double t = ((double)now->period + now->fraction) * T;
    int i = 0, j = 0;
    for (int k = 1; k < now->n - 1; k++) {
        if (psp_gap_bound(now->s[k], L, v_max) < psp_gap_bound(now->s[i], L, v_max)) i = k;
    }
    for (int k = 1; k < now->n; k++) {
        if (psp_speed_bound(now->v[k], now->a[k], v_max) < psp_speed_bound(now->v[j], now->a[j], v_max)) j = k;
    }
    const double of_gap = now->n > 1 ? psp_gap_bound(now->s[i], L, v_max) : INFINITY; /* a lone vehicle has no gap */
    const double of_speed = psp_speed_bound(now->v[j], now->a[j], v_max);
    if (of_gap <= of_speed)
        front_log(front, status, PSP_SENTENCE_lemma1_gap, T, of_gap, t, i + 2, i + 2, now->s[i], L, v_max, of_gap);
    else if (now->a[j] > 0.0)
        front_log(front, status, PSP_SENTENCE_lemma1_fast, T, of_speed, t, j + 1, j + 1, now->v[j], j + 1, now->a[j],
                  v_max, of_speed);
    else
        front_log(front, status, PSP_SENTENCE_lemma1_slow, T, of_speed, t, j + 1, j + 1, now->v[j], j + 1, now->a[j], 0.0,
                  of_speed);
}
