/* The floor: a step of the platoon and its outputs in a hand-written loop for N vehicles, N known to the compiler.
 *
 * step_loop GAP       protocol and start as in step_host.c; 0 is answered with x, v, a, s, T_max and J's two terms.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { STEPS = 50, MOTION = 4 * N - 1, REPORTS = 10, MEMBERS = N + 5, OUTPUTS = MOTION + REPORTS + MEMBERS };

static const double L = 5.0, LAMBDA = 20.0, V_STAR = 30.0, V_MAX = 35.0, EPSILON = 0.2, MU = 0.5;
static const double T = 0.01, W1 = 0.5, W2 = 0.5, A_REF = 4.0, S_REF = 20.0;

typedef struct {
    double alpha, r, p, x, s[N - 1], v[N], a[N], T_max, of_acceleration, of_spacings, violations;
    double members[MEMBERS]; /* how many vehicles, their numbers, and what became of changes: nothing */
} Loop;

static double slope(const Loop *loop, double s)
{
    const double d = s - L, e = s < LAMBDA ? LAMBDA - s : 0.0, near = e / d, t = s - loop->r, q = (3.0 - t) * t;
    const double base = loop->alpha * (e * near * (3.0 + near));
    if (!(q > 0.0)) return -base;
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
    double squares = loop->a[0] * loop->a[0], spacings = 0.0, moved_front = T * (loop->v[0] + 0.5 * T * loop->a[0]);
    const double dv = loop->v[0] - loop->v[N - 1], da = loop->a[0] - loop->a[N - 1];
    loop->x += moved_front;
    loop->v[0] += T * loop->a[0];
    for (int i = 1; i < N; i++) {
        const double moved = T * (loop->v[i] + 0.5 * T * loop->a[i]);
        squares += loop->a[i] * loop->a[i];
        spacings += loop->s[i - 1];
        loop->s[i - 1] += moved_front - moved;
        loop->v[i] += T * loop->a[i];
        moved_front = moved;
    }
    loop->of_acceleration += W1 / (A_REF * A_REF) * T * squares;
    loop->of_spacings += W2 / S_REF * (T * (spacings + T * (0.5 * dv + T / 6.0 * da)));
    feedback(loop);
}

static void put_out(const Loop *loop, double *out)
{
    double x = out[0] = loop->x;
    for (int i = 1; i < N; i++) out[i] = x -= loop->s[i - 1];
    memcpy(out + N, loop->v, sizeof loop->v);
    memcpy(out + 2 * N, loop->a, sizeof loop->a);
    memcpy(out + 3 * N, loop->s, sizeof loop->s);
    const double reports[] = {loop->T_max, loop->of_acceleration, loop->of_spacings, loop->alpha, loop->r, loop->p,
                              loop->T_max > T, loop->violations, loop->of_acceleration + loop->of_spacings, 0.0};
    memcpy(out + MOTION, reports, sizeof reports);
    memcpy(out + MOTION + REPORTS, loop->members, sizeof loop->members);
}

static void begin(Loop *loop, double spacing)
{
    memset(loop, 0, sizeof *loop);
    loop->alpha = 1e-3, loop->r = 11.0, loop->p = 5.5;
    for (int i = 0; i < N; i++) loop->v[i] = 30.0 + 0.01 * (i % 7);
    for (int i = 0; i < N - 1; i++) loop->s[i] = spacing + 0.05 * (i % 5);
    loop->members[0] = N;
    for (int i = 1; i <= N; i++) loop->members[i] = i;
    loop->members[N + 1] = 1.0;
    feedback(loop);
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int main(int count, char **words)
{
    static Loop loop;
    static double out[OUTPUTS];
    if (count < 2) return 1;
    puts("ready");
    fflush(stdout);
    for (int segments; scanf("%d", &segments) == 1;) {
        double seconds = 0.0;
        for (int k = 0; k < segments || k == 0; k++) {
            begin(&loop, atof(words[1]));
            const double start = now();
            for (int i = 0; i < STEPS; i++) {
                step(&loop);
                put_out(&loop, out);
                __asm__ volatile("" : : "r"(out) : "memory"); /* the host looks at the outputs of every step */
            }
            seconds += now() - start;
        }
        if (segments > 0) printf("%.9g %d", seconds / segments / STEPS, STEPS);
        for (int i = 0; segments == 0 && i < MOTION + 3; i++) printf("%.17g ", out[i]);
        putchar('\n');
        fflush(stdout);
    }
    return 0;
}
