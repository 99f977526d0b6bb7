#include "nonsmooth/velocity_system.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

void pinch_element_velocity(const pinch_element *element, const double *x, double *w)
{
    for (int row = 0; row < element->law.rows; row++) w[row] = element->w0[row];
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *block = &element->block[b];
        for (int row = 0; row < element->law.rows && block->size; row++)
            w[row] += dot(block->g + row * block->size, x + block->first, block->size);
    }
}

double pinch_element_multiplier(const pinch_velocity_system *vs, const pinch_element *element, const double *x)
{
    return x[element->multiplier] / (vs->step * element->law.g[0]);
}

/* y - (w - c) / sigma: what the bounds clamp */
static double multiplier_trial(const pinch_element *element, const double *x)
{
    double w;
    pinch_element_velocity(element, x, &w);
    return x[element->multiplier] - (w - element->target);
}

static double clamp(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

void pinch_element_add_impulse(const pinch_velocity_system *vs, const pinch_element *element, const double *x,
                               double sign, double *f)
{
    for (int row = 0; row < element->law.rows; row++) {
        double impulse = sign * (element->multiplier >= 0 ? x[element->multiplier] : vs->step * element->r[row]);
        if (impulse == 0) continue;
        for (int b = 0; b < 2; b++) {
            const pinch_element_block *block = &element->block[b];
            const double *g = block->g + row * block->size;
            for (int k = 0; k < block->size; k++) f[block->first + k] += impulse * g[k];
        }
    }
}

/* The impulses that act at x, as magnitudes: what F is measured against. */
static void set_scale(pinch_velocity_system *vs, const double *x)
{
    double sum = 0;
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        for (int row = 0; row < element->law.rows; row++) {
            double impulse = fabs(element->multiplier >= 0 ? x[element->multiplier] : vs->step * element->r[row]);
            for (int b = 0; b < 2; b++)
                for (int k = 0; k < element->block[b].size; k++)
                    vs->size[element->block[b].first + k] +=
                        impulse * fabs(element->block[b].g[row * element->block[b].size + k]);
        }
    }
    for (int i = 0; i < vs->freedoms; i++) {
        double size = vs->size[i] + fabs(vs->drive[i]);
        sum += size * size;
    }
    vs->scale = sum > 0 ? sqrt(sum) : 1;
}

static void evaluate_element(pinch_element *element, const double *x, double *tangent)
{
    double w[4];
    pinch_element_velocity(element, x, w);
    element->state = pinch_law_evaluate(&element->law, w, element->r, tangent);
}

static void residual(void *self, const double *x, double *f)
{
    pinch_velocity_system *vs = self;
    for (int i = 0; i < vs->freedoms; i++) f[i] = vs->inertia[i] * x[i] - vs->drive[i];
    for (int e = 0; e < vs->element_count; e++) {
        pinch_element *element = &vs->elements[e];
        if (element->multiplier >= 0)
            f[element->multiplier] =
                x[element->multiplier] - clamp(multiplier_trial(element, x), element->bound_low, element->bound_high);
        else
            evaluate_element(element, x, NULL);
        pinch_element_add_impulse(vs, element, x, -1, f);
    }
    if (vs->scale == 0) set_scale(vs, x);
    double over = 1 / vs->scale;
    for (int i = 0; i < vs->unknowns; i++) f[i] *= over;
}

static double residual_row(void *self, const double *x, int row)
{
    pinch_velocity_system *vs = self;
    if (row >= vs->freedoms) {
        for (int e = 0; e < vs->element_count; e++) {
            const pinch_element *element = &vs->elements[e];
            if (element->multiplier == row)
                return (x[row] - clamp(multiplier_trial(element, x), element->bound_low, element->bound_high)) /
                       vs->scale;
        }
    }
    double f = vs->inertia[row] * x[row] - vs->drive[row];
    int cluster = vs->cluster_of_unknown[row];
    for (int t = vs->touching_start[cluster]; t < vs->touching_start[cluster + 1]; t++) {
        pinch_element *element = &vs->elements[vs->touching[t]];
        if (element->multiplier < 0) evaluate_element(element, x, NULL);
        for (int b = 0; b < 2; b++) {
            const pinch_element_block *block = &element->block[b];
            int k = row - block->first;
            if (k < 0 || k >= block->size) continue;
            for (int i = 0; i < element->law.rows; i++) {
                double impulse = element->multiplier >= 0 ? x[element->multiplier] : vs->step * element->r[i];
                f -= impulse * block->g[i * block->size + k];
            }
        }
    }
    return f / vs->scale;
}

