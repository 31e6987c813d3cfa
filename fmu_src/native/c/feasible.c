/* The feasible set of (alpha, r, p), and the way into it: mirrors psp_model/selection/feasible.py. */
#include "vehicles.h"

#include <math.h>
#include <stdlib.h>

#include "psp_kernels.h"

#define HILL_WIDTH 3.0
#define SLOPE_ERROR 1e-9
#define P_ERROR 0x1p-40
#define ALPHA_ERROR 1e-9
#define PROBES 33
enum { FIRST_CELLS = 64, CHILDREN = 8, MOST_CELLS = 1 << 16 };

typedef struct {
    double begin, end, upper;
} Cell;

/* Growing array of cells; a failed allocation leaves `failed` set. */
typedef struct {
    Cell *cells;
    size_t count, capacity;
    bool failed;
} Cells;

static void add_cell(Cells *list, double begin, double end)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity ? 2 * list->capacity : 256;
        Cell *grown = realloc(list->cells, capacity * sizeof *grown);
        if (!grown) {
            list->failed = true;
            return;
        }
        list->cells = grown;
        list->capacity = capacity;
    }
    list->cells[list->count++] = (Cell){begin, end, 0.0};
}

/* Bounds every cell; the larger of `best` and of the slopes at their ends. */
static double bound_cells(Cells *list, const Shape *h, const Constants *c, double best)
{
    double peak = -INFINITY;
    for (size_t k = 0; k < list->count; k++) {
        double lower;
        Cell *cell = &list->cells[k];
        psp_cell_bound(cell->begin, cell->end, h->alpha, h->r, h->p, h->hill, c->L, c->lam, &lower, &cell->upper);
        if (!(lower <= peak)) peak = lower; /* a NaN stays, as with NumPy's max */
    }
    return peak > best ? peak : best;
}

static void split_undecided(const Cells *from, Cells *to, double best)
{
    const double floor_ = best + fmax(SLOPE_ERROR, 1e-12 * best);
    to->count = 0;
    for (size_t k = 0; k < from->count; k++) {
        const Cell cell = from->cells[k];
        if (!(cell.upper > floor_) || !(cell.end > nextafter(cell.begin, INFINITY))) continue;
        const double step = (cell.end - cell.begin) / CHILDREN;
        double begin = cell.begin;
        for (int i = 1; i <= CHILDREN; i++) {
            const double end = i == CHILDREN ? cell.end : i * step + cell.begin;
            add_cell(to, begin, end);
            begin = end;
        }
    }
}

/* max |V_new'| on the hill, or some slope above `enough`; NaN when there is no memory for the search. */
static double max_slope(const Shape *shape, const Constants *constants, double enough)
{
    Cells lists[2] = {{NULL, 0, 0, false}, {NULL, 0, 0, false}};
    double best = 0.0, begin = shape->r;
    for (int i = 1; i <= FIRST_CELLS; i++) {
        const double end = shape->r + (i == FIRST_CELLS ? HILL_WIDTH : i * (HILL_WIDTH / FIRST_CELLS));
        add_cell(&lists[0], begin, end);
        begin = end;
    }
    for (int now = 0; lists[now].count > 0; now = 1 - now) {
        best = bound_cells(&lists[now], shape, constants, best);
        if (best > enough) break;
        split_undecided(&lists[now], &lists[1 - now], best);
        if (lists[1 - now].count > (size_t)MOST_CELLS * CHILDREN) { /* the bound overflows, so nothing is ever decided */
            best = INFINITY;
            break;
        }
    }
    const bool failed = lists[0].failed || lists[1].failed;
    free(lists[0].cells);
    free(lists[1].cells);
    return failed ? NAN : best;
}

static bool within_limit(const Shape *shape, const Constants *constants)
{
    return max_slope(shape, constants, constants->z) <= constants->z;
}

bool require_feasible(Front *front, const Shape *shape, const Constants *constants)
{
    if (!(PSP_ALPHA_MIN <= shape->alpha && shape->alpha <= PSP_ALPHA_MAX)) {
        front_log(front, fmi2Error, PSP_SENTENCE_alpha, shape->alpha, PSP_ALPHA_MIN, PSP_ALPHA_MAX);
        return false;
    }
    if (!(constants->L < shape->r && shape->r <= constants->lam - HILL_WIDTH)) {
        front_log(front, fmi2Error, PSP_SENTENCE_r, shape->r, constants->L, constants->lam - HILL_WIDTH);
        return false;
    }
    if (!(PSP_P_MIN <= shape->p && shape->p <= PSP_P_MAX)) {
        front_log(front, fmi2Error, PSP_SENTENCE_p, shape->p, PSP_P_MIN, PSP_P_MAX);
        return false;
    }
    const double slope = max_slope(shape, constants, INFINITY);
    if (slope <= constants->z) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_slope, slope, shape->alpha, shape->r, shape->p, constants->z);
    return false;
}

/* Bisects the field at `field` of `shape`, which is feasible with `inside` and not with `outside`. */
static void last_feasible(Shape *shape, double *field, double inside, double outside, const Constants *constants)
{
    while (fabs(outside - inside) > P_ERROR) {
        *field = 0.5 * (inside + outside);
        if (within_limit(shape, constants)) inside = *field;
        else outside = *field;
    }
    *field = inside;
}

static double clip(double value, double low, double high) { return fmin(fmax(value, low), high); }

/* With p = 3 too steep: raises r as far as needed; false if no r will do. */
static bool raise_r(Shape *shape, double r_max, const Constants *constants)
{
    const double first = shape->r, step = (r_max - first) / (PROBES - 1);
    for (int i = 1; i < PROBES; i++) {
        const double probe = i == PROBES - 1 ? r_max : i * step + first;
        shape->r = probe;
        if (!within_limit(shape, constants)) continue;
        last_feasible(shape, &shape->r, probe, first, constants);
        return true;
    }
    shape->r = first;
    return false;
}

/* Gives `shape` the alpha of least max |V'|, which is convex in alpha as V' is linear in it: thirds are cut off. */
static void flatten(Shape *shape, const Constants *constants)
{
    double low = PSP_ALPHA_MIN, high = PSP_ALPHA_MAX;
    while (high - low > ALPHA_ERROR) {
        const double third = (high - low) / 3.0;
        Shape one = *shape, other = *shape;
        one.alpha = low + third;
        other.alpha = high - third;
        if (max_slope(&one, constants, INFINITY) < max_slope(&other, constants, INFINITY)) high = other.alpha;
        else low = one.alpha;
    }
    shape->alpha = 0.5 * (low + high);
}

bool project(Front *front, Shape *shape, const Constants *constants)
{
    const double r_max = constants->lam - HILL_WIDTH;
    shape->alpha = clip(shape->alpha, PSP_ALPHA_MIN, PSP_ALPHA_MAX);
    shape->r = clip(shape->r, nextafter(constants->L, INFINITY), r_max);
    shape->p = clip(shape->p, PSP_P_MIN, PSP_P_MAX);
    if (within_limit(shape, constants)) return true;
    const double p = shape->p;
    shape->p = PSP_P_MIN;
    if (within_limit(shape, constants)) {
        last_feasible(shape, &shape->p, PSP_P_MIN, p, constants);
        return true;
    }
    if (raise_r(shape, r_max, constants)) return true;
    shape->alpha = PSP_ALPHA_MIN;
    if (raise_r(shape, r_max, constants)) return true;
    shape->r = r_max;
    flatten(shape, constants);
    if (within_limit(shape, constants)) return true;
    front_log(front, fmi2Error, PSP_SENTENCE_empty, constants->z);
    return false;
}
