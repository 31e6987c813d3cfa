/* The motion of the plant's vehicles: mirrors psp_model/vehicles/road_plant.py and psp_model/vehicles/ideal.py. */
#include "plant.h"

#include <string.h>

#include "psp_kernels.h"

static void move(Plant *plant, const double *moved)
{
    plant->x += moved[0];
    for (int i = 1; i < PSP_N; i++) plant->s[i - 1] = psp_spacing_after(plant->s[i - 1], moved[i - 1], moved[i]);
}

/* One period of ideal vehicles. */
static void follow(Plant *plant, const double *a, double *moved)
{
    for (int i = 0; i < PSP_N; i++) {
        const double v = plant->v[i], then = psp_speed_after(v, a[i], plant->T);
        moved[i] = psp_travelled(v, a[i], then < 0.0 ? v / -a[i] : plant->T);
        plant->v[i] = then < 0.0 ? 0.0 : then;
    }
    memcpy(plant->actuators.a, a, sizeof plant->actuators.a);
    memcpy(plant->actuators.command, a, sizeof plant->actuators.command);
}

/* One period of any vehicles; a command that repeats the last one takes no room in the queue. */
static void drive(Plant *plant, const double *a, const double *automated, Driving *scratch)
{
    const Foreign foreign = {.automated = automated, .a = a};
    const double *last = actuators_last(&plant->actuators);
    bool repeated = true, own = true;
    for (int i = 0; i < PSP_N; i++) {
        scratch->asked[i] = automated[i] > 0.5 ? a[i] : 0.0;
        repeated = repeated && scratch->asked[i] == last[i];
        own = own && automated[i] > 0.5;
    }
    if (!repeated) actuators_command(&plant->actuators, PSP_N, scratch->asked, plant->actuation.actuation_delay);
    actuators_drive(&plant->actuators, &plant->actuation, PSP_N, plant->T, own ? NULL : &foreign, plant->v, scratch->moved);
}

void plant_advance(Plant *plant, int64_t period, const double *a, const double *automated, Driving *scratch)
{
    for (; plant->period < period; plant->period++) {
        if (plant->ideal) follow(plant, a, scratch->moved);
        else drive(plant, a, automated, scratch);
        move(plant, scratch->moved);
    }
}

double plant_acceleration(const Plant *plant, int vehicle)
{
    return psp_unless_standing(plant->v[vehicle], plant->actuators.a[vehicle]);
}