/* jacobian += h G_e^T D_e G_e for an explicit force */
static void add_force_block(const pinch_velocity_system *vs, const pinch_element *element)
{
    int rows = element->law.rows, n = vs->unknowns;
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *right = &element->block[b];
        for (int col = 0; col < right->size; col++) {
            double dg[4] = {0, 0, 0, 0}; /* h D g_col */
            for (int i = 0; i < rows; i++)
                for (int j = 0; j < rows; j++)
                    dg[i] += vs->step * element->tangent[i * rows + j] * right->g[j * right->size + col];
            for (int a = 0; a < 2; a++) {
                const pinch_element_block *left = &element->block[a];
                double *column = vs->jacobian + (size_t)left->first * (size_t)n + right->first + col;
                for (int row = 0; row < left->size; row++) {
                    double sum = 0;
                    for (int i = 0; i < rows; i++) sum += left->g[i * left->size + row] * dg[i];
                    column[(size_t)row * (size_t)n] += sum;
                }
            }
        }
    }
}

/* the row and column of a multiplier: inside its bounds F_y = w - c, at a bound F_y = y - bound */
static void add_multiplier_block(const pinch_velocity_system *vs, const pinch_element *element)
{
    size_t n = (size_t)vs->unknowns, y = (size_t)element->multiplier;
    if (!element->inside) vs->jacobian[y * n + y] = 1;
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *block = &element->block[b];
        for (int k = 0; k < block->size; k++) {
            size_t q = (size_t)(block->first + k);
            vs->jacobian[q * n + y] -= block->g[k];
            if (element->inside) vs->jacobian[y * n + q] += block->g[k];
        }
    }
}

/* A drive all of whose contacts are open at x feels no force there and would have a zero row: let it feel the force
 * that the contacts' trial law would give, which leads it back to them. */
static void close_idle_drives(pinch_velocity_system *vs)
{
    for (int c = 0; c < vs->mobility->cluster_count; c++) {
        if (vs->mobility->clusters[c].inertia != 0) continue;
        bool idle = true;
        for (int t = vs->touching_start[c]; t < vs->touching_start[c + 1]; t++)
            idle = idle && vs->elements[vs->touching[t]].tangent[0] == 0;
        for (int t = vs->touching_start[c]; idle && t < vs->touching_start[c + 1]; t++) {
            pinch_element *element = &vs->elements[vs->touching[t]];
            element->tangent[0] = element->law.g[0];
        }
    }
}

static void linearize(void *self, const double *x)
{
    pinch_velocity_system *vs = self;
    size_t n = (size_t)vs->unknowns;
    double over = 1 / vs->scale;
    memset(vs->jacobian, 0, n * n * sizeof(double));
    for (int i = 0; i < vs->freedoms; i++) vs->jacobian[(size_t)i * (n + 1)] = vs->inertia[i];
    for (int e = 0; e < vs->element_count; e++) {
        pinch_element *element = &vs->elements[e];
        if (element->multiplier >= 0) {
            double trial = multiplier_trial(element, x);
            element->inside = trial > element->bound_low && trial < element->bound_high;
        } else {
            evaluate_element(element, x, element->tangent);
        }
    }
    close_idle_drives(vs);
    for (int e = 0; e < vs->element_count; e++) {
        if (vs->elements[e].multiplier >= 0)
            add_multiplier_block(vs, &vs->elements[e]);
        else
            add_force_block(vs, &vs->elements[e]);
    }
    for (size_t i = 0; i < n * n; i++) vs->jacobian[i] *= over;
    vs->factored = false;
}

static pinch_row row_of(void *self, int row)
{
    pinch_velocity_system *vs = self;
    vs->segment.start = 0;
    vs->segment.length = vs->unknowns;
    vs->segment.values = vs->jacobian + (size_t)row * (size_t)vs->unknowns;
    pinch_row result = {1, &vs->segment};
    return result;
}

static bool solve(void *self, const double *rhs, double *dx)
{
    pinch_velocity_system *vs = self;
    if (!vs->factored) {
        size_t n = (size_t)vs->unknowns;
        memcpy(vs->lu, vs->jacobian, n * n * sizeof(double));
        vs->factor_good = pinch_lu_factor(vs->unknowns, vs->lu, vs->pivot, vs->lu_scratch);
        vs->factored = true;
    }
    if (vs->factor_good) pinch_lu_solve(vs->unknowns, vs->lu, vs->pivot, rhs, dx);
    return vs->factor_good;
}

pinch_system pinch_velocity_system_interface(pinch_velocity_system *vs)
{
    pinch_system system = {
        .size = vs->unknowns,
        .self = vs,
        .residual = residual,
        .residual_row = residual_row,
        .linearize = linearize,
        .row = row_of,
        .solve = solve,
    };
    return system;
}
