/* A change of the platoon, tried out on a copy. */
#ifndef PSP_PLATOON_TRIAL_H
#define PSP_PLATOON_TRIAL_H

#include "platoon_model.h"

/* A vehicle that wants to join behind the vehicle at `place`, 0: ahead of the leader. */
typedef struct {
    int place;
    double spacing, speed, length;
} Joining;

/* What is said of a vehicle that wants to join: T would not be certified, the brake margin would be too small, nothing. */
typedef enum { NOT_CERTIFIED, TOO_CLOSE, MAY_JOIN } Verdict;

/* What a change is tried out in. */
typedef struct {
    Front *front;
    const Part *part;
    Request request;
    Instant seen;  /* the platoon at the time of the change */
    double since;  /* time since its last sampling instant [s] */
    Platoon trial; /* the platoon after it */
    double room[PSP_N]; /* its spacings, with the lengths ahead taken for L */
    double clearance[PSP_N], no_lag[PSP_N], a_min[PSP_N];
} Work;

/* All bool below are false on failure, which has been logged. */

/* Chooses the potential for the vehicles of the trial. */
bool trial_choose(Work *work);

/* Samples the trial with the vehicle, with the potential in use or one chosen `anew`. */
bool trial_join(Work *work, const Joining *joining, bool anew, Verdict *verdict);

/* The nearest spacing found at which the vehicle may join, 0 if there is none. */
bool trial_find_spacing(Work *work, const Joining *asked, double *offered);

/* Takes the vehicle at index `gone` out of the trial, which is not sampled. */
void trial_take_out(Work *work, int gone);

#endif
