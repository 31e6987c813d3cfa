/* Who keeps T from being certified: mirrors psp_model/sampling/lemma1.py and psp_model/sampling/exact.py. */
#include "platoon.h"

#include <math.h>

#include "psp_kernels.h"

static double of_spacing(const Platoon *platoon, int i)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, room = psp_contact_spacing(now->s[i], platoon->cooperation.length[i], L);
    return platoon->certificate == CERTIFICATE_LEMMA1
               ? psp_spacing_period(room, L, platoon->constants.v_max)
               : psp_first_contact(room - L, now->v[i] - now->v[i + 1], now->a[i] - now->a[i + 1]);
}

static double of_speed(const Platoon *platoon, int j)
{
    const Instant *now = &platoon->now;
    return j == 0 && platoon->leader.driven ? INFINITY
                                            : psp_speed_bound(now->v[j], now->a[j], platoon->constants.v_max);
}

static void log_spacing(const Platoon *platoon, Front *front, fmi2Status status, double t, int i)
{
    const double s = platoon->now.s[i], length = platoon->cooperation.length[i], bound = of_spacing(platoon, i);
    const double v_max = platoon->constants.v_max, T = platoon->T;
    if (platoon->certificate == CERTIFICATE_EXACT)
        front_log(front, status, PSP_SENTENCE_exact_spacing, T, bound, t, i + 2, i + 2, s, length, bound);
    else if (length == platoon->constants.L)
        front_log(front, status, PSP_SENTENCE_lemma1_spacing, T, bound, t, i + 2, i + 2, s, length, v_max, bound);
    else front_log(front, status, PSP_SENTENCE_lemma1_length, T, bound, t, i + 2, i + 2, s, length, v_max, bound);
}

static void log_speed(const Platoon *platoon, Front *front, fmi2Status status, double t, int j)
{
    const Instant *now = &platoon->now;
    const bool fast = now->a[j] > 0.0, lemma1 = platoon->certificate == CERTIFICATE_LEMMA1;
    const char *sentence = lemma1 ? (fast ? PSP_SENTENCE_lemma1_fast : PSP_SENTENCE_lemma1_slow)
                                  : (fast ? PSP_SENTENCE_exact_fast : PSP_SENTENCE_exact_slow);
    const double bound = psp_speed_bound(now->v[j], now->a[j], platoon->constants.v_max);
    front_log(front, status, sentence, platoon->T, bound, t, j + 1, j + 1, now->v[j], j + 1, now->a[j],
              fast ? platoon->constants.v_max : 0.0, bound);
}

void platoon_log_violation(const Platoon *platoon, Front *front, fmi2Status status)
{
    const Instant *now = &platoon->now;
    const double t = ((double)now->period + now->fraction) * platoon->T;
    int i = 0, j = 0;
    for (int k = 1; k < now->n - 1; k++) {
        if (of_spacing(platoon, k) < of_spacing(platoon, i)) i = k;
    }
    for (int k = 1; k < now->n; k++) {
        if (of_speed(platoon, k) < of_speed(platoon, j)) j = k;
    }
    if (now->n > 1 && of_spacing(platoon, i) <= of_speed(platoon, j)) /* a lone vehicle has no spacing */
        log_spacing(platoon, front, status, t, i);
    else log_speed(platoon, front, status, t, j);
}
