/* What the plant's parameters say: mirrors fmu_src/interface/road.py and the checks of psp_model/validate.py. */
#include "plant.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define LONGEST_DEAD_TIME (PSP_QUEUE - 2) /* [periods] */
#define NO_LIMIT 1000.0                   /* [m/s2] stands for none */
#define LEAST 4.9406564584124654e-324     /* the least number above 0: only the order of the vehicles is required */

static bool require_not_negative(Front *front, const char *name, double value, const char *unit)
{
    if (!finite_or_log(front, name, value, unit)) return false;
    REQUIRE(value >= 0.0, PSP_SENTENCE_not_negative, name, value, unit, unit);
    return true;
}

static bool take_lengths(Front *front, const double *lengths, Plant *plant)
{
    for (int i = 0; i < PSP_N; i++) {
        const double length = lengths[i];
        if (!finite_element(front, "length", i + 1, length, "m")) return false;
        REQUIRE(length > 0.0, PSP_SENTENCE_length, i + 1, length, i + 1);
        plant->length[i] = length;
    }
    return true;
}

static bool take_actuation(Front *front, const double *read, Actuation *actuation)
{
    char name[48];
    actuation->actuation_delay = read[PSP_actuation_delay];
    if (!require_not_negative(front, "actuation_delay", actuation->actuation_delay, "s")) return false;
    for (int i = 0; i < PSP_N; i++) {
        actuation->actuator_lag[i] = read[PSP_actuator_lag + i];
        snprintf(name, sizeof name, "actuator_lag[%d]", i + 1);
        if (!require_not_negative(front, name, actuation->actuator_lag[i], "s")) return false;
    }
    for (int i = 0; i < PSP_N; i++) {
        const double least = read[PSP_a_min + i], most = read[PSP_a_max + i];
        REQUIRE(least < 0.0 && 0.0 < most, PSP_SENTENCE_command_limits, i + 1, printable(least), i + 1, printable(most));
        actuation->a_min[i] = least > -NO_LIMIT ? least : -INFINITY;
        actuation->a_max[i] = most < NO_LIMIT ? most : INFINITY;
    }
    return true;
}

static bool is_ideal(const Actuation *actuation)
{
    bool ideal = actuation->actuation_delay == 0.0;
    for (int i = 0; i < PSP_N; i++)
        ideal = ideal && actuation->actuator_lag[i] == 0.0 && isinf(actuation->a_min[i]) && isinf(actuation->a_max[i]);
    return ideal;
}

bool plant_take_vehicles(Plant *plant, Front *front, const double *read, int64_t *rows)
{
    const double *s = read + PSP_s_start, *v = read + PSP_v_start, delay = read[PSP_actuation_delay];
    if (!check_start(front, PSP_N, read[PSP_x_start], s, v, NULL, LEAST, DBL_MAX) || !read_period(front, read, &plant->T) ||
        !take_lengths(front, read + PSP_length, plant) || !take_actuation(front, read, &plant->actuation))
        return false;
    REQUIRE(delay <= LONGEST_DEAD_TIME * plant->T, PSP_SENTENCE_dead_time, delay, LONGEST_DEAD_TIME, plant->T);
    plant->ideal = is_ideal(&plant->actuation);
    *rows = actuators_rows(delay, plant->T);
    if (*rows < 0) *rows = PSP_QUEUE; /* the quotient was rounded up */
    return true;
}

bool plant_begin(Plant *plant, Front *front, const double *read)
{
    int64_t rows;
    memset(plant, 0, offsetof(Plant, actuators));
    if (!plant_take_vehicles(plant, front, read, &rows)) return false;
    plant->x = read[PSP_x_start];
    memcpy(plant->s, read + PSP_s_start, sizeof plant->s);
    memcpy(plant->v, read + PSP_v_start, sizeof plant->v);
    actuators_begin(&plant->actuators, rows);
    return true;
}
