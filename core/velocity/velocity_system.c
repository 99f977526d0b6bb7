#include "velocity/velocity_system.h"

#include "kinematics/joint_space.h"
#include "support/dense.h"
#include "support/extremes.h"
#include "support/lanes.h"

#include <math.h>
#include <string.h>

/* The product of a free body's six components, in three chains of additions. */
static inline double dot6_chains(const double *a, const double *b)
{
    pinch_lanes first = pinch_lanes_at(a) * pinch_lanes_at(b), second = pinch_lanes_at(a + 2) * pinch_lanes_at(b + 2),
                third = pinch_lanes_at(a + 4) * pinch_lanes_at(b + 4);
    return (first[0] + first[1]) + (second[0] + second[1]) + (third[0] + third[1]);
}

/* w += G q, in the columns of one block */
static inline void add_velocity(const pinch_row_block *block, int rows, const double *x, double *w)
{
    const double *q = x + block->first;
    int size = block->size;
    if (size == 6)
        for (int row = 0; row < rows; row++) w[row] += dot6_chains(block->g + 6 * row, q);
    else if (size == 1) /* of a joint by itself, or a massless drive */
        for (int row = 0; row < rows; row++) w[row] += block->g[row] * q[0];
    else if (size > 0)
        for (int row = 0; row < rows; row++) w[row] += pinch_dot(block->g + row * size, q, size);
}

void pinch_element_velocity(const pinch_element *element, const double *x, double *w)
{
    int rows = element->law.rows;
    for (int row = 0; row < rows; row++) w[row] = element->w0[row];
    for (int b = 0; b < element->blocks; b++) add_velocity(&element->block[b], rows, x, w);
}

static void evaluate_element(pinch_velocity_system *vs, pinch_element *element, const double *x)
{
    pinch_element_velocity(element, x, element->w);
    pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
    if (multiplier)
        multiplier->trial = x[element->multiplier] - (element->w[0] - multiplier->unit.target);
    else
        element->state = pinch_contact_law_evaluate(&element->law, &element->trial, element->w, element->r, NULL);
}

void pinch_velocity_system_evaluate(pinch_velocity_system *vs, const double *x)
{
    for (int e = 0; e < vs->element_count; e++) evaluate_element(vs, &vs->elements[e], x);
    pinch_rates_evaluate(vs, x);
    memcpy(vs->evaluated, x, sizeof(double) * (size_t)vs->unknowns);
}

/* A stop that is not reached has no force, not that of rounding: nothing else says how small that is. */
double pinch_element_multiplier(const pinch_velocity_system *vs, const pinch_element *element, const double *x)
{
    const pinch_multiplier *m = pinch_multiplier_of(vs, element);
    bool reached = pinch_multiplier_inside(m) || pinch_clamp(m->trial, m->unit.low, m->unit.high) != 0;
    return reached ? x[element->multiplier] / (vs->step * m->unit.sigma) : 0;
}

static double multiplier_residual(const pinch_velocity_system *vs, const pinch_element *element, const double *x)
{
    const pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
    return x[element->multiplier] - pinch_clamp(multiplier->trial, multiplier->unit.low, multiplier->unit.high);
}

static double impulse_of(const pinch_velocity_system *vs, const pinch_element *element, int row, const double *x)
{
    return element->multiplier >= 0 ? x[element->multiplier] : vs->step * element->r[row];
}

/* f += G^T impulse for a contact with friction on a free body: rows 3 or 4, six columns */
static inline void add_free(const double *g, int rows, const double *impulse, double *f)
{
    for (int k = 0; k < 6; k += 2) {
        pinch_lanes sum = pinch_lanes_at(f + k) +
                          (impulse[0] * pinch_lanes_at(g + k) +
                           (impulse[1] * pinch_lanes_at(g + 6 + k) + impulse[2] * pinch_lanes_at(g + 12 + k)));
        if (rows == 4) sum += impulse[3] * pinch_lanes_at(g + 18 + k);
        pinch_lanes_put(sum, f + k);
    }
}

static inline void add_block(const pinch_row_block *block, int rows, const double *impulse, double *f)
{
    double *to = f + block->first;
    int size = block->size;
    if (size == 6 && rows >= 3) {
        add_free(block->g, rows, impulse, to);
        return;
    }
    if (size == 1) {
        for (int row = 0; row < rows; row++) to[0] += impulse[row] * block->g[row];
        return;
    }
    for (int row = 0; row < rows; row++)
        for (int k = 0; k < size; k++) to[k] += impulse[row] * block->g[row * size + k];
}

