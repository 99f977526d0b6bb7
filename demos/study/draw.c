/* The inputs of trials. A draw is a function of seed, trial and place, without any state, so that a trial is the same
 * whichever trials ran before it. */
#include "study.h"

#include <math.h>
#include <stdlib.h>

/* The finalizer of SplitMix64 (Steele, Lea and Flood 2014), which turns counters into random bits. */
static uint64_t mixed(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* The middle of one of 2^53 equal parts of (0, 1). */
static double fraction(uint64_t bits)
{
    return ((double)(bits >> 11) + 0.5) * 0x1p-53;
}

/* ---- The Sobol sequence. ---- */

/* Primitive polynomials and initial direction numbers of Joe and Kuo (2008), for the second dimension on. */
typedef struct sobol_polynomial {
    unsigned degree, coefficients, first[7];
} sobol_polynomial;

static const sobol_polynomial polynomials[STUDY_MOST_SOBOL - 1] = {
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
    {6, 19, {1, 1, 1, 15, 7, 5}},
    {6, 22, {1, 3, 1, 15, 13, 25}},
    {6, 25, {1, 1, 5, 5, 19, 61}},
    {7, 1, {1, 3, 7, 11, 23, 15, 103}},
    {7, 4, {1, 3, 7, 13, 13, 15, 69}},
};

enum { SOBOL_BITS = 32 };

/* The direction numbers v_1, v_2, ... of a dimension. */
static void sobol_directions(size_t dimension, uint32_t v[SOBOL_BITS])
{
    for (unsigned i = 0; i < SOBOL_BITS; i++) {
        v[i] = (uint32_t)1 << (SOBOL_BITS - 1 - i);
        if (dimension == 0) continue;
        const sobol_polynomial *p = &polynomials[dimension - 1];
        if (i < p->degree) {
            v[i] *= p->first[i];
            continue;
        }
        v[i] = v[i - p->degree] ^ (v[i - p->degree] >> p->degree);
        for (unsigned k = 1; k < p->degree; k++)
            if ((p->coefficients >> (p->degree - 1 - k)) & 1) v[i] ^= v[i - k];
    }
}

/* A digital shift by random bits keeps the even filling, and makes sequences of different seeds independent. */
double study_sobol(uint64_t seed, long index, size_t dimension)
{
    uint32_t v[SOBOL_BITS], bits = (uint32_t)(mixed(mixed(seed) ^ dimension) >> 32);
    sobol_directions(dimension, v);
    for (unsigned i = 0; i < SOBOL_BITS; i++)
        if (((unsigned long)index >> i) & 1) bits ^= v[i];
    return ((double)bits + 0.5) * 0x1p-32;
}

/* ---- Distributions. ---- */

static double draw_number(const study *s, long index, size_t draw)
{
    if (s->design == STUDY_SOBOL) return study_sobol(s->seed, index, draw);
    return fraction(mixed(mixed(mixed(s->seed) ^ (uint64_t)index) ^ draw));
}

static double normal_probability(double x)
{
    return 0.5 * erfc(-x / sqrt(2.0));
}

/* The standard normal quantile, by bisection between two bounds that no double probability is beyond; then Newton's
 * method, which ends at rounding. Probabilities above one half are mirrored, so that they lose no digits. */
static double normal_quantile(double p)
{
    if (p > 0.5) return -normal_quantile(1.0 - p);
    double low = -38.0, high = 0.0;
    for (int i = 0; i < 30; i++) {
        double middle = 0.5 * (low + high);
        *(normal_probability(middle) < p ? &low : &high) = middle;
    }
    double x = 0.5 * (low + high);
    for (int i = 0; i < 2; i++) {
        double density = exp(-0.5 * x * x) * 0.3989422804014327;
        if (density > 0.0) x -= (normal_probability(x) - p) / density;
    }
    return x;
}

static double cut_normal(const study_variation *v, double u)
{
    double low = normal_probability((v->at_least - v->low) / v->high);
    double high = normal_probability((v->at_most - v->low) / v->high);
    double x = v->low + v->high * normal_quantile(low + u * (high - low));
    return fmin(fmax(x, v->at_least), v->at_most);
}

static size_t choice(double u, size_t count)
{
    size_t i = (size_t)(u * (double)count);
    return i < count ? i : count - 1;
}

static json_t *cells_of(const study *s, const study_variation *v, size_t row)
{
    const double *cells = s->table.cells + row * s->table.column_count;
    if (v->column_count == 1) return json_real(cells[v->columns[0]]);
    json_t *list = json_array();
    for (size_t i = 0; i < v->column_count; i++) {
        if (json_array_append_new(list, json_real(cells[v->columns[i]])) == 0) continue;
        json_decref(list);
        return NULL;
    }
    return list;
}

static json_t *draw_value(const study *s, const study_variation *v, double u, size_t row)
{
    switch (v->type) {
    case STUDY_UNIFORM:
        return json_real(v->low + u * (v->high - v->low));
    case STUDY_LOG_UNIFORM:
        return json_real(v->low * exp(u * log(v->high / v->low)));
    case STUDY_NORMAL:
        return json_real(cut_normal(v, u));
    case STUDY_VALUES:
        return json_deep_copy(json_array_get(v->values, choice(u, json_array_size(v->values))));
    default:
        return cells_of(s, v, row);
    }
}

/* ---- Designs. ---- */

/* The trial's place in the grid: its index as a number whose digits are the choices, the last one counting fastest. The
 * table's rows are one more choice, the slowest. */
static size_t grid_digit(long *rest, size_t count)
{
    size_t digit = (size_t)*rest % count;
    *rest /= (long)count;
    return digit;
}

/* A trial without one of its inputs would be another trial. Returns false when memory ran out, without the inputs. */
static bool add_input(json_t **inputs, const char *place, json_t *value)
{
    if (json_object_set_new(*inputs, place, value) == 0) return true;
    json_decref(*inputs);
    *inputs = NULL;
    return false;
}

static json_t *draw_grid(const study *s, long index)
{
    size_t *digits = calloc(s->draw_count + 1, sizeof *digits);
    if (!digits) return NULL;
    json_t *inputs = json_object();
    for (size_t i = s->variation_count; i-- > 0;) {
        const study_variation *v = &s->variations[i];
        size_t draws = v->type == STUDY_COLUMNS ? 0 : v->common ? 1 : v->place_count;
        for (size_t k = draws; k-- > 0;) digits[v->first_draw + k] = grid_digit(&index, json_array_size(v->values));
    }
    for (size_t i = 0; i < s->variation_count; i++) {
        const study_variation *v = &s->variations[i];
        for (size_t k = 0; k < v->place_count && inputs; k++) {
            json_t *value =
                v->type == STUDY_COLUMNS
                    ? cells_of(s, v, (size_t)index)
                    : json_deep_copy(json_array_get(v->values, digits[v->first_draw + (v->common ? 0 : k)]));
            (void)add_input(&inputs, v->places[k], value);
        }
    }
    free(digits);
    return inputs;
}

json_t *study_draw(const study *s, long index)
{
    if (s->design == STUDY_GRID) return draw_grid(s, index);
    json_t *inputs = json_object();
    size_t row = 0;
    if (s->design == STUDY_TABLE)
        row = (size_t)index;
    else if (s->table.row_count > 0)
        row = choice(draw_number(s, index, s->row_draw), s->table.row_count);
    for (size_t i = 0; i < s->variation_count; i++) {
        const study_variation *v = &s->variations[i];
        for (size_t k = 0; k < v->place_count; k++) {
            double u = draw_number(s, index, v->first_draw + (v->common ? 0 : k));
            if (!add_input(&inputs, v->places[k], draw_value(s, v, u, row))) return NULL;
        }
    }
    return inputs;
}
