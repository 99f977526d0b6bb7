/* Builds the velocity system from the problem and its mobility. */
#include "velocity/velocity_system.h"

#include <math.h>
#include <string.h>

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                        const pinch_contact *contact, pinch_element *element)
{
    int cluster[2];
    element->multiplier = -1;
    memcpy(element->w0, contact->surface_velocity, sizeof element->w0); /* torsion is the last row here */
    memcpy(element->r, contact->force, sizeof element->r);
    pinch_contact_law_of(contact, problem->faces, &element->law);
    pinch_trial_force_of(contact, problem->step, &element->trial);
    return pinch_contact_rows(arena, mobility, problem->bodies, contact, element->block, cluster, element->w0);
}

/* A row without compliance has a multiplier, whose place among the unknowns is `unknown`. */
static bool add_row(pinch_arena *arena, double step, const pinch_mobility *mobility, const pinch_joint_row *row,
                    int unknown, pinch_multiplier *multiplier, pinch_element *element)
{
    int cluster[2];
    memset(element, 0, sizeof *element);
    element->multiplier = -1;
    element->law.rows = 1;
    if (!pinch_joint_row_reduce(arena, mobility, row, element->block, cluster, element->w0)) return false;
    if (row->cfm > 0) {
        element->trial.a[0] = row->rhs / row->cfm;
        element->trial.g[0] = 1 / row->cfm;
        element->law.low = row->low;
        element->law.high = row->high;
    } else if (pinch_unit_row_make(row, step, element->w0[0], element->block, 2, &multiplier->unit)) {
        element->multiplier = unknown;
        element->w0[0] = 0;
    } /* else no force on it changes anything: its bounds are 0 */
    if (element->multiplier < 0) element->r[0] = row->force;
    return true;
}

/* Adds |h U^T f_ext|, the first part of the scale of F, and sets a drive's guess of its speed. */
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

/* The solve starts from the velocities that the forces of the last step would give now. At rest they are the answer. */
static void warm_start(const pinch_problem *problem, pinch_velocity_system *vs)
{
    const pinch_mobility *mobility = vs->mobility;
    double h = problem->step, *x = vs->x;
    memset(x, 0, sizeof(double) * (size_t)vs->unknowns);
    memset(vs->size, 0, sizeof(double) * (size_t)vs->unknowns);
    for (int j = 0; j < problem->row_count; j++) {
        if (vs->element_of_row[j] < 0) continue;
        const pinch_element *element = &vs->elements[vs->element_of_row[j]];
        if (element->multiplier < 0) continue;
        const pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
        double y = h * multiplier->unit.sigma * problem->rows[j].force;
        x[element->multiplier] = fmin(fmax(y, multiplier->unit.low), multiplier->unit.high);
    }
    for (int e = 0; e < vs->element_count; e++) pinch_element_add_impulse(vs, &vs->elements[e], x, 1, x);
    for (int c = 0; c < mobility->cluster_count; c++) external_size(problem, &mobility->clusters[c], h, vs->size, x);
    memcpy(vs->start, x, sizeof(double) * (size_t)vs->unknowns);
}

static bool allocate(pinch_arena *arena, const pinch_problem *problem, pinch_velocity_system *vs)
{
    vs->body_scratch = PINCH_ARENA_ARRAY(arena, double, 12 * problem->body_count);
    vs->element_of_row = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    if (arena->failed) return false;
    vs->element_count = problem->contact_count;
    vs->unknowns = vs->freedoms;
    for (int j = 0; j < problem->row_count; j++) {
        bool eliminated = vs->mobility->eliminated[j];
        vs->element_of_row[j] = eliminated ? -1 : vs->element_count++;
        if (!eliminated && problem->rows[j].cfm == 0) vs->unknowns++;
    }
    size_t n = (size_t)vs->unknowns;
    vs->x = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->start = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->solver_scratch = PINCH_ARENA_ARRAY(arena, double, pinch_solver_scratch(vs->unknowns) + 1);
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

/* Sets the inertia d, and h U^T f_drive of massless drives. */
static void set_inertia(const pinch_problem *problem, pinch_velocity_system *vs)
{
    const pinch_mobility *mobility = vs->mobility;
    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &mobility->clusters[c];
        const pinch_body *body = &problem->bodies[cluster->bodies[0]];
        for (int f = 0; f < cluster->freedoms; f++) {
            vs->inertia[cluster->first + f] = cluster->inertia;
            double drive = 0;
            for (int k = 0; k < 3 && cluster->inertia == 0; k++)
                drive += problem->step * cluster->basis[k] * body->drive_axis[k] * body->drive_force;
            vs->drive[cluster->first + f] = drive;
            vs->has_drive = vs->has_drive || cluster->inertia == 0;
        }
    }
}

bool pinch_velocity_system_build(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                                 pinch_velocity_system *vs)
{
    memset(vs, 0, sizeof *vs);
    vs->step = problem->step;
    vs->mobility = mobility;
    vs->memory = problem->memory;
    vs->tag = problem->tag;
    vs->freedoms = mobility->unknowns;
    if (!allocate(arena, problem, vs)) return false;
    set_inertia(problem, vs);
    for (int k = 0; k < problem->contact_count; k++)
        if (!add_contact(arena, problem, mobility, &problem->contacts[k], &vs->elements[k])) return false;
    vs->evaluated[0] = NAN; /* nothing yet */
    int multiplier = 0;
    for (int j = 0; j < problem->row_count; j++) {
        const pinch_joint_row *row = &problem->rows[j];
        if (vs->element_of_row[j] < 0) continue;
        if (!add_row(arena, problem->step, mobility, row, vs->freedoms + multiplier, &vs->multipliers[multiplier],
                     &vs->elements[vs->element_of_row[j]]))
            return false;
        if (row->cfm == 0) multiplier++;
    }
    warm_start(problem, vs);
    return true;
}
