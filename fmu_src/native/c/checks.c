/* Checks of values from outside that all native FMUs share: mirrors psp_model/validate.py and
 * fmu_src/interface/meaning.py. */
#include "vehicles.h"

#include <math.h>
#include <stdio.h>

double printable(double value) { return isnan(value) ? (double)NAN : value; }

bool finite_or_log(Front *front, const char *name, double value, const char *unit)
{
    if (isfinite(value)) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_finite, name, printable(value), unit);
    return false;
}

bool finite_element(Front *front, const char *name, int vehicle, double value, const char *unit)
{
    char indexed[48];
    if (isfinite(value)) return true;
    snprintf(indexed, sizeof indexed, "%s[%d]", name, vehicle);
    return finite_or_log(front, indexed, value, unit);
}

bool read_period(Front *front, const double *read, double *T)
{
    *T = read[PSP_T];
    if (!finite_or_log(front, "T", *T, "s")) return false;
    REQUIRE(*T > 0.0, PSP_SENTENCE_T, *T);
    return true;
}

bool check_start(Front *front, int n, double x, const double *s, const double *v, const double *length, double L,
                 double v_max)
{
    if (!finite_or_log(front, "x_start", x, "m")) return false;
    for (int i = 0; i < n - 1; i++) {
        if (!finite_element(front, "s_start", i + 2, s[i], "m")) return false;
        REQUIRE(s[i] > 0.0, PSP_SENTENCE_spacing_order, i + 2, s[i], i + 2, i + 1);
        if (!length || length[i] == L) REQUIRE(s[i] > L, PSP_SENTENCE_spacing, i + 2, s[i], L);
        else REQUIRE(s[i] > length[i], PSP_SENTENCE_spacing_length, i + 2, s[i], i + 1, length[i]);
    }
    for (int i = 0; i < n; i++) {
        if (!finite_element(front, "v_start", i + 1, v[i], "m/s")) return false;
        REQUIRE(v[i] >= 0.0, PSP_SENTENCE_speed_backwards, i + 1, v[i], v_max, i + 1);
        REQUIRE(v[i] <= v_max, PSP_SENTENCE_speed, i + 1, v[i], v_max, i + 1);
    }
    return true;
}
