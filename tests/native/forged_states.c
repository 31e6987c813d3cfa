/* Saved states of a native FMU with one field forged and the checksum made to fit, each taken up and run on: whatever is in
 * them, nothing may crash, hang or leave the array it belongs to.  Meant for AddressSanitizer and UBSan.
 *
 * forged_states SEED     prints how many were refused and how many taken; 1 where an honest state was not taken
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"
#include "psp_model.h"

enum { SUM = 8, SUMMED = 16, TIME = 40, OUTPUTS = PSP_COUNT - PSP_FIRST_OUTPUT };

static unsigned long refused, taken;

static void ignore(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

static const fmi2CallbackFunctions CALLBACKS = {ignore, calloc, free, NULL, NULL};

static void seal(char *bytes, size_t size)
{
    uint64_t sum = UINT64_C(14695981039346656037);
    for (size_t i = SUMMED; i < size; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
    memcpy(bytes + SUM, &sum, sizeof sum);
}

/* All that a host may do with a state that was taken. */
static void live_on(fmi2Component c, double time)
{
    fmi2ValueReference all[OUTPUTS];
    double seen[OUTPUTS];
    const double one = 1.0;
    double T = 0.0;
    const fmi2ValueReference known = PSP_FIRST_INPUT, period = PSP_T;
    fmi2FMUstate again = NULL;
    for (int i = 0; i < OUTPUTS; i++) all[i] = (fmi2ValueReference)(PSP_FIRST_OUTPUT + i);
    fmi2GetReal(c, all, OUTPUTS, seen);
    fmi2GetReal(c, all, 1, seen);
    fmi2ExitInitializationMode(c);
    fmi2SetReal(c, &known, 1, &one);
    fmi2GetDirectionalDerivative(c, all, 1, &known, 1, &one, seen);
    fmi2GetReal(c, &period, 1, &T);
    const double size = T > 0.0 ? fmin(0.025, 1000.0 * T) : 0.025; /* a tiny T is in order, and takes as long as it must */
    for (int k = 0; k < 3; k++) {
        fmi2DoStep(c, time, size, fmi2True);
        fmi2GetReal(c, all, OUTPUTS, seen);
        time += size;
    }
    fmi2GetFMUstate(c, &again);
}

static int try_state(fmi2Component c, const char *bytes, size_t size)
{
    fmi2FMUstate read = NULL;
    double time;
    const fmi2Status status = fmi2DeSerializeFMUstate(c, bytes, size, &read);
    memcpy(&time, bytes + TIME, sizeof time);
    if (status == fmi2OK && fmi2SetFMUstate(c, read) == fmi2OK) live_on(c, time);
    if (status == fmi2OK) taken++;
    else refused++;
    fmi2Reset(c);
    return status == fmi2OK;
}

static void forge_all(fmi2Component c, const char *honest, size_t size)
{
    const double numbers[] = {NAN, INFINITY, -INFINITY, -1.0, 0.0, 0.5, 1.0, 2.0, 1e9, 1e300, -1e300, 4e-324, 9e15, 2147483648.0};
    const uint64_t whole[] = {1, 2, 7, 8, 64, 255, UINT64_C(0x0101010101010101), UINT64_C(0x7fffffffffffffff),
                              UINT64_C(0x8000000000000000), UINT64_MAX, UINT64_C(0x0020000000000000), UINT64_C(0xffffffff)};
    char *forged = malloc(size);
    for (size_t at = SUMMED + 8; at + 8 <= size; at += 4) {
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers + sizeof whole / sizeof *whole; k++) {
            const size_t count = sizeof numbers / sizeof *numbers;
            memcpy(forged, honest, size);
            if (k < count) memcpy(forged + at, &numbers[k], 8);
            else memcpy(forged + at, &whole[k - count], k % 2 ? 4 : 8);
            seal(forged, size);
            try_state(c, forged, size);
        }
        alarm(60); /* a hang ends here */
    }
    free(forged);
}

static void forge_at_random(fmi2Component c, const char *honest, size_t size, unsigned seed)
{
    char *forged = malloc(size);
    srand(seed);
    for (int round = 0; round < 3000; round++) {
        memcpy(forged, honest, size);
        for (int k = rand() % 4; k >= 0; k--) forged[SUMMED + 8 + (size_t)rand() % (size - SUMMED - 8)] = (char)rand();
        seal(forged, size);
        try_state(c, forged, size);
        if (round % 100 == 0) alarm(60);
    }
    free(forged);
}

/* Parameters of the component with which its state holds most. */
static void prepare(fmi2Component c, int mode)
{
#ifdef PSP_parameter_source
    const fmi2ValueReference source = PSP_parameter_source;
    const int two = 2;
    if (mode < 3) fmi2SetInteger(c, &source, 1, &two);
#else
    (void)mode;
#endif
#ifdef PSP_leader_automated
    const fmi2ValueReference real[] = {PSP_kappa, PSP_closing_speed, PSP_length, PSP_leader_automated}, certificate =
                             PSP_certificate;
    const double extended[] = {0.5, 0.5, 6.0, 0.0};
    if (mode > 2) fmi2SetReal(c, real, 4, extended);
    if (mode > 2) fmi2SetInteger(c, &certificate, 1, &two);
#endif
#ifdef PSP_actuation_delay
    const fmi2ValueReference delay = PSP_actuation_delay, lag = PSP_actuator_lag;
    const double late = 0.033, soft = 0.1;
    fmi2SetReal(c, &delay, 1, &late);
    fmi2SetReal(c, &lag, 1, &soft);
#endif
#if defined(PSP_closing_speed) && defined(PSP_automated)
    const fmi2ValueReference closing = PSP_closing_speed, first = PSP_automated, known = PSP_a_known;
    const double slowly = 0.6, none = 0.0;
    fmi2SetReal(c, &closing, 1, &slowly);
    fmi2SetReal(c, &first, 1, &none);
    fmi2SetReal(c, &known, 1, &none);
#endif
}

int main(int words, char **word)
{
    fmi2Component c = fmi2Instantiate("forged", fmi2CoSimulation, PSP_GUID, NULL, &CALLBACKS, fmi2False, fmi2False);
    const unsigned seed = words > 1 ? (unsigned)atoi(word[1]) : 1;
    int failed = !c;
    for (int mode = 0; mode < 4 && c; mode++) { /* instantiated, initialization, at the start, in a run */
        fmi2FMUstate state = NULL;
        size_t size = 0;
        fmi2Reset(c);
        fmi2SetupExperiment(c, fmi2False, 0.0, 2.0, fmi2False, 0.0);
        prepare(c, mode);
        if (mode > 0) fmi2EnterInitializationMode(c);
        if (mode > 1) fmi2ExitInitializationMode(c);
        if (mode > 2) fmi2DoStep(c, 2.0, 0.053, fmi2True);
        fmi2GetFMUstate(c, &state);
        fmi2SerializedFMUstateSize(c, state, &size);
        char *bytes = malloc(size);
        fmi2SerializeFMUstate(c, state, bytes, size);
        failed |= !try_state(c, bytes, size);
        if (mode > 1) forge_all(c, bytes, size);
        forge_at_random(c, bytes, size, seed);
        free(bytes);
    }
    if (c) fmi2FreeInstance(c);
    printf("%lu refused, %lu taken\n", refused, taken);
    return failed;
}
