/* The controller of measured vehicles in C: mirrors psp_model/controller.py. */
#ifndef PSP_CONTROLLER_H
#define PSP_CONTROLLER_H

#include "vehicles.h"

enum { BAD_INPUT_ERROR = 1, BAD_INPUT_SAFE_ACTION = 2 };

/* What the controller is told once. */
typedef struct {
    Constants constants;
    Weights weights;
    Request request; /* for no vehicles yet */
    double T, phase, a_min, a_max, a_safe, max_age;
    int policy, bad_input;
} Settings;

/* What it is told at a sampling instant. */
typedef struct {
    const double *s, *v; /* room for PSP_N vehicles, of which n_active count */
    double n_active, resolve, age, age_rounding;
    double v_desired; /* v_star at -1 and below */
} Measurement;

/* What it decided at a sampling instant, and all that it remembers of the past. */
typedef struct {
    int64_t n, violations, faults, choices; /* n: vehicles at the last choice */
    double T_max, resolve;
    Shape shape;
    bool in_order, in_domain;
    double a[PSP_N], saturated[PSP_N];
} Command;

/* A decision in the making: what was measured, inside the state space, and what is decided from it. */
typedef struct {
    double s[PSP_N], v[PSP_N];
    double v_desired; /* below 0 for v_star */
    Command now;
} Decision;

/* All of these are false on failure, which has been logged. */

/* controller_settings.c: from the values of the variables, checked; the command before the first sampling instant. */
bool read_settings(Front *front, const double *values, Settings *settings);
void nothing_decided(const Settings *settings, Command *now);

/* controller_sample.c: decides at a sampling instant, given what was decided before. */
bool decide(const Settings *settings, Front *front, double time, const Measurement *measured, const Command *before,
            Decision *decision);

#endif
