/* Sampling instants and masters' times: mirrors psp_model/sampling/clock.py, which says why, bit for bit. */
#include "clock.h"

#include <float.h>
#include <math.h>

#include "vehicles.h"

#define SINGLE_EPSILON 0x1p-23 /* of single precision */
#define ULPS 4.0               /* [units in the last place] rounding of a time that is computed in another way than ours */
#define MIXED 16.0             /* [last places] that steps of different sizes may drift; equal ones drift without an end */
#define NANOSECONDS 2e-9       /* [s] what a master that counts nanoseconds rounds off in a few steps */
#define AIM 0x1p-6 /* [sampling periods] most drift of a master's time that a step to an absolute time makes up for */

/* The nearest whole number; `offset`: what is behind it. */
static int64_t nearest(double periods, double *offset)
{
    const double whole = floor(periods + 0.5);
    *offset = periods - whole;
    return (int64_t)whole;
}

static bool is_whole(double value) { return value == floor(value); }

/* How many binary digits a number needs, at most: 16, those of a round number; 24, of single precision; or 53. */
static int digits_of(double value)
{
    int exponent;
    const double mantissa = frexp(value, &exponent);
    return is_whole(mantissa * 0x1p16) ? 16 : is_whole(mantissa * 0x1p24) ? 24 : 53;
}

/* The place of the last of so many binary digits. */
static double spacing(double value, int digits)
{
    int exponent;
    frexp(value, &exponent);
    return fmax(ldexp(1.0, exponent - digits), 0x1p-1074);
}

/* The place of the last digit that a step size carries [s]: its own, or that of the times it is a difference of. */
static double last_place(double begin, double size)
{
    const double a = fabs(begin), b = fabs(begin + size), low = fmin(a, b), high = fmax(a, b);
    const double place = spacing(size, digits_of(size) == 24 ? 24 : 53);
    const double count = size / spacing(low > 0.0 ? low : high, 53);
    return count >= 0x1p53 || is_whole(count) ? fmax(place, spacing(high, 53)) : place;
}

void clock_begin(Clock *clock, double start, double phase, double T)
{
    const Clock fresh = {.first = start + phase, .time = start};
    *clock = fresh;
    clock->period = nearest(-phase / T, &clock->offset);
}

int64_t clock_at(const Clock *clock, double *fraction)
{
    *fraction = 0.0;
    if (fabs(clock->offset) <= TIME_TOLERANCE) return clock->period;
    *fraction = clock->offset > 0.0 ? clock->offset : 1.0 + clock->offset;
    return clock->offset > 0.0 ? clock->period : clock->period - 1;
}

bool clock_can_be(const Clock *clock)
{
    return isfinite(clock->first) && isfinite(clock->time) && fabs((double)clock->period) < PERIODS_MAX &&
           fabs(clock->offset) <= 1.0 && isfinite(clock->last) && clock->last >= 0.0 && isfinite(clock->doubt) &&
           clock->doubt >= 0.0;
}

bool clock_is_fresh(const Clock *clock)
{
    const double here = (double)clock->period + clock->offset;
    return -1.0 <= here && here <= 0.0 && clock->last == 0.0 && clock->doubt == 0.0;
}

double clock_time_of(const Clock *clock, int64_t instant, double T)
{
    double fraction;
    const int64_t period = clock_at(clock, &fraction);
    return clock->time + ((double)(instant - period) - fraction) * T;
}

double clock_age_rounding(const Clock *clock, double age, double T)
{
    const double periods = fmin(fmax(age, 0.0) / T, PERIODS_MAX); /* which the master's time may have drifted in */
    return TIME_TOLERANCE * T + ULPS * DBL_EPSILON * fabs(clock->time) * (1.0 + periods);
}

/* By how much more than its rounding the master's time has moved since the last step ended [s]. */
static double moved(const Clock *clock, double begin, double size)
{
    const double by = begin - clock->time;
    if (fabs(by) <= ULPS * DBL_EPSILON * fabs(begin)) return 0.0;
    const bool single = digits_of(begin) <= 24 && digits_of(size) <= 24; /* it keeps time in single precision */
    return single && fabs(by) <= SINGLE_EPSILON * fabs(begin) ? 0.0 : by;
}

/* Drops the rounding, if the nearest sampling instant is met here. */
static void settle(Clock *clock, double periods, double reach, bool again, double T)
{
    const double apart = fabs(clock->offset), half = 0.5 * periods;
    if (!(apart <= TIME_TOLERANCE || apart <= fmin(TIME_TOLERANCE + reach, half))) {
        if (again || !(apart <= fmin(AIM, half))) return;
        /* a step unlike the last one may aim at a time; the master's, which has drifted from the sum of its steps */
        const double rounding = ULPS * DBL_EPSILON * fabs(clock->time) / T;
        const double off = fabs((clock->time - clock->first) / T - (double)clock->period);
        if (!(rounding <= 0.25 * apart && off <= fmin(TIME_TOLERANCE, 0.5 * apart) + rounding)) return;
        reach = apart;
    }
    clock->offset = copysign(fmin(fmax(apart - fmin(reach, half), 0.0), TIME_TOLERANCE), clock->offset);
    clock->doubt = 0.0;
}

bool clock_pass(Clock *clock, double begin, double size, double T)
{
    const double end = begin + size, by = moved(clock, begin, size);
    const bool one = size == T && by == 0.0; /* what most masters do */
    const double periods = one ? 1.0 : fmax(size + by, 0.0) / T;
    if (!(fabs((double)clock->period + periods) < PERIODS_MAX && isfinite(end))) return false;
    clock->time = end;
    if (one && clock->offset == 0.0) { /* with the result of what follows */
        clock->period++;
        clock->last = size;
        clock->doubt = 0.0;
        return true;
    }
    if (periods == 0.0) return true;
    const bool at_instant = fabs(clock->offset) <= TIME_TOLERANCE;
    const int64_t whole = nearest(clock->offset + periods, &clock->offset);
    clock->period += whole;
    const double place = last_place(begin, size);
    const bool again = fabs(size - clock->last) <= place;
    if (again || clock->doubt < MIXED * place / T) clock->doubt += 0.5 * place / T;
    clock->last = size;
    const double reach = fmax(place / T + clock->doubt, fmin(NANOSECONDS / T, TIME_TOLERANCE));
    if (whole != 0 || !at_instant) settle(clock, periods, reach, again, T); /* else that instant has been met */
    return true;
}
