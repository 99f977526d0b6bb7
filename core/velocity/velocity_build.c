/* Assembly of the velocity system from the problem and its mobility. */
#include "velocity/velocity_system.h"

#include <math.h>
#include <string.h>

static bool attach(pinch_arena *arena, const pinch_mobility *mobility, int rows, const int body[2],
                   const double *const jacobian[2], const double sign[2], pinch_element *element)
{
    int cluster[2];
    return pinch_reduce_rows(arena, mobility, rows, body, jacobian, sign, element->block, cluster, element->w0);
}

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                        const pinch_contact *contact, pinch_element *element)
{
    int cluster[2];
    element->multiplier = -1;
    memcpy(element->w0, contact->surface_velocity, sizeof element->w0); /* torsion is the last row here */
    pinch_law_of_contact(contact, problem->step, problem->faces, &element->law);
    return pinch_contact_rows(arena, mobility, problem, contact, element->law.rows, element->block, cluster,
                              element->w0);
}

static double block_norm2(const pinch_element *element)
{
    double sum = 0;
    for (int b = 0; b < 2; b++)
        for (int k = 0; k < element->block[b].size; k++) sum += element->block[b].g[k] * element->block[b].g[k];
    return sum;
}

static bool add_row(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                    const pinch_joint_row *row, int unknown, pinch_multiplier *multiplier, pinch_element *element)
{
    const int body[2] = {row->body1, row->body2};
    const double sign[2] = {1, 1};
    const double *const jacobians[2] = {row->j1, row->j2};
    memset(element, 0, sizeof *element);
    element->multiplier = -1;
    element->law.rows = 1;
    if (!attach(arena, mobility, 1, body, jacobians, sign, element)) return false;

    double h = problem->step, sigma2 = block_norm2(element), sigma = sqrt(sigma2);
    if (row->cfm > 0) {
        element->law.a[0] = row->rhs / row->cfm;
        element->law.g[0] = 1 / row->cfm;
        element->law.low = row->low;
        element->law.high = row->high;
    } else if (sigma2 > 0) {
        element->multiplier = unknown;
        multiplier->sigma = sigma;
        multiplier->target = (row->rhs - element->w0[0]) / sigma;
        multiplier->low = h * sigma * row->low;
        multiplier->high = h * sigma * row->high;
        for (int b = 0; b < 2; b++) { /* g_b = G_b / sigma_b; the array is this element's own */
            double *g = (double *)element->block[b].g;
            for (int k = 0; k < element->block[b].size; k++) g[k] /= sigma;
        }
        element->w0[0] = 0;
    } else { /* acts on nothing that can move: no force changes anything */
        element->law.low = element->law.high = 0;
    }
    return true;
}

/* h U^T f_ext, the first part of the scale of F; and a drive's guess of its speed. */
static void external_size(const pinch_problem *problem, const pinch_cluster *cluster, double h, double *size, double *x)
{
    for (int slot = 0; slot < cluster->body_count; slot++) {
        double expanded[36];
        const double *external = problem->bodies[cluster->bodies[slot]].external;
        const double *basis = pinch_cluster_basis(cluster, slot, expanded);
        for (int k = 0; k < 6; k++) {
            if (external[k] == 0) continue;
            for (int f = 0; f < cluster->freedoms; f++)
                size[cluster->first + f] += fabs(h * basis[k * cluster->freedoms + f] * external[k]);
        }
    }
    if (cluster->inertia != 0) return;
    const pinch_body *body = &problem->bodies[cluster->bodies[0]];
    double speed = 0, unit2 = 0;
    for (int k = 0; k < 3; k++) {
        speed += cluster->basis[k] * body->velocity[k];
        unit2 += cluster->basis[k] * cluster->basis[k];
    }
    x[cluster->first] = speed / unit2;
}

