/* The plant in C: vehicles driven period by period; mirrors psp_model/vehicles/road_plant.py. */
#ifndef PSP_PLANT_H
#define PSP_PLANT_H

#include "actuation.h"
#include "vehicles.h"

typedef struct {
    double T;
    int64_t period; /* the current one */
    double x, s[PSP_N - 1], v[PSP_N], length[PSP_N]; /* motion at its beginning */
    Actuation actuation;
    int64_t ideal; /* the vehicles follow any command at once */
    Actuators actuators;
} Plant;

/* No room on a stack for many vehicles. */
typedef struct {
    double asked[PSP_N], moved[PSP_N];
} Driving;

/* plant_settings.c: the plant at its start from the values of the variables, checked; what of it says what the vehicles are,
 * and how many rows of the ring they need; false on failure, which has been logged. */
bool plant_begin(Plant *plant, Front *front, const double *values);
bool plant_take_vehicles(Plant *plant, Front *front, const double *values, int64_t *rows);

/* plant_motion.c: the plant at the beginning of a period, the accelerations held until then; what is shown of it. */
void plant_advance(Plant *plant, int64_t period, const double *a, const double *automated, Driving *scratch);
double plant_acceleration(const Plant *plant, int vehicle);

#endif
