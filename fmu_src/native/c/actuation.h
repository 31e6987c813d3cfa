/* Vehicles that act late and softly: dead time, first-order lag, limits; mirrors
 * psp_model/vehicles/actuation.py. */
#ifndef PSP_ACTUATION_H
#define PSP_ACTUATION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "names.h"
#include "psp_model.h" /* generated: PSP_N */

#ifndef PSP_QUEUE
#define PSP_QUEUE 512 /* most commands on their way at a time */
#endif

typedef struct {
    double actuation_delay; /* [s] */
    double actuator_lag[PSP_N], a_min[PSP_N], a_max[PSP_N];
} Actuation;

/* A command on its way. */
typedef struct {
    double due; /* time until it takes effect [s] */
    double a[PSP_N];
} OnItsWay;

/* The state of all actuators.  It is the last member of what holds it: of the queue a saved state has the rows in use only,
 * and nobody touches the others. */
typedef struct {
    double a[PSP_N], command[PSP_N];   /* accelerations given, commands in effect [m/s2] */
    int64_t rows, first, count;        /* a ring of `rows` rows; of `count` commands the row of the first to take effect */
    OnItsWay queue[PSP_QUEUE];
} Actuators;

/* Vehicles that drive themselves; as in psp_model.vehicles.actuation. */
typedef struct {
    const double *automated, *a;
} Foreign;

/* The rows that commands given every T need if each is on its way for `longest`; -1 for more than PSP_QUEUE, 0 for no time. */
int64_t actuators_rows(double longest, double T);

/* Actuators before the first command, with a ring of so many rows; the bytes of a saved state that belong to the ring. */
void actuators_begin(Actuators *actuators, int64_t rows);
size_t actuators_ring(const Actuators *actuators);

/* Whether actuators that were read from bytes can be ones with a ring of so many rows. */
bool actuators_can_be(const Actuators *actuators, int64_t rows);

/* A command of n vehicles that takes effect in `due`, at once where the ring has no rows; false if there is no room. */
bool actuators_command(Actuators *actuators, int n, const double *a, double due);

/* The newest of the commands, in effect or on its way. */
const double *actuators_last(const Actuators *actuators);

/* n vehicles a time tau later: their speeds, what they have moved (written), and the actuators.  `foreign` is NULL where all
 * are automated. */
void actuators_drive(Actuators *actuators, const Actuation *actuation, int n, double tau, const Foreign *foreign, double *v,
                     double *moved);

/* What actuators_drive does from `wait` from now on; nothing changes but v, moved, and accelerations given and commands in
 * effect then.  `places`: of each vehicle among those that the actuators are of, -1 for one that is new and whose actuator
 * holds 0; they rise.  NULL stands for the same vehicles. */
void actuators_foresee(const Actuators *actuators, const int32_t *places, const Actuation *actuation, int n, double wait,
                       double tau, const Foreign *foreign, double *v, double *moved, double *a, double *command);

/* The actuators of n other vehicles. */
void actuators_rearrange(Actuators *actuators, int n, const int32_t *places);

/* The actuators a time tau later; nothing but their own state counts. */
void actuators_settle(Actuators *actuators, const Actuation *actuation, int n, double tau);

#endif
