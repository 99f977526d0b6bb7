/* The generalized Jacobian of the velocity system, equation (19). */
#include "velocity/velocity_system.h"

#include "support/dense.h"
#include "support/lanes.h"

#include <string.h>

/* dg = h D G, in the columns of one block */
static void weighted_columns(const pinch_velocity_system *vs, const pinch_element *element, const double *tangent,
                             const pinch_row_block *block, double *dg)
{
    int rows = element->law.rows, size = block->size;
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < size; k++) dg[i * size + k] = 0;
        for (int j = 0; j < rows; j++) {
            double d = vs->step * tangent[i * rows + j];
            if (d != 0) pinch_add_multiple(size, d, block->g + j * size, dg + i * size);
        }
    }
}

/* to += f[0] x[0] + f[1] x[1] + ..., so many rows of x, added one after the other to each number */
static inline void add_rows(int rows, const double *f, int size, const double *x, double *to)
{
    int c = 0;
    for (; c + 1 < size; c += 2) {
        pinch_lanes sum = pinch_lanes_at(to + c);
        for (int i = 0; i < rows; i++) sum += f[i] * pinch_lanes_at(x + i * size + c);
        pinch_lanes_put(sum, to + c);
    }
    for (int i = 0; i < rows && c < size; i++) to[c] += f[i] * x[i * size + c];
}

/* jacobian += G_a^T (h D G_b), rows of block a, columns of block b. Of most elements the compiler knows the number of
 * rows, and of blocks of free bodies the size. */
static inline void add_product(double *jacobian, size_t n, int rows, const pinch_row_block *a, const pinch_row_block *b,
                               const double *dg)
{
    for (int k = 0; k < a->size; k++) {
        double *to = jacobian + (size_t)(a->first + k) * n + b->first, f[4];
        for (int i = 0; i < rows; i++) f[i] = a->g[i * a->size + k];
        if (b->size == 6)
            add_rows(rows, f, 6, dg, to);
        else
            add_rows(rows, f, b->size, dg, to);
    }
}

/* The same with all rows of the element. */
static void add_columns(const pinch_velocity_system *vs, const pinch_element *element, const pinch_row_block *b,
                        const double *dg, double *jacobian)
{
    size_t n = (size_t)vs->unknowns;
    for (int a = 0; a < element->blocks; a++) {
        if (element->law.rows == 3)
            add_product(jacobian, n, 3, &element->block[a], b, dg);
        else
            add_product(jacobian, n, 4, &element->block[a], b, dg);
    }
}

/* The same for an element of a single row. */
static void add_row_block(const pinch_velocity_system *vs, const pinch_element *element, double tangent,
                          double *jacobian)
{
    size_t n = (size_t)vs->unknowns;
    double weight = vs->step * tangent;
    if (weight == 0) return;
    for (int a = 0; a < element->blocks; a++)
        for (int k = 0; k < element->block[a].size; k++) {
            double g = element->block[a].g[k];
            for (int b = 0; b < element->blocks; b++) {
                const pinch_row_block *block = &element->block[b];
                double *to = jacobian + (size_t)(element->block[a].first + k) * n + block->first;
                for (int c = 0; c < block->size; c++) to[c] += g * (weight * block->g[c]);
            }
        }
}

static void add_force_block(const pinch_velocity_system *vs, const pinch_element *element, const double *tangent,
                            double *jacobian)
{
    enum { COLUMNS = 24 }; /* blocks wider than this go through in parts */
    double dg[4 * COLUMNS];
    int rows = element->law.rows;
    if (rows == 1) {
        add_row_block(vs, element, tangent[0], jacobian);
        return;
    }
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *whole = &element->block[b];
        if (whole->size == 0) continue;
        if (whole->size <= COLUMNS) {
            weighted_columns(vs, element, tangent, whole, dg);
            add_columns(vs, element, whole, dg, jacobian);
            continue;
        }
        for (int k = 0; k < whole->size; k++) {
            double column[4], weighted[4];
            for (int i = 0; i < rows; i++) column[i] = whole->g[i * whole->size + k];
            pinch_row_block one = {whole->first + k, 1, column};
            weighted_columns(vs, element, tangent, &one, weighted);
            add_columns(vs, element, &one, weighted, jacobian);
        }
    }
}

