/* The sampling clock: mirrors psp_model/platoon.py and psp_model/sampling/loop.py. */
#include <stddef.h>
#include <string.h>

#include "platoon.h"

#include "psp_kernels.h"

#define SHORTEST 0x1p-60 /* [sampling periods] no period is cut further than this */

static double smaller(double a, double b) { return b < a ? b : a; }

/* With policy 2 a run may leave the model's domain, and the exact period may be met so closely that rounding does; Lemma 1
 * keeps every spacing open otherwise. */
static bool spacings_are_open(const Platoon *platoon, Front *front, fmi2Status status)
{
    const Instant *now = &platoon->now;
    const double L = platoon->constants.L, *length = platoon->cooperation.length;
    int least = 0;
    if ((platoon->policy != POLICY_WARN && platoon->certificate == CERTIFICATE_LEMMA1) || now->n == 1) return true;
    for (int i = 1; i < now->n - 1; i++) {
        if (psp_contact_spacing(now->s[i], length[i], L) < psp_contact_spacing(now->s[least], length[least], L)) least = i;
    }
    if (psp_contact_spacing(now->s[least], length[least], L) > L) return true;
    const double time = ((double)now->period + now->fraction) * platoon->T;
    if (length[least] == L)
        front_log(front, status, PSP_SENTENCE_left_spacing, least + 2, now->s[least], L, time);
    else front_log(front, status, PSP_SENTENCE_left_length, least + 2, now->s[least], length[least], time);
    return false;
}

bool platoon_sample(Platoon *platoon, Front *front, double since, fmi2Status status)
{
    Instant *now = &platoon->now;
    const double T = platoon->T, last_bound = now->bound;
    if (!spacings_are_open(platoon, front, status)) return false;
    if (platoon->papers) {
        now->T_max = feedback(&platoon->constants, &platoon->shape, (int)now->n, now->s, now->v, now->a);
        now->driven = 0;
    } else now->T_max = platoon_decide(platoon, since);
    now->bound = platoon->certificate == CERTIFICATE_LEMMA1 ? now->T_max : platoon_exact(platoon);
    const bool certified = now->bound > T;
    double span = 1.0;
    if (platoon->policy == POLICY_SHORTEN) {
        while (!(span * T < now->bound) && span > SHORTEST) span *= 0.5;
    }
    span = smaller(span, 1.0 - now->fraction); /* the next nominal instant is one in any case */
    const bool begins = !certified && (now->violations == 0 || last_bound > T);
    now->span = span;
    now->violations += !certified;
    if (certified || platoon->policy == POLICY_SHORTEN) return true;
    if (platoon->policy == POLICY_ERROR || begins)
        platoon_log_violation(platoon, front, platoon->policy == POLICY_ERROR ? status : fmi2Warning);
    return platoon->policy != POLICY_ERROR;
}

static bool too_many_short_periods(const Platoon *platoon, Front *front, int64_t short_periods)
{
    const Instant *now = &platoon->now;
    if (short_periods <= platoon->max_short_periods && now->span > SHORTEST) return false;
    const char *sentence =
        platoon->certificate == CERTIFICATE_LEMMA1 ? PSP_SENTENCE_short_periods : PSP_SENTENCE_short_periods_exact;
    front_log(front, fmi2Error, sentence, (int)platoon->max_short_periods,
              ((double)now->period + now->fraction) * platoon->T, now->bound);
    return true;
}

/* From the instant `first` once more to the last one before `now`, which was refused.  That is rare: nothing is copied for it
 * at every instant. */
static void go_back(Platoon *platoon, const Instant *first)
{
    Front nobody = {0}; /* what there was to warn of has been said */
    Instant *now = &platoon->now;
    const int64_t period = now->period;
    const double fraction = now->fraction;
    double since = 0.0;
    for (*now = *first;; platoon_sample(platoon, &nobody, since, fmi2Discard)) {
        const double ends = now->fraction + now->span;
        since = now->span * platoon->T;
        if (ends >= 1.0 ? now->period + 1 == period && fraction == 0.0 : now->period == period && ends == fraction) return;
        pass_time(&platoon->weights, now, since);
        now->period += ends >= 1.0;
        now->fraction = ends >= 1.0 ? 0.0 : ends;
    }
}

fmi2Status platoon_advance(Platoon *platoon, Front *front, int64_t period, double fraction, Instant *scratch)
{
    Instant *now = &platoon->now;
    for (int64_t short_periods = 0;;) {
        const double ends = now->fraction + now->span;
        const int64_t next_period = ends >= 1.0 ? now->period + 1 : now->period;
        const double next_fraction = ends >= 1.0 ? 0.0 : ends;
        if (next_period > period || (next_period == period && next_fraction > fraction)) return fmi2OK;
        if (now->span < 1.0 && ends < 1.0 && too_many_short_periods(platoon, front, ++short_periods))
            return front_failure(front);
        const double since = now->span * platoon->T;
        pass_time(&platoon->weights, now, since);
        now->period = next_period;
        now->fraction = next_fraction;
        if (!platoon_sample(platoon, front, since, fmi2Error)) {
            if (front->partly) go_back(platoon, scratch);
            return front_failure(front);
        }
        if (!front->partly && (period > now->period || fraction > now->fraction)) *scratch = *now; /* others may follow */
        front->partly = true;
    }
}

const Instant *platoon_observe(const Platoon *platoon, int64_t period, double fraction, Instant *scratch)
{
    const Instant *now = &platoon->now;
    const double tau = ((double)(period - now->period) + (fraction - now->fraction)) * platoon->T;
    if (tau == 0.0) return now;
    memcpy(scratch, now, offsetof(Instant, closing));
    pass_time(&platoon->weights, scratch, tau);
    return scratch;
}
