/* Speed of an FMU's fmi2DoStep + fmi2GetReal of all outputs, against a hand-written loop of the same arithmetic.
 *
 * native_speed LIBRARY RESOURCE_URI GUID OUTPUTS FIRST_OUTPUT S_START V_START SOURCE GAP STEPS REPEATS [fmu|both]
 * prints: nanoseconds per step of the FMU, of the loop, largest difference of the outputs, share of gaps on the hill.
 * N, the number of vehicles, is fixed when this is compiled, as it is in the FMU.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { MOTION = 4 * N - 1, REPORTS = 10, MEMBERS = N + 5, OUTPUTS = MOTION + REPORTS + MEMBERS };

static const double L = 5.0, LAMBDA = 20.0, V_STAR = 30.0, V_MAX = 35.0, EPSILON = 0.2, MU = 0.5;
static const double T = 0.01, W1 = 0.5, W2 = 0.5, A_REF = 4.0, S_REF = 20.0;

typedef struct {
    double alpha, r, p, x, s[N - 1], v[N], a[N], T_max, of_acceleration, of_gaps, violations;
    double members[MEMBERS]; /* how many vehicles, their numbers, and what became of changes: nothing */
    long on_hill;
} Loop;

static double slope(Loop *loop, double s)
{
    const double d = s - L, e = s < LAMBDA ? LAMBDA - s : 0.0, near = e / d, t = s - loop->r, q = (3.0 - t) * t;
    const double base = loop->alpha * (e * near * (3.0 + near));
    if (!(q > 0.0)) return -base;
    loop->on_hill++;
    return 2.0 * (pow(q, loop->p - 1.0) * (loop->p * (1.5 - t) - q / d) / (d * d)) - base;
}

static void feedback(Loop *loop)
{
    double front = 0.0, least = INFINITY;
    const double margin = V_MAX - V_STAR, smooth = V_MAX / (V_STAR * margin);
    for (int i = 0; i < N; i++) {
        double behind = 0.0;
        if (i < N - 1) {
            behind = slope(loop, loop->s[i]);
            const double bound = (loop->s[i] - L) / V_MAX;
            if (bound < least) least = bound;
        }
        const double u = front - behind, v = loop->v[i], up = u > 0.0 ? u : 0.0, down = u < 0.0 ? u : 0.0;
        const double ramp = down + EPSILON > 0.0 ? down + EPSILON : 0.0;
        const double k = MU + smooth * (ramp * ramp / (2.0 * EPSILON));
        const double a = up * ((V_MAX - v) / margin) + down * (v / V_STAR) - k * (v - V_STAR);
        if (a != 0.0) {
            const double bound = (a > 0.0 ? V_MAX - v : v) / fabs(a);
            if (bound < least) least = bound;
        }
        loop->a[i] = a;
        front = behind;
    }
    loop->T_max = least;
    loop->violations += !(least > T);
}

static void step(Loop *loop)
{
    double squares = loop->a[0] * loop->a[0], gaps = 0.0, moved_front = T * (loop->v[0] + 0.5 * T * loop->a[0]);
    const double dv = loop->v[0] - loop->v[N - 1], da = loop->a[0] - loop->a[N - 1];
    loop->x += moved_front;
    loop->v[0] += T * loop->a[0];
    for (int i = 1; i < N; i++) {
        const double moved = T * (loop->v[i] + 0.5 * T * loop->a[i]);
        squares += loop->a[i] * loop->a[i];
        gaps += loop->s[i - 1];
        loop->s[i - 1] += moved_front - moved;
        loop->v[i] += T * loop->a[i];
        moved_front = moved;
    }
    loop->of_acceleration += W1 / (A_REF * A_REF) * T * squares;
    loop->of_gaps += W2 / S_REF * (T * (gaps + T * (0.5 * dv + T / 6.0 * da)));
    feedback(loop);
}

static void put_out(const Loop *loop, double *out)
{
    double x = out[0] = loop->x;
    for (int i = 1; i < N; i++) out[i] = x -= loop->s[i - 1];
    memcpy(out + N, loop->v, sizeof loop->v);
    memcpy(out + 2 * N, loop->a, sizeof loop->a);
    memcpy(out + 3 * N, loop->s, sizeof loop->s);
    const double reports[] = {loop->alpha, loop->r, loop->p, out[MOTION + 3], loop->T_max, loop->T_max > T,
                              loop->violations, loop->of_acceleration + loop->of_gaps, loop->of_acceleration,
                              loop->of_gaps};
    memcpy(out + MOTION, reports, sizeof reports);
    memcpy(out + MOTION + REPORTS, loop->members, sizeof loop->members);
}