/* The start: the velocities that the forces of the last step would give now. At rest they are the answer. */
static void warm_start(const pinch_problem *problem, const int *row_element, pinch_velocity_system *vs, double *x)
{
    const pinch_mobility *mobility = vs->mobility;
    double h = problem->step;
    memset(x, 0, sizeof(double) * (size_t)vs->unknowns);
    memset(vs->size, 0, sizeof(double) * (size_t)vs->unknowns);
    for (int j = 0; j < problem->row_count; j++) {
        if (row_element[j] < 0) continue;
        const pinch_element *element = &vs->elements[row_element[j]];
        if (element->multiplier < 0) continue;
        const pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
        double y = h * multiplier->sigma * problem->rows[j].force;
        x[element->multiplier] = fmin(fmax(y, multiplier->low), multiplier->high);
    }
    for (int e = 0; e < vs->element_count; e++) pinch_element_add_impulse(vs, &vs->elements[e], x, 1, x);
    for (int c = 0; c < mobility->cluster_count; c++) external_size(problem, &mobility->clusters[c], h, vs->size, x);
}

static bool allocate(pinch_arena *arena, const pinch_problem *problem, pinch_velocity_system *vs, int **row_element)
{
    *row_element = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    if (arena->failed) return false;
    vs->element_count = problem->contact_count;
    vs->unknowns = vs->freedoms;
    for (int j = 0; j < problem->row_count; j++) {
        const pinch_joint_row *row = &problem->rows[j];
        (*row_element)[j] = pinch_row_is_hard(row) ? -1 : vs->element_count++;
        if (!pinch_row_is_hard(row) && row->cfm == 0) vs->unknowns++;
    }
    size_t n = (size_t)vs->unknowns;
    vs->elements = PINCH_ARENA_ARRAY(arena, pinch_element, vs->element_count + 1);
    vs->multipliers = PINCH_ARENA_ARRAY(arena, pinch_multiplier, vs->unknowns - vs->freedoms + 1);
    vs->inertia = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->drive = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->size = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->evaluated = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->frozen = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->states = PINCH_ARENA_ARRAY(arena, unsigned char, vs->element_count + 1);
    vs->jacobian = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    vs->lu = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    vs->lu_scratch = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->pivot = PINCH_ARENA_ARRAY(arena, int, n + 1);
    vs->cluster_of_unknown = PINCH_ARENA_ARRAY(arena, int, n + 1);
    vs->touching_start = PINCH_ARENA_ARRAY(arena, int, vs->mobility->cluster_count + 2);
    vs->touching = PINCH_ARENA_ARRAY(arena, int, 2 * vs->element_count + 1);
    return !arena->failed;
}

bool pinch_velocity_system_build(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                                 pinch_velocity_system *vs, int **row_element, double **x)
{
    memset(vs, 0, sizeof *vs);
    vs->step = problem->step;
    vs->mobility = mobility;
    vs->memory = problem->memory;
    vs->tag = problem->tag;
    vs->freedoms = mobility->unknowns;
    if (!allocate(arena, problem, vs, row_element)) return false;
    *x = PINCH_ARENA_ARRAY(arena, double, 2 * vs->unknowns + 1);

    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &mobility->clusters[c];
        const pinch_body *body = &problem->bodies[cluster->bodies[0]];
        for (int f = 0; f < cluster->freedoms; f++) {
            vs->inertia[cluster->first + f] = cluster->inertia;
            double drive = 0; /* h U^T f_drive */
            for (int k = 0; k < 3 && cluster->inertia == 0; k++)
                drive += problem->step * cluster->basis[k] * body->drive_axis[k] * body->drive_force;
            vs->drive[cluster->first + f] = drive;
            vs->has_drive = vs->has_drive || cluster->inertia == 0;
        }
    }
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_element *element = &vs->elements[k];
        if (!add_contact(arena, problem, mobility, &problem->contacts[k], element)) return false;
        memcpy(element->r, problem->contacts[k].force, sizeof element->r);
    }
    vs->evaluated[0] = NAN; /* nothing yet */
    int multiplier = 0;
    for (int j = 0; j < problem->row_count; j++) {
        if ((*row_element)[j] < 0) continue;
        pinch_element *element = &vs->elements[(*row_element)[j]];
        if (!add_row(arena, problem, mobility, &problem->rows[j], vs->freedoms + multiplier,
                     &vs->multipliers[multiplier], element))
            return false;
        if (problem->rows[j].cfm == 0) multiplier++;
        element->r[0] = element->multiplier >= 0 ? 0 : problem->rows[j].force;
    }
    warm_start(problem, *row_element, vs, *x);
    return true;
}
