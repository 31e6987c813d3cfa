/* Many closed loops side by side: the period that CasADi wrote from psp_model, LANES rollouts at a time.
 *
 * The generated `step` stands above this text (engine.py puts both together).  It maps the state of one platoon
 * (n-1 spacings, n speeds) and the SHAPE parameters of its potential to the next state, then SUMS numbers that are added
 * up over the run, LOWS of which the smallest and HIGHS of which the largest counts.  It is inlined into the loop over
 * lanes, which the compiler turns into vector instructions.  The results of a rollout are these numbers and, if KEPT, the
 * final state.
 */
enum { STATE = 2 * VEHICLES - 1, LANES = 32, NUMBERS = SUMS + LOWS + HIGHS, RESULTS = NUMBERS + (KEPT ? STATE : 0) };

void rollouts(int count, int steps, const REAL *restrict starts, const int32_t *restrict which,
              const REAL *restrict shapes, REAL *restrict results)
{
    for (int first = 0; first < count; first += LANES) {
        REAL x[STATE][LANES], y[SHAPE][LANES], found[NUMBERS][LANES];
        for (int l = 0; l < LANES; l++) {
            int k = first + l < count ? first + l : count - 1;
            for (int j = 0; j < STATE; j++) x[j][l] = starts[which[k] * STATE + j];
            for (int j = 0; j < SHAPE; j++) y[j][l] = shapes[SHAPE * k + j];
            for (int j = 0; j < NUMBERS; j++) found[j][l] = j < SUMS ? 0 : j < SUMS + LOWS ? (REAL)1e30 : (REAL)-1e30;
        }
        for (int step = 0; step < steps; step++) {
#pragma omp simd
            for (int l = 0; l < LANES; l++) {
                REAL in[STATE], shape[SHAPE], out[STATE + NUMBERS];
                const REAL *arg[2] = {in, shape};
                REAL *res[1] = {out};
                for (int j = 0; j < STATE; j++) in[j] = x[j][l];
                for (int j = 0; j < SHAPE; j++) shape[j] = y[j][l];
                step_f0(arg, res, 0, 0, 0);
                for (int j = 0; j < STATE; j++) x[j][l] = out[j];
                for (int j = 0; j < NUMBERS; j++) {
                    const REAL one = out[STATE + j], old = found[j][l];
                    found[j][l] = j < SUMS ? old + one : j < SUMS + LOWS ? (one < old ? one : old) : one > old ? one : old;
                }
            }
        }
        for (int l = 0; l < LANES && first + l < count; l++) {
            REAL *result = results + (size_t)(first + l) * RESULTS;
            for (int j = 0; j < NUMBERS; j++) result[j] = found[j][l];
            for (int j = 0; KEPT && j < STATE; j++) result[NUMBERS + j] = x[j][l];
        }
    }
}
