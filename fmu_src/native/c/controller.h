/* The controller of measured vehicles in C: mirrors psp_model/controller. */
#ifndef PSP_CONTROLLER_H
#define PSP_CONTROLLER_H

#include "actuation.h"
#include "certificate.h"
#include "cooperation.h"
#include "prediction.h"
#include "uncertain.h"
#include "vehicles.h"

enum { BAD_INPUT_ERROR = 1, BAD_INPUT_SAFE_ACTION = 2 };

/* What the controller is told once. */
typedef struct {
    Constants constants;
    Weights weights;
    Request request; /* for no vehicles yet */
    double T, phase, a_safe, max_age, oldest;
    Errors errors;
    int policy, bad_input, certificate;
    bool predicts, lags, plain; /* plain: with all vehicles automated and no a_desired the law is the paper's */
    int64_t rows;               /* of the queue of commands */
    Cooperation cooperation;
    Actuation actuation;
} Settings;

/* What it is told at a sampling instant. */
typedef struct {
    const double *s, *v; /* room for PSP_N vehicles, of which n_active count */
    double n_active, resolve, age, age_rounding;
    double v_desired; /* v_star at -1 and below */
    double a_desired;
    const double *automated, *a_measured, *a_known;
} Measurement;

/* What a decision was based on.  The state was predicted for the time at which the command takes effect; where that is the
 * measured one, and where all are automated, the arrays for it are not written. */
typedef struct {
    double age;
    bool as_measured, all_automated;
    double s[PSP_N - 1], v[PSP_N]; /* measured, inside the state space */
    double automated[PSP_N], s_predicted[PSP_N - 1], v_predicted[PSP_N], a_predicted[PSP_N];
} Basis;

/* What it decided at a sampling instant, and all that it remembers of the past but the commands on their way. */
typedef struct {
    int64_t n, violations, faults, choices; /* n: vehicles at the last choice, and in the basis, which is there from 1 on */
    int64_t remembered;                     /* vehicles that commands and estimates are remembered of, 0 for none */
    double T_max, T_exact, resolve; /* exact_of() knows where T_exact has not been computed yet */
    Shape shape;
    bool in_order, in_domain, watches;
    double a[PSP_N], saturated[PSP_N];
    Basis basis;
    Watched watched; /* if it watches */
} Command;

/* What is measured, in order: of n vehicles. */
typedef struct {
    int n;
    double age, v_desired, a_desired; /* v_desired below 0 for v_star */
    const double *automated;          /* NULL where all are */
} Seen;

/* Room for a decision: there is none on a stack for many vehicles. */
typedef struct {
    double a_measured[PSP_N], a_known[PSP_N], a_foreign[PSP_N]; /* of vehicles that drive themselves */
    double spacing[PSP_N], contact[PSP_N], speed[PSP_N], before[PSP_N], foreign[PSP_N], wanted[PSP_N];
    double behind_s[PSP_N + 1], behind_v[PSP_N + 1];
    int32_t places[PSP_N];
    Ahead ahead;
} Work;

/* All of these are false on failure, which has been logged. */

/* controller_settings.c: from the values of the variables, checked; the command before the first sampling instant. */
bool read_settings(Front *front, const double *values, Settings *settings);
void nothing_decided(const Settings *settings, Command *now);

/* controller_sample.c: decides at a sampling instant, given what was decided before and the commands issued; on failure there
 * is nothing in `now`. */
bool decide(const Settings *settings, Front *front, double time, const Measurement *measured, const Actuators *issued,
            const Command *before, Command *now, Work *work);

/* The bound on the sampling period that counts, by the certificate chosen. */
static inline double certified_period(const Settings *settings, const Command *command)
{
    return settings->certificate == CERTIFICATE_EXACT ? command->T_exact : command->T_max;
}

enum { LONGEST_SENTENCE = 512 };

/* controller_measurement.c: takes the inputs if they are in order; if not, `text` says why, and false.  How many vehicles
 * that can be are said to be there, PSP_N where it is no number of vehicles. */
bool take(const Settings *settings, const Measurement *measured, Basis *basis, Seen *seen, Work *work, char *text);
int said_to_be_active(const Measurement *measured);

/* controller_law.c: the bounded law for vehicles that are in order, and what certifies it. */
void command_regularly(const Settings *settings, const Seen *seen, const Actuators *issued, const Command *before,
                       Command *now, Work *work);

/* controller_members.c: the place that each of n vehicles had among those that are remembered, into the work, `now` being NULL
 * where it is not known what they do; the commands of another decision go on their way. */
void find_members(const Command *before, const Basis *now, int n, Work *work);
void give_commands(const Settings *settings, Actuators *issued, const Command *before, const Command *now, Work *work);

/* controller_margin.c: T_exact, brake_margin, and the number of the vehicle that each one follows. */
double exact_of(const Settings *settings, const Command *command);
double margin_of(const Settings *settings, const Command *command, Work *work);
void followed_of(const Settings *settings, const Command *command, double *followed);

#endif