static void begin(Loop *loop, double gap)
{
    memset(loop, 0, sizeof *loop);
    loop->alpha = 1e-3, loop->r = 11.0, loop->p = 5.5;
    for (int i = 0; i < N; i++) loop->v[i] = 30.0 + 0.01 * (i % 7);
    for (int i = 0; i < N - 1; i++) loop->s[i] = gap + 0.05 * (i % 5);
    loop->members[0] = N;
    for (int i = 1; i <= N; i++) loop->members[i] = i;
    loop->members[N + 1] = 1.0;
    feedback(loop);
}

static void message(fmi2ComponentEnvironment e, fmi2String n, fmi2Status status, fmi2String c, fmi2String format, ...)
{
    va_list arguments;
    (void)e, (void)n, (void)status, (void)c;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void must(fmi2Status status)
{
    if (status == fmi2OK) return;
    fprintf(stderr, "a call gave status %d\n", (int)status);
    exit(3);
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

#define LOAD(name) fmi2##name##TYPE *name = (fmi2##name##TYPE *)dlsym(library, "fmi2" #name)

int main(int count, char **words)
{
    void *library = count > 11 ? dlopen(words[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library || atoi(words[4]) != OUTPUTS) return 1;
    LOAD(Instantiate);
    LOAD(SetupExperiment);
    LOAD(EnterInitializationMode);
    LOAD(ExitInitializationMode);
    LOAD(DoStep);
    LOAD(GetReal);
    LOAD(SetReal);
    LOAD(SetInteger);
    LOAD(Reset);
    const fmi2CallbackFunctions callbacks = {message, calloc, free, NULL, NULL};
    fmi2Component c = Instantiate("speed", fmi2CoSimulation, words[3], words[2], &callbacks, fmi2False, fmi2True);
    if (!c) return 2;
    static Loop loop;
    static double from_fmu[OUTPUTS], from_loop[OUTPUTS];
    fmi2ValueReference outputs[OUTPUTS], gaps[N], speeds[N], source = (fmi2ValueReference)atoi(words[8]);
    const fmi2Integer fixed = 2;
    const int steps = atoi(words[10]), repeats = atoi(words[11]);
    for (int i = 0; i < OUTPUTS; i++) outputs[i] = (fmi2ValueReference)(atoi(words[5]) + i);
    for (int i = 0; i < N; i++) gaps[i] = (fmi2ValueReference)(atoi(words[6]) + i);
    for (int i = 0; i < N; i++) speeds[i] = (fmi2ValueReference)(atoi(words[7]) + i);
    double best_fmu = INFINITY, best_loop = INFINITY, difference = 0.0;
    for (int k = 0; k < repeats; k++) {
        begin(&loop, atof(words[9]));
        must(Reset(c));
        must(SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
        must(SetInteger(c, &source, 1, &fixed));
        must(SetReal(c, gaps, N - 1, loop.s));
        must(SetReal(c, speeds, N, loop.v));
        must(EnterInitializationMode(c));
        must(ExitInitializationMode(c));
        double start = now();
        for (int i = 0; i < steps; i++) {
            must(DoStep(c, i * T, T, fmi2True));
            must(GetReal(c, outputs, OUTPUTS, from_fmu));
        }
        best_fmu = fmin(best_fmu, (now() - start) / steps);
        loop.on_hill = 0;
        start = now();
        for (int i = 0; i < steps; i++) {
            step(&loop);
            put_out(&loop, from_loop);
            __asm__ volatile("" : : "r"(from_loop) : "memory"); /* the host looks at the outputs of every step */
        }
        best_loop = fmin(best_loop, (now() - start) / steps);
        from_loop[MOTION + 3] = from_fmu[MOTION + 3];
        for (int i = 0; i < OUTPUTS; i++) difference = fmax(difference, fabs(from_fmu[i] - from_loop[i]));
    }
    printf("%.1f %.1f %.3g %.3f\n", best_fmu, best_loop, difference, (double)loop.on_hill / ((double)(N - 1) * steps));
    return 0;
}
