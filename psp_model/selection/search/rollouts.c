/* Many closed loops side by side: the step that CasADi wrote from psp_model, LANES rollouts at a time.
 *
 * The generated `step` stands above this text (engine.py puts both together).  It maps the state of one platoon
 * (n-1 gaps, n speeds) and (alpha, r, p) to the next state, what the period adds to J, and T_max.  It is inlined into
 * the loop over lanes, which the compiler turns into vector instructions.
 */
enum { STATE = 2 * VEHICLES - 1, LANES = 32 };

void rollouts(int count, int steps, const REAL *restrict starts, const int32_t *restrict which,
              const REAL *restrict shapes, REAL *restrict costs, REAL *restrict periods)
{
    for (int first = 0; first < count; first += LANES) {
        REAL x[STATE][LANES], y[3][LANES], cost[LANES], period[LANES];
        for (int l = 0; l < LANES; l++) {
            int k = first + l < count ? first + l : count - 1;
            for (int j = 0; j < STATE; j++) x[j][l] = starts[which[k] * STATE + j];
            for (int j = 0; j < 3; j++) y[j][l] = shapes[3 * k + j];
            cost[l] = 0;
            period[l] = (REAL)1e30;
        }
        for (int step = 0; step < steps; step++) {
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                REAL in[STATE], shape[3], out[STATE + 2];
                const REAL *arg[2] = {in, shape};
                REAL *res[1] = {out};
                for (int j = 0; j < STATE; j++) in[j] = x[j][l];
                for (int j = 0; j < 3; j++) shape[j] = y[j][l];
                step_f0(arg, res, 0, 0, 0);
                for (int j = 0; j < STATE; j++) x[j][l] = out[j];
                cost[l] += out[STATE];
                period[l] = out[STATE + 1] < period[l] ? out[STATE + 1] : period[l];
            }
        }
        for (int l = 0; l < LANES && first + l < count; l++) {
            costs[first + l] = cost[l];
            periods[first + l] = period[l];
        }
    }
}
