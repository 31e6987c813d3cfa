/* The state of actuators and their commands on their way: mirrors psp_model/vehicles/actuation.py and
 * psp_model/vehicles/membership.py. */
#include "actuation.h"

#include <math.h>
#include <string.h>

#include "pieces.h"

int64_t actuators_rows(double longest, double T)
{
    const double periods = ceil(longest / T * (1.0 - 1e-9)); /* as many as were meant before rounding */
    if (!(longest > 0.0)) return 0;
    return periods <= PSP_QUEUE - 2 ? (int64_t)periods + 2 : -1;
}

void actuators_begin(Actuators *actuators, int64_t rows)
{
    memset(actuators, 0, offsetof(Actuators, queue));
    actuators->rows = rows;
}

size_t actuators_ring(const Actuators *actuators) { return (size_t)actuators->rows * sizeof(OnItsWay); }

bool actuators_can_be(const Actuators *actuators, int64_t rows)
{
    const Actuators *const at = actuators;
    if (at->rows != rows || !(0 <= at->count && at->count <= rows)) return false;
    if (!(at->first == 0 || (0 < at->first && at->first < rows))) return false;
    for (int i = 0; i < PSP_N; i++) {
        if (!isfinite(at->a[i]) || !isfinite(at->command[i])) return false;
    }
    for (int64_t k = 0; k < rows; k++) { /* also those that wait for a command: they are cheap, and no surprise later */
        if (!isfinite(at->queue[k].due)) return false;
        for (int i = 0; i < PSP_N; i++) {
            if (!isfinite(at->queue[k].a[i])) return false;
        }
    }
    return true;
}

bool actuators_command(Actuators *actuators, int n, const double *a, double due)
{
    double *into = actuators->command;
    if (actuators->rows > 0) {
        if (actuators->count == actuators->rows) return false;
        OnItsWay *const last = &actuators->queue[row_of(actuators, actuators->count++)];
        last->due = due;
        into = last->a;
    }
    for (int i = 0; i < PSP_N; i++) into[i] = i < n ? a[i] : 0.0;
    return true;
}

const double *actuators_last(const Actuators *actuators)
{
    return actuators->count > 0 ? actuators->queue[row_of(actuators, actuators->count - 1)].a : actuators->command;
}

static void rearrange(double *rows, int n, const int32_t *places, bool backwards)
{
    for (int k = 0; k < n; k++) {
        const int i = backwards ? n - 1 - k : k;
        rows[i] = places[i] < 0 ? 0.0 : rows[places[i]];
    }
    for (int i = n; i < PSP_N; i++) rows[i] = 0.0;
}

void actuators_rearrange(Actuators *actuators, int n, const int32_t *places)
{
    bool backwards = false; /* no row may be overwritten before it has been taken */
    for (int i = 0; i < n; i++) backwards = backwards || (0 <= places[i] && places[i] < i);
    rearrange(actuators->a, n, places, backwards);
    rearrange(actuators->command, n, places, backwards);
    for (int64_t k = 0; k < actuators->count; k++)
        rearrange(actuators->queue[row_of(actuators, k)].a, n, places, backwards);
}
