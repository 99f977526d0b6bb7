/*
 * The energy that joints put in, and how it is kept small.
 *
 * Rows of joints and stops put no energy in, but for taking errors of position back. Where ODE's sweeps have left
 * joints torn apart, an exact solve would take all of that back within a few steps and throw the bodies about. So where
 * the work is large beside the energy that there is, errors are taken back more slowly. At the slowest, rows only keep
 * errors from growing, which takes energy out.
 */
#include "joints/island_joints.h"

#include "support/vec3.h"

#include <math.h>

/* j v before the step and after it, added up */
static double along(const double *j, const pinch_body *body)
{
    const double *v = body->velocity, *w = body->velocity_end;
    return j[0] * (v[0] + w[0]) + j[1] * (v[1] + w[1]) + j[2] * (v[2] + w[2]) + j[3] * (v[3] + w[3]) +
           j[4] * (v[4] + w[4]) + j[5] * (v[5] + w[5]);
}

/* Returns the work (J) of the row's force in the step, from the mean of the velocities before and after. */
static double row_work(const pinch_problem *problem, const pinch_joint_row *row)
{
    double sum = 0;
    if (row->body1 >= 0) sum += along(row->j1, &problem->bodies[row->body1]);
    if (row->body2 >= 0) sum += along(row->j2, &problem->bodies[row->body2]);
    return 0.5 * problem->step * row->force * sum;
}

bool pinch_row_may_drive(const pinch_joint_row *row)
{
    return row->cfm > 0 || (row->low > -INFINITY && row->high < INFINITY);
}

/* Returns the kinetic energy (J) that a body has before forces of rows and contacts act. */
static double kinetic_energy(const pinch_body *b)
{
    const double *v = b->velocity, *w = v + 3;
    double spin = 0;
    for (int i = 0; i < 3; i++) spin += w[i] * pinch_v3_dot(b->inertia + 3 * i, w);
    return 0.5 * (b->mass * pinch_v3_dot(v, v) + spin);
}

double pinch_joint_work(const pinch_island_joints *joints, const pinch_problem *problem, double slowest)
{
    static const double PART_OF_ENERGY = 0.2;
    double work = 0, energy = 0;
    /* over all rows, because the forces of rows that contradict each other are huge and cancel */
    for (int k = 0; k < joints->joint_rows; k++) {
        double part = row_work(problem, &problem->rows[k]);
        if (part < 0 || !pinch_row_may_drive(&problem->rows[k])) work += part;
    }
    if (!(work > 0)) return 0;
    for (int b = 0; b < problem->body_count; b++)
        energy += kinetic_energy(&problem->bodies[b]) + 0.5 * problem->bodies[b].mass * slowest * slowest;
    return work / (PART_OF_ENERGY * energy);
}

void pinch_set_closing_pace(const pinch_joint_store *store, const pinch_island_joints *joints, pinch_problem *problem,
                            double from, double to)
{
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        for (int i = 0; i < joint->rows.count; i++)
            problem->rows[joint->rows.first + i].rhs += (to - from) * joint->closing[i];
    }
}
