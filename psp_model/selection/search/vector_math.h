/* x^y for floats as 2^(y log2 x), with Cephes' polynomials (Moshier; public domain) for logf and exp2f.
 *
 * No call, no branch: compilers turn loops over it into vector instructions.  Good to about 1e-6 for the model's
 * bases (0 < x <= 2.25) and exponents (2 to 8).
 */
typedef union { float value; int32_t bits; } word;

static inline float fast_log2(float x)
{
    word m = {x};
    int32_t exponent = (m.bits - 0x3f3504f3) >> 23; /* leaves the mantissa in [sqrt(1/2), sqrt(2)) */
    m.bits -= exponent << 23;
    float t = m.value - 1.0f, t2 = t * t;
    float q = 7.0376836292e-2f;
    q = q * t - 1.1514610310e-1f;
    q = q * t + 1.1676998740e-1f;
    q = q * t - 1.2420140846e-1f;
    q = q * t + 1.4249322787e-1f;
    q = q * t - 1.6668057665e-1f;
    q = q * t + 2.0000714765e-1f;
    q = q * t - 2.4999993993e-1f;
    q = q * t + 3.3333331174e-1f;
    return (t + (q * t * t2 - 0.5f * t2)) * 1.44269504089f + (float)exponent;
}

static inline float fast_exp2(float x)
{
    x = x < -126.0f ? -126.0f : x > 126.0f ? 126.0f : x;
    float whole = __builtin_rintf(x), t = x - whole;
    float y = 1.535336188319500e-4f;
    y = y * t + 1.339887440266574e-3f;
    y = y * t + 9.618437357674640e-3f;
    y = y * t + 5.550332471162809e-2f;
    y = y * t + 2.402264791363012e-1f;
    y = y * t + 6.931472028550421e-1f;
    y = y * t + 1.0f;
    word result = {y};
    result.bits += (int32_t)whole << 23;
    return result.value;
}

#define pow(x, y) fast_exp2((y) * fast_log2(x))
#define fmax(x, y) ((x) > (y) ? (x) : (y))
#define fmin(x, y) ((x) < (y) ? (x) : (y))