/* Adds the row and column of a multiplier. Inside its bounds F_y is (w - c) / sigma, at a bound it is y - bound. */
static void add_multiplier_block(pinch_velocity_system *vs, const pinch_element *element)
{
    size_t n = (size_t)vs->unknowns, y = (size_t)element->multiplier;
    bool inside = pinch_multiplier_inside(pinch_multiplier_of(vs, element));
    if (!inside) vs->jacobian[y * n + y] = 1;
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *block = &element->block[b];
        for (int k = 0; k < block->size; k++) {
            size_t q = (size_t)(block->first + k);
            vs->jacobian[q * n + y] -= block->g[k];
            if (inside) vs->jacobian[y * n + q] += block->g[k];
        }
    }
}

/* A drive all of whose contacts are open feels no force and would have a zero row: it is to feel the force that the
 * contacts' trial law would give, which leads it back to them. */
static bool touches_idle_drive(pinch_velocity_system *vs, const pinch_element *element)
{
    pinch_velocity_list_touching(vs);
    for (int b = 0; b < element->blocks; b++) {
        if (element->block[b].size != 1 || vs->inertia[element->block[b].first] != 0) continue;
        int cluster = vs->cluster_of_unknown[element->block[b].first];
        bool idle = true;
        for (int t = vs->touching_start[cluster]; t < vs->touching_start[cluster + 1]; t++)
            idle = idle && vs->elements[vs->touching[t]].state == PINCH_CONTACT_OPEN;
        if (idle) return true;
    }
    return false;
}

/* jacobian = U^T M U; it is zeroed */
static void put_inertia(const pinch_velocity_system *vs, double *jacobian)
{
    size_t n = (size_t)vs->unknowns;
    for (int i = 0; i < vs->freedoms; i++) jacobian[(size_t)i * (n + 1)] = vs->inertia[i];
    for (int c = 0; c < vs->mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &vs->mobility->clusters[c];
        size_t m = (size_t)cluster->freedoms, first = (size_t)cluster->first;
        for (size_t i = 0; i < m && cluster->space; i++)
            memcpy(jacobian + (first + i) * n + first, cluster->space->inertia + i * m, m * sizeof *jacobian);
    }
}

void pinch_velocity_sticking(pinch_velocity_system *vs, double *jacobian)
{
    size_t n = (size_t)vs->unknowns;
    put_inertia(vs, jacobian);
    pinch_rates_add_jacobian(vs, true, jacobian);
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        double tangent[16] = {0};
        if (element->multiplier >= 0) {
            jacobian[(size_t)element->multiplier * (n + 1)] = 1;
            continue;
        }
        for (int i = 0; i < element->law.rows; i++) tangent[i * (element->law.rows + 1)] = element->trial.g[i];
        add_force_block(vs, element, tangent, jacobian);
    }
}

void pinch_velocity_assemble(pinch_velocity_system *vs)
{
    size_t n = (size_t)vs->unknowns;
    if (memcmp(vs->evaluated, vs->frozen, n * sizeof(double)) != 0) pinch_velocity_system_evaluate(vs, vs->frozen);
    memset(vs->jacobian, 0, n * n * sizeof(double));
    put_inertia(vs, vs->jacobian);
    pinch_rates_add_jacobian(vs, false, vs->jacobian);
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        if (element->multiplier >= 0) {
            add_multiplier_block(vs, element);
            continue;
        }
        double r[4], tangent[16];
        pinch_contact_law_evaluate(&element->law, &element->trial, element->w, r, tangent);
        if (vs->has_drive && !vs->in_flow && touches_idle_drive(vs, element)) tangent[0] = element->trial.g[0];
        add_force_block(vs, element, tangent, vs->jacobian);
    }
    if (vs->pull > 0)
        for (size_t i = 0; i < n * n; i++) vs->jacobian[i] += vs->pull * vs->sticking[i];
    pinch_velocity_states(vs, vs->states);
    vs->assembled = true;
    vs->scaled = vs->factored = false;
}