void pinch_element_add_impulse(const pinch_velocity_system *vs, const pinch_element *element, const double *x,
                               double sign, double *f)
{
    double impulse[4];
    int rows = element->law.rows;
    for (int row = 0; row < rows; row++) impulse[row] = sign * impulse_of(vs, element, row, x);
    for (int b = 0; b < element->blocks; b++) add_block(&element->block[b], rows, impulse, f);
}

/* size += |G|^T impulse for a contact with friction on a free body */
static void add_free_size(const double *g, int rows, const double *impulse, double *size)
{
    for (int k = 0; k < 6; k += 2) {
        pinch_lanes part[4], sum = pinch_lanes_at(size + k);
        for (int row = 0; row < rows; row++)
            part[row] = impulse[row] * pinch_lanes_abs(pinch_lanes_at(g + 6 * row + k));
        sum = rows == 3 ? sum + (part[0] + (part[1] + part[2])) : sum + part[0] + part[1] + part[2] + part[3];
        pinch_lanes_put(sum, size + k);
    }
}

/* size += |G|^T |impulse| */
static void add_size(const pinch_velocity_system *vs, const pinch_element *element, const double *x,
                     double *restrict size)
{
    double impulse[4];
    int rows = element->law.rows;
    for (int row = 0; row < rows; row++) impulse[row] = fabs(impulse_of(vs, element, row, x));
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *block = &element->block[b];
        const double *restrict g = block->g;
        double *restrict to = size + block->first;
        if (block->size == 6 && rows == 3)
            add_free_size(g, 3, impulse, to);
        else if (block->size == 6 && rows == 4)
            add_free_size(g, 4, impulse, to);
        else if (block->size == 1)
            for (int row = 0; row < rows; row++) to[0] += impulse[row] * fabs(g[row]);
        else
            for (int row = 0; row < rows; row++)
                for (int k = 0; k < block->size; k++) to[k] += impulse[row] * fabs(g[row * block->size + k]);
    }
}

/* F is measured against the impulses that act at x, and the one that led there, as magnitudes. */
static void set_scale(pinch_velocity_system *vs, const double *x)
{
    double sum = 0;
    for (int e = 0; e < vs->element_count; e++) add_size(vs, &vs->elements[e], x, vs->size);
    pinch_rates_add_size(vs, x, vs->size);
    for (int i = 0; i < vs->freedoms; i++) {
        double size = vs->size[i] + fabs(vs->drive[i]) + vs->inertia[i] * fabs(x[i]);
        sum += size * size;
    }
    vs->scale = sum > 0 ? sqrt(sum) : 1;
}

/* f += pull H (x - anchor) */
static void add_pull(const pinch_velocity_system *vs, const double *x, double *f)
{
    int n = vs->unknowns;
    for (int i = 0; i < n; i++) vs->flow_scratch[i] = vs->pull * (x[i] - vs->anchor[i]);
    for (int i = 0; i < n; i++) f[i] += pinch_dot(vs->sticking + (size_t)i * (size_t)n, vs->flow_scratch, n);
}

void pinch_velocity_system_rescale(pinch_velocity_system *vs)
{
    pinch_velocity_system_evaluate(vs, vs->x);
    memset(vs->size, 0, sizeof(double) * (size_t)vs->unknowns);
    set_scale(vs, vs->x);
    vs->assembled = vs->scaled = vs->factored = false;
}

/* Evaluates an element of a single row, as those of joints are, and takes its impulse from f, in one go. */
static void residual_of_row(pinch_velocity_system *vs, pinch_element *element, const double *x, double *f)
{
    double w, impulse;
    pinch_element_velocity(element, x, &w);
    element->w[0] = w;
    if (element->multiplier >= 0) {
        pinch_multiplier *m = pinch_multiplier_of(vs, element);
        impulse = x[element->multiplier];
        m->trial = impulse - (w - m->unit.target);
        f[element->multiplier] = impulse - pinch_clamp(m->trial, m->unit.low, m->unit.high);
    } else {
        double trial = element->trial.a[0] - element->trial.g[0] * w;
        (void)pinch_contact_law_clamp_normal(&element->law, trial, &element->r[0]);
        element->state = trial > element->law.low ? PINCH_CONTACT_STICK : PINCH_CONTACT_OPEN;
        impulse = vs->step * element->r[0];
    }
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *block = &element->block[b];
        double *to = f + block->first;
        for (int k = 0; k < block->size; k++) to[k] -= impulse * block->g[k];
    }
}

/* Evaluates a contact of so many rows, 3 or 4, and takes its impulse from f, in one go. */
static inline void residual_of_contact(pinch_velocity_system *vs, pinch_element *element, int rows, const double *x,
                                       double *f)
{
    double w[4], r[4], impulse[4];
    for (int row = 0; row < rows; row++) w[row] = element->w0[row];
    for (int b = 0; b < element->blocks; b++) add_velocity(&element->block[b], rows, x, w);
    element->state = pinch_contact_law_evaluate_rows(&element->law, rows, &element->trial, w, r, NULL);
    for (int row = 0; row < rows; row++) {
        element->w[row] = w[row];
        element->r[row] = r[row];
        impulse[row] = -(vs->step * r[row]);
    }
    for (int b = 0; b < element->blocks; b++) add_block(&element->block[b], rows, impulse, f);
}

