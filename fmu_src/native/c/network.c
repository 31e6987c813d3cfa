/* The networks: layers over the tables in psp_network.h, which come from the ONNX files; mirrors
 * psp_model/selection/network.py. */
#include "vehicles.h"

#include <stddef.h>
#include <stdlib.h>

#include "psp_network.h"

#if PSP_NETWORK
/* y = W x + b, then max(y, 0) where the layer says so; both vectors have room for PSP_WIDEST numbers.
 * Products are added one after the other with a single rounding each, as onnxruntime does on processors with fused
 * multiply-add: the products are exact in double precision.  So both FMUs get the same floats. */
static void apply(const PspLayer *layer, const float *input, float *output)
{
    for (int row = 0; row < layer->rows; row++) {
        const float *weights = layer->weights + (size_t)row * (size_t)layer->columns;
        float sum = 0.0f;
        for (int column = 0; column < layer->columns; column++)
            sum = (float)((double)sum + (double)weights[column] * (double)input[column]);
        sum += layer->bias[row];
        output[row] = layer->relu && !(sum > 0.0f) ? 0.0f : sum;
    }
}

/* Runs layers over what stands in buffer[0] and gives their output, in one of the two. */
static const float *run(const PspLayer *layers, int count, float buffer[2][PSP_WIDEST])
{
    for (int k = 0; k < count; k++) apply(&layers[k], buffer[k % 2], buffer[1 - k % 2]);
    return buffer[count % 2];
}

/* What the layers shared by all spacings see of spacing i: length, speed in front, speed behind and 1 of it and its neighbours;
 * zeros where the platoon has ended. */
static void window(int radius, int spacings, int i, const double *s, const double *v, float *channels)
{
    for (int j = i - radius; j <= i + radius; j++, channels += 4) {
        const bool there = j >= 0 && j < spacings;
        channels[0] = there ? (float)s[j] : 0.0f;
        channels[1] = there ? (float)v[j] : 0.0f;
        channels[2] = there ? (float)v[j + 1] : 0.0f;
        channels[3] = there ? 1.0f : 0.0f;
    }
}

/* Mean and maximum over the spacings of what the shared layers give, into `pooled`. */
static void pool(const PspChain *chain, int spacings, const double *s, const double *v, float *pooled)
{
    float buffer[2][PSP_WIDEST];
    const int width = chain->layers[chain->shared - 1].rows;
    for (int i = 0; i < spacings; i++) {
        window(chain->radius, spacings, i, s, v, buffer[0]);
        const float *seen = run(chain->layers, chain->shared, buffer);
        for (int k = 0; k < width; k++) {
            pooled[k] = i == 0 ? seen[k] : pooled[k] + seen[k];
            pooled[width + k] = i == 0 || seen[k] > pooled[width + k] ? seen[k] : pooled[width + k];
        }
    }
    for (int k = 0; k < width; k++) pooled[k] /= (float)spacings;
}

static const float *answer(const PspChain *chain, int n, const double *s, const double *v, float buffer[2][PSP_WIDEST])
{
    if (chain->shared) {
        pool(chain, n - 1, s, v, buffer[0]);
    } else {
        for (int i = 0; i < n - 1; i++) buffer[0][i] = (float)s[i];
        for (int i = 0; i < n; i++) buffer[0][n - 1 + i] = (float)v[i];
    }
    return run(chain->layers + chain->shared, chain->count - chain->shared, buffer);
}

static Shape triple(const float *row)
{
    const Shape shape = {(double)row[0], (double)row[1], (double)row[2], 1.0};
    return shape;
}

/* Puts the rows of the dictionary with the highest scores into `best`; of equal scores the first row wins. */
static int ranked(const PspNetwork *network, const float *scores, int count, Shape *best)
{
    bool taken[PSP_MOST_CANDIDATES] = {false};
    int found = 0;
    for (; found < count && found < network->candidate_count; found++) {
        int top = -1;
        for (int k = 0; k < network->candidate_count; k++) {
            if (!taken[k] && (top < 0 || scores[k] > scores[top])) top = k;
        }
        taken[top] = true;
        best[found] = triple(network->candidates[top]);
    }
    return found;
}

/* The network for n vehicles, NULL if there is none. */
static const PspNetwork *find(int n)
{
    const int known = (int)(sizeof PSP_NETWORK_OF / sizeof *PSP_NETWORK_OF);
    return n >= 0 && n < known ? PSP_NETWORK_OF[n] : NULL;
}

bool network_for(int n) { return find(n) != NULL; }

int network_candidates(int n, const double *s, const double *v, int count, Shape *candidates)
{
    float buffer[2][PSP_WIDEST];
    const PspNetwork *network = find(n);
    if (!network) return 0;
    candidates[0] = triple(answer(&network->parameters, n, s, v, buffer));
    if (count <= 1 || network->candidate_count == 0) return 1;
    return 1 + ranked(network, answer(&network->scores, n, s, v, buffer), count - 1, candidates + 1);
}

const char *outside_domain(int n, const double *s, const double *v, const Constants *c)
{
    const PspNetwork *network = find(n);
    if (!network) return "no network";
    const Constants *trained = &network->trained;
#define OR_DIFFERS(field, variable, unit) || c->field != trained->field
    if (false PSP_CONSTANTS_FIELDS(OR_DIFFERS))
        return "other constants than the network was trained with";
    bool inside = true;
    for (int i = 0; i < n; i++) inside = inside && v[i] >= network->speed_min && v[i] <= network->speed_max;
    for (int i = 0; i < n - 1; i++)
        inside = inside && s[i] >= network->gap_min && s[i] <= network->gap_max &&
                 s[i] > network->standstill + network->headway * v[i + 1];
    return inside ? NULL : "spacings or speeds outside the network's training domain";
}

bool lies_in_domain(int n, const double *s, const double *v, const Constants *constants)
{
    return network_for(n) && !outside_domain(n, s, v, constants);
}

#else
bool lies_in_domain(int n, const double *s, const double *v, const Constants *constants)
{
    (void)n, (void)s, (void)v, (void)constants;
    return false;
}

bool network_for(int n)
{
    (void)n;
    return false;
}

int network_candidates(int n, const double *s, const double *v, int count, Shape *candidates)
{
    (void)n, (void)s, (void)v, (void)count, (void)candidates;
    return 0;
}

const char *outside_domain(int n, const double *s, const double *v, const Constants *constants)
{
    (void)n, (void)s, (void)v, (void)constants;
    return "no network";
}
#endif
