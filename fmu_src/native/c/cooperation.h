/* The law for platoons on a road: viscosity, feed-forward, closing up, time gap, lengths. */
#ifndef PSP_COOPERATION_H
#define PSP_COOPERATION_H

#include "vehicles.h"

enum { FOLLOW_NEAREST = 1, FOLLOW_PREDECESSOR = 2 };

/* The parameters of the extended law (psp_model/law/cooperation.py). */
typedef struct {
    double kappa, kappa_reach, time_gap, feedforward;
    int64_t following;
    double closing_speed, closing_spacing, closing_reach;
    double length[PSP_N]; /* all of them; L where nothing is known of them */
} Cooperation;

/* The inputs at a sampling instant besides spacings and speeds; the arrays have a row for each vehicle. */
typedef struct {
    const double *automated;      /* 0 for a vehicle that drives itself, 1 else; NULL where all are automated */
    const double *a;              /* accelerations, of which those of vehicles that drive themselves count; NULL for 0 */
    double v_desired, a_desired;  /* of vehicles that follow no vehicle; v_desired below 0: v_star */
    const double *closing;        /* what closing up adds to the desired speeds; NULL for 0 */
} Traffic;

/* The parameters with which the law is the paper's. */
void papers_law(Cooperation *cooperation, const Constants *constants);

/* Whether model spacings are spacings: no time gap, and the first n - 1 vehicles have the length L. */
bool spacings_are_model_spacings(const Constants *constants, const Cooperation *cooperation, int n);

/* Of n vehicles: n - 1 spacings with the lengths ahead taken for L, bumper to bumper, and what the potential is a function of;
 * the last two may be put where `s` is. */
void contact_spacing(const Constants *constants, const Cooperation *cooperation, int n, const double *s, double *spacing);
void clearances(const Constants *constants, const Cooperation *cooperation, int n, const double *s, double *clearance);
void model_spacing(const Constants *constants, const Cooperation *cooperation, int n, const double *s, const double *v,
                   double *spacing);

/* What closing up adds to the desired speed of each of n vehicles, from their model spacings. */
void closing_speeds(const Cooperation *cooperation, int n, const double *spacing, const double *automated,
                    double *closing);

/* The number of the vehicle whose speed each of n vehicles takes on, 0 for none. */
void followed_by(int n, const double *automated, int64_t following, double *followed);

/* The accelerations of n vehicles under the extended law, given their spacings and speeds; those of feedback() and
 * feedback_towards(), bit for bit and as fast, where it is the paper's. */
void cooperative_command(const Constants *constants, const Shape *shape, const Cooperation *cooperation,
                         const Traffic *traffic, int n, const double *s, const double *v, double *a);

#endif
