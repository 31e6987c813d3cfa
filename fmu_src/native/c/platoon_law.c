/* The law of the closed loop where it is not the paper's: mirrors psp_model/law/extended.py, and of
 * fmu_src/interface/meaning.py what belongs to it. */
#include <math.h>
#include <stdio.h>

#include "platoon.h"

#include "psp_kernels.h"

static bool not_negative(Front *front, const char *name, double value, const char *unit)
{
    REQUIRE(value >= 0.0, PSP_SENTENCE_not_negative, name, value, unit, unit);
    return true;
}

static bool read_lengths(Front *front, const double *values, int n, double L, double *length)
{
    char name[32];
    for (int i = 0; i < PSP_N; i++) {
        const double given = values[PSP_length + i];
        length[i] = i >= n || given == 0.0 ? L : given;
        snprintf(name, sizeof name, "length[%d]", i + 1);
        if (!finite_or_log(front, name, length[i], "m")) return false;
        REQUIRE(length[i] > 0.0, PSP_SENTENCE_length, i + 1, length[i], i + 1);
    }
    return true;
}

bool read_cooperation(Front *front, const double *values, const Constants *constants, int n, Cooperation *taken)
{
    papers_law(taken, constants);
    taken->kappa = values[PSP_kappa];
    taken->kappa_reach = values[PSP_kappa_reach];
    taken->closing_speed = values[PSP_closing_speed];
    taken->closing_spacing = values[PSP_closing_spacing];
    taken->closing_reach = values[PSP_closing_reach];
    if (!finite_or_log(front, "kappa", taken->kappa, "1/s") || !finite_or_log(front, "kappa_reach", taken->kappa_reach, "m") ||
        !finite_or_log(front, "closing_speed", taken->closing_speed, "m/s") ||
        !finite_or_log(front, "closing_spacing", taken->closing_spacing, "m") ||
        !finite_or_log(front, "closing_reach", taken->closing_reach, "m") ||
        !not_negative(front, "kappa", taken->kappa, "1/s") ||
        !not_negative(front, "closing_speed", taken->closing_speed, "m/s"))
        return false;
    REQUIRE(taken->closing_reach > taken->closing_spacing, PSP_SENTENCE_reach, "closing_reach", taken->closing_reach,
            "closing_spacing", taken->closing_spacing);
    if (!read_lengths(front, values, n, constants->L, taken->length)) return false;
    REQUIRE(taken->kappa == 0.0 || taken->kappa_reach > constants->L, PSP_SENTENCE_reach, "kappa_reach",
            taken->kappa_reach, "L", constants->L);
    return true;
}

bool read_leader(Front *front, const double *values, double v_max, Leader *leader)
{
    const double automated = values[PSP_leader_automated], speed = values[PSP_leader_speed];
    *leader = (Leader){0};
    if (!finite_or_log(front, "leader_automated", automated, "1")) return false;
    if (automated >= 0.5) return true;
    *leader = (Leader){1, speed, values[PSP_leader_acceleration]};
    if (!finite_or_log(front, "leader_speed", speed, "m/s") ||
        !finite_or_log(front, "leader_acceleration", leader->acceleration, "m/s2"))
        return false;
    REQUIRE(0.0 <= speed && speed <= v_max, PSP_SENTENCE_leader_speed, speed, v_max);
    return true;
}

void platoon_settle(Platoon *platoon)
{
    const Cooperation *law = &platoon->cooperation;
    platoon->papers = !platoon->leader.driven && law->kappa == 0.0 && law->closing_speed == 0.0 &&
                      spacings_are_model_spacings(&platoon->constants, law, (int)platoon->now.n);
}

/* What closing up adds to the desired speeds, a time later. */
static void engage(Platoon *platoon, double since)
{
    Instant *now = &platoon->now;
    const double share = 1.0 - exp(-since / PSP_CLOSING_TIME);
    double before = 0.0;
    if (since == 0.0) return;
    now->closing[0] += share * (0.0 - now->closing[0]);
    for (int i = 1; i < now->n; i++) {
        const double spacing = psp_contact_spacing(now->s[i - 1], platoon->cooperation.length[i - 1], platoon->constants.L);
        before += psp_closing_share(spacing, platoon->cooperation.closing_speed, platoon->cooperation.closing_spacing,
                                    platoon->cooperation.closing_reach);
        now->closing[i] += share * (before - now->closing[i]);
    }
}

double platoon_decide(Platoon *platoon, double since)
{
    Instant *now = &platoon->now;
    const Leader *leader = &platoon->leader;
    const int n = (int)now->n;
    const Constants *c = &platoon->constants;
    const bool closes = platoon->cooperation.closing_speed != 0.0;
    const bool held = leader->driven && now->driven && now->fraction > 0.0;
    const double a = held ? now->a[0]
                          : psp_driven(now->v[0], leader->speed, leader->acceleration, platoon->T, c->v_max);
    if (closes) engage(platoon, since);
    /* behind a leader that drives itself all take on what he does; what is commanded to himself is dropped */
    const double v_desired = leader->driven ? fmax(now->v[0], 0.0) : -1.0;
    const Traffic traffic = {NULL, NULL, v_desired, leader->driven ? leader->acceleration : 0.0,
                             closes ? now->closing : NULL};
    cooperative_command(c, &platoon->shape, &platoon->cooperation, &traffic, n, now->s, now->v, now->a);
    if (leader->driven) now->a[0] = a;
    now->driven = leader->driven;
    return lemma1_period(c, &platoon->cooperation, leader->driven, n, now->s, now->v, now->a);
}

double platoon_exact(const Platoon *platoon)
{
    const Instant *now = &platoon->now;
    return exact_period(&platoon->constants, platoon->papers ? NULL : &platoon->cooperation, now->driven != 0, (int)now->n,
                        now->s, now->v, now->a);
}

bool platoon_take_leader(Platoon *platoon, Front *front, const double *values, bool here)
{
    const Leader before = platoon->leader;
    Leader told;
    if (!before.driven && values[PSP_leader_automated] >= 0.5 && values[PSP_leader_automated] < INFINITY) return true;
    if (!read_leader(front, values, platoon->constants.v_max, &told)) return false;
    if (told.driven == before.driven && told.speed == before.speed && told.acceleration == before.acceleration) return true;
    platoon->leader = told;
    platoon_settle(platoon);
    if (!here) return true;
    if (!(platoon->now.bound > platoon->T)) platoon->now.violations--;
    return platoon_sample(platoon, front, 0.0, fmi2Error);
}
