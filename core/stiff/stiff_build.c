/* A stiff system from its problem: rows in reduced coordinates, laws, and what the contacts came with. */
#include "stiff/stiff_rows.h"
#include "stiff/stiff_system.h"

#include <math.h>
#include <string.h>

/* of a block with one row */
static double block_norm2(const pinch_element_block *block)
{
    double sum = 0;
    for (int k = 0; k < block->size; k++) sum += block->g[k] * block->g[k];
    return sum;
}

static double row_norm2(const pinch_element_block block[2], int row)
{
    double sum = 0;
    for (int b = 0; b < 2; b++)
        for (int k = 0; k < block[b].size; k++) {
            double g = block[b].g[row * block[b].size + k];
            sum += g * g;
        }
    return sum;
}

/* Zeros for the arrays of an element with this many rows; false: no memory. */
static bool make_room(pinch_arena *arena, int rows, pinch_stiff_element *e)
{
    double **const array[] = {&e->w0, &e->b, &e->inertia, &e->prescribed, &e->compliance, &e->rho,   &e->r,
                              &e->w,  &e->z, &e->f,       &e->shift,      &e->change,     &e->start, &e->slope};
    enum { ARRAYS = sizeof array / sizeof *array };
    size_t count = (size_t)(rows * (ARRAYS - 1 + rows));
    double *room = PINCH_ARENA_ARRAY(arena, double, count);
    if (!room) return false;
    memset(room, 0, count * sizeof *room);
    for (int k = 0; k < ARRAYS; k++) *array[k] = room + k * rows; /* the slope last */
    return true;
}

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                        pinch_contact *contact, pinch_stiff_element *e)
{
    double h = problem->step;
    memset(e, 0, sizeof *e);
    e->contact = contact;
    pinch_stiff_law_of_contact(contact, &e->law);
    int rows = e->law.rows;
    if (!make_room(arena, rows, e)) return false;
    memcpy(e->w0, contact->surface_velocity, sizeof *e->w0 * (size_t)rows);
    if (!pinch_contact_rows(arena, mobility, problem, contact, rows, e->block, e->cluster, e->w0)) return false;
    for (int i = 0; i < rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        e->inertia[i] = row_norm2(e->block, i);
        e->prescribed[i] = 1 / (h * contact->stiffness[kind] + contact->damping[kind]);
        if (kind == 1 && contact->viscous[i - 1] > 0) e->prescribed[i] = contact->viscous[i - 1];
    }
    memcpy(e->elastic, contact->elastic, sizeof contact->elastic);
    memcpy(e->elastic + 3, contact->rolling_elastic, sizeof contact->rolling_elastic);
    memcpy(e->stiffness, contact->stiffness, sizeof contact->stiffness);
    memcpy(e->damping, contact->damping, sizeof contact->damping);
    memcpy(e->viscous, contact->viscous, sizeof contact->viscous);
    memcpy(e->compliance_before, contact->compliance, sizeof contact->compliance);
    return true;
}

void pinch_stiff_undo(const pinch_stiff_system *s)
{
    for (int k = 0; k < s->contact_count; k++) {
        const pinch_stiff_element *e = &s->elements[k];
        pinch_contact *c = e->contact;
        memcpy(c->elastic, e->elastic, sizeof c->elastic);
        memcpy(c->rolling_elastic, e->elastic + 3, sizeof c->rolling_elastic);
        memcpy(c->stiffness, e->stiffness, sizeof c->stiffness);
        memcpy(c->damping, e->damping, sizeof c->damping);
        memcpy(c->viscous, e->viscous, sizeof c->viscous);
        memcpy(c->compliance, e->compliance_before, sizeof c->compliance);
    }
}

static bool add_row(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, int index,
                    pinch_stiff_element *e, pinch_stiff_multiplier *m, bool compliant)
{
    const pinch_joint_row *row = &problem->rows[index];
    const int body[2] = {row->body1, row->body2};
    const double sign[2] = {1, 1};
    const double *const jacobians[2] = {row->j1, row->j2};
    double w0 = 0;
    pinch_element_block *block = compliant ? e->block : m->block;
    int *cluster = compliant ? e->cluster : m->cluster;
    if (compliant)
        memset(e, 0, sizeof *e);
    else
        memset(m, 0, sizeof *m);
    if (!pinch_reduce_rows(arena, mobility, 1, body, jacobians, sign, block, cluster, &w0)) return false;
    if (cluster[1] >= 0 && block_norm2(&block[1]) > block_norm2(&block[0])) { /* the home is where it acts most */
        pinch_element_block swapped = block[0];
        int other = cluster[0];
        block[0] = block[1];
        cluster[0] = cluster[1];
        block[1] = swapped;
        cluster[1] = other;
    }
    double sigma2 = row_norm2(block, 0);
    if (compliant) {
        if (!make_room(arena, 1, e)) return false;
        e->law.rows = 1;
        e->law.low = row->low;
        e->law.high = row->high;
        e->w0[0] = w0;
        e->b[0] = row->rhs;
        e->inertia[0] = sigma2;
        e->prescribed[0] = row->cfm;
        return true;
    }
    double h = problem->step, sigma = sqrt(sigma2);
    m->row = index;
    m->sigma = sigma;
    if (sigma == 0) return true; /* acts on nothing that can move: its target, bounds and y stay 0 */
    m->target = (row->rhs - w0) / sigma;
    m->low = h * sigma * row->low;
    m->high = h * sigma * row->high;
    for (int b = 0; b < 2; b++) { /* the array is this row's own */
        double *g = (double *)m->block[b].g;
        for (int k = 0; k < m->block[b].size; k++) g[k] /= sigma;
    }
    return true;
}

bool pinch_stiff_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_stiff_system *s)
{
    memset(s, 0, sizeof *s);
    s->step = problem->step;
    s->mobility = mobility;
    s->contact_count = problem->contact_count;
    s->elements = PINCH_ARENA_ARRAY(arena, pinch_stiff_element, problem->contact_count + problem->row_count + 1);
    s->multipliers = PINCH_ARENA_ARRAY(arena, pinch_stiff_multiplier, problem->row_count + 1);
    s->element_of_row = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    s->q = PINCH_ARENA_ARRAY(arena, double, mobility->unknowns + 1);
    if (arena->failed) return false;
    for (int k = 0; k < problem->contact_count; k++)
        if (!add_contact(arena, problem, mobility, &problem->contacts[k], &s->elements[k])) return false;
    s->element_count = problem->contact_count;
    for (int j = 0; j < problem->row_count; j++) {
        bool compliant = problem->rows[j].cfm > 0;
        s->element_of_row[j] = -1;
        if (pinch_row_is_hard(&problem->rows[j])) continue;
        s->element_of_row[j] = compliant ? s->element_count : -2 - s->multiplier_count;
        if (!add_row(arena, problem, mobility, j, &s->elements[s->element_count], &s->multipliers[s->multiplier_count],
                     compliant))
            return false;
        if (compliant)
            s->element_count++;
        else
            s->multiplier_count++;
    }
    return true;
}