/* f += (U^T M U - d) x: only rates of joints share inertia */
static void add_shared_inertia(const pinch_velocity_system *vs, const double *x, double *f)
{
    for (int c = 0; c < vs->mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &vs->mobility->clusters[c];
        if (cluster->space) pinch_joint_space_add_coupling(cluster->space, x + cluster->first, f + cluster->first);
    }
}

void pinch_velocity_residual(void *self, const double *x, double *f)
{
    pinch_velocity_system *vs = self;
    for (int i = 0; i < vs->freedoms; i++) f[i] = vs->inertia[i] * x[i] - vs->drive[i];
    add_shared_inertia(vs, x, f);
    memcpy(vs->evaluated, x, sizeof(double) * (size_t)vs->unknowns);
    for (int e = 0; e < vs->element_count; e++) {
        pinch_element *element = &vs->elements[e];
        if (element->law.rows == 1) {
            residual_of_row(vs, element, x, f);
            continue;
        }
        if (element->law.rows == 3)
            residual_of_contact(vs, element, 3, x, f);
        else
            residual_of_contact(vs, element, 4, x, f);
    }
    pinch_rates_residual(vs, x, f);
    if (vs->scale == 0) set_scale(vs, x);
    if (vs->pull > 0) add_pull(vs, x, f);
    double over = 1 / vs->scale;
    for (int i = 0; i < vs->unknowns; i++) f[i] *= over;
}

void pinch_velocity_list_touching(pinch_velocity_system *vs)
{
    int clusters = vs->mobility->cluster_count;
    if (vs->listed) return;
    vs->listed = true;
    for (int c = 0; c < clusters; c++) {
        const pinch_cluster *cluster = &vs->mobility->clusters[c];
        for (int f = 0; f < cluster->freedoms; f++) vs->cluster_of_unknown[cluster->first + f] = c;
    }
    memset(vs->touching_start, 0, sizeof(int) * (size_t)(clusters + 2));
    for (int pass = 0; pass < 2; pass++) {
        for (int e = 0; e < vs->element_count; e++) {
            const pinch_element *element = &vs->elements[e];
            for (int b = 0; b < element->blocks; b++) {
                int c = vs->cluster_of_unknown[element->block[b].first];
                if (b > 0 && vs->cluster_of_unknown[element->block[b - 1].first] == c) continue; /* once */
                if (pass == 0)
                    vs->touching_start[c + 2]++;
                else
                    vs->touching[vs->touching_start[c + 1]++] = e;
            }
        }
        if (pass == 0)
            for (int c = 0; c < clusters; c++) vs->touching_start[c + 2] += vs->touching_start[c + 1];
    }
}

/* Evaluates only the elements that the row depends on; what was evaluated before is no longer of one point. */
double pinch_velocity_residual_row(void *self, const double *x, int row)
{
    pinch_velocity_system *vs = self;
    vs->evaluated[0] = NAN;
    if (row >= vs->freedoms) {
        int e = vs->element_count - 1;
        while (e >= 0 && vs->elements[e].multiplier != row) e--;
        if (e < 0) return pinch_rates_residual_row(vs, x, row) / vs->scale;
        evaluate_element(vs, &vs->elements[e], x);
        return multiplier_residual(vs, &vs->elements[e], x) / vs->scale;
    }
    pinch_velocity_list_touching(vs);
    int cluster = vs->cluster_of_unknown[row];
    const pinch_cluster *own = &vs->mobility->clusters[cluster];
    double f = (own->space ? pinch_dot(own->space->inertia + (size_t)(row - own->first) * (size_t)own->freedoms,
                                       x + own->first, own->freedoms)
                           : vs->inertia[row] * x[row]) -
               vs->drive[row];
    f += pinch_rates_residual_row(vs, x, row);
    for (int t = vs->touching_start[cluster]; t < vs->touching_start[cluster + 1]; t++) {
        pinch_element *element = &vs->elements[vs->touching[t]];
        evaluate_element(vs, element, x);
        for (int b = 0; b < element->blocks; b++) {
            const pinch_row_block *block = &element->block[b];
            int k = row - block->first;
            if (k < 0 || k >= block->size) continue;
            for (int i = 0; i < element->law.rows; i++)
                f -= impulse_of(vs, element, i, x) * block->g[i * block->size + k];
        }
    }
    return f / vs->scale;
}
