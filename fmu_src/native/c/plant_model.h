/* What the plant FMU holds beside its variables. */
#ifndef PSP_PLANT_MODEL_H
#define PSP_PLANT_MODEL_H

#include "plant.h"

typedef Plant Part;
#define PART_ACTUATORS actuators

typedef Driving Scratch;

#define PART_ACTUATORS actuators

#endif
