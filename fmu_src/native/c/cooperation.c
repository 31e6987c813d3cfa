/* The extended law: mirrors psp_model/law/cooperation.py and psp_model/law/following.py. */
#include "cooperation.h"

#include "psp_kernels.h"
#include "slope.h"

/* What a vehicle takes on: the speed and acceleration of the one that it follows. */
typedef struct {
    double speed, rate;
} Followed;

void papers_law(Cooperation *cooperation, const Constants *constants)
{
    *cooperation = (Cooperation){.kappa_reach = 30.0, .feedforward = 1.0, .following = FOLLOW_NEAREST,
                                 .closing_spacing = 15.0, .closing_reach = 100.0};
    for (int i = 0; i < PSP_N; i++) cooperation->length[i] = constants->L;
}

bool spacings_are_model_spacings(const Constants *constants, const Cooperation *cooperation, int n)
{
    if (cooperation->time_gap != 0.0) return false;
    for (int i = 0; i < n - 1; i++) {
        if (cooperation->length[i] != constants->L) return false;
    }
    return true;
}

void contact_spacing(const Constants *constants, const Cooperation *cooperation, int n, const double *s, double *spacing)
{
    for (int i = 0; i < n - 1; i++) spacing[i] = psp_contact_spacing(s[i], cooperation->length[i], constants->L);
}

void clearances(const Constants *constants, const Cooperation *cooperation, int n, const double *s, double *clearance)
{
    for (int i = 0; i < n - 1; i++) clearance[i] = psp_clearance(s[i], cooperation->length[i], constants->L);
}

/* Of the vehicle at index `i` + 1, from the spacing in front of it and its speed. */
static inline double model_spacing_of(const Constants *constants, const Cooperation *cooperation, int i, double s, double v)
{
    return cooperation->time_gap == 0.0
               ? psp_contact_spacing(s, cooperation->length[i], constants->L)
               : psp_model_spacing(s, v, cooperation->length[i], cooperation->time_gap, constants->L);
}

void model_spacing(const Constants *constants, const Cooperation *cooperation, int n, const double *s, const double *v,
                   double *spacing)
{
    for (int i = 0; i < n - 1; i++) spacing[i] = model_spacing_of(constants, cooperation, i, s[i], v[i + 1]);
}

static inline bool drives_itself(const double *automated, int i) { return automated && automated[i] < 0.5; }

void closing_speeds(const Cooperation *cooperation, int n, const double *spacing, const double *automated,
                    double *closing)
{
    double before = 0.0;
    closing[0] = 0.0;
    for (int i = 0; i < n - 1; i++) {
        if (cooperation->following == FOLLOW_PREDECESSOR || drives_itself(automated, i)) before = 0.0;
        before += psp_closing_share(spacing[i], cooperation->closing_speed, cooperation->closing_spacing,
                                    cooperation->closing_reach);
        closing[i + 1] = before;
    }
}

void followed_by(int n, const double *automated, int64_t following, double *followed)
{
    double nearest = 0.0;
    for (int i = 0; i < n; i++) {
        if (i > 0 && (following == FOLLOW_PREDECESSOR || drives_itself(automated, i - 1))) nearest = i;
        followed[i] = drives_itself(automated, i) ? 0.0 : nearest;
    }
}

/* What the vehicle at index `i` takes on, given what the one ahead does. */
static inline Followed speeds_followed(const Cooperation *cooperation, const Traffic *traffic, int i, const double *v,
                                       Followed ahead)
{
    if (cooperation->following == FOLLOW_PREDECESSOR) return (Followed){v[i - 1], 0.0};
    if (drives_itself(traffic->automated, i - 1)) return (Followed){v[i - 1], traffic->a ? traffic->a[i - 1] : 0.0};
    return ahead;
}

/* Whether all vehicles tend to one desired speed and nothing else is asked of them. */
static bool have_one_aim(const Cooperation *cooperation, const Traffic *traffic)
{
    return !traffic->automated && !traffic->closing && traffic->a_desired == 0.0 &&
           cooperation->following == FOLLOW_NEAREST;
}

void cooperative_command(const Constants *constants, const Shape *shape, const Cooperation *cooperation,
                         const Traffic *traffic, int n, const double *s, const double *v, double *a)
{
    const Constants c = *constants;
    const Shape h = *shape;
    const double kappa = cooperation->kappa, reach = cooperation->kappa_reach;
    const bool one_aim = have_one_aim(cooperation, traffic), free = one_aim && traffic->v_desired < 0.0;
    if (one_aim && kappa == 0.0 && spacings_are_model_spacings(constants, cooperation, n)) {
        if (free) feedback(constants, shape, n, s, v, a);
        else feedback_towards(constants, shape, n, s, v, traffic->v_desired, a);
        return;
    }
    Followed taken = {traffic->v_desired < 0.0 ? c.v_star : traffic->v_desired, traffic->a_desired};
    double slope_in_front = 0.0, drag_in_front = 0.0;
    for (int i = 0; i < n; i++) {
        double slope_behind = 0.0, drag_behind = 0.0;
        if (i < n - 1) {
            const double spacing = model_spacing_of(constants, cooperation, i, s[i], v[i + 1]);
            slope_behind = slope_at(&c, &h, spacing);
            if (kappa != 0.0) drag_behind = psp_drag(spacing, v[i], v[i + 1], kappa, reach, c.L);
        }
        const double u = slope_in_front - slope_behind;
        if (free) a[i] = psp_command(u, v[i], c.v_star, c.v_max, c.epsilon, c.mu);
        else {
            if (i > 0) taken = speeds_followed(cooperation, traffic, i, v, taken);
            const double speed =
                traffic->closing ? psp_closing_up(taken.speed, traffic->closing[i], c.v_max) : taken.speed;
            a[i] = psp_command_towards(u, v[i], speed, c.v_max, c.epsilon, c.mu) +
                   psp_feed_forward(v[i], taken.rate, cooperation->feedforward, c.v_max);
        }
        if (kappa != 0.0) a[i] += drag_in_front - drag_behind;
        slope_in_front = slope_behind;
        drag_in_front = drag_behind;
    }
}
