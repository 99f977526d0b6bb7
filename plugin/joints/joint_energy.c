/*
 * The energy that joints put in, and how it is kept small.
 *
 * Rows of joints and stops put no energy in, but for taking errors of position back. Where ODE's sweeps have left
 * joints torn apart, an exact solve would take all of that back within a few steps and throw the bodies about. So where
 * the work is large beside the energy that there is, errors are taken back more slowly. After exact steps errors are
 * small, and may be taken back as ODE does. But loops that are nearly locked need large motions for small errors; that
 * is where the work is a multiple of what the rows ask for by themselves, and there it is done more slowly, too.
 *
 * What all forces together add is the sum of h f.(w + w+)/2, and also that of h f.w+ less the energy of the change of
 * the velocities. So what rows add is at most their work by the velocities at the end, too. The smaller one counts: by
 * the mean velocities, rows that hold bodies against motors and contacts can seem to put in what those do. At the
 * slowest, rows only keep errors from growing, and w+ = 0: they add nothing.
 */
#include "joints/island_joints.h"

#include "support/vec3.h"

#include <math.h>

/* j v at the start of the step, or at its end */
static double along(const double *j, const double *v)
{
    return j[0] * v[0] + j[1] * v[1] + j[2] * v[2] + j[3] * v[3] + j[4] * v[4] + j[5] * v[5];
}

/* The work (J) of rows in a step, by the mean of the velocities before and after it, and by those after it. */
typedef struct work {
    double by_mean, by_end;
} work;

static work row_work(const pinch_problem *problem, const pinch_joint_row *row)
{
    double start = 0, end = 0, impulse = problem->step * row->force;
    for (int side = 0; side < 2; side++) {
        int body = side ? row->body2 : row->body1;
        const double *j = side ? row->j2 : row->j1;
        if (body < 0) continue;
        start += along(j, problem->bodies[body].velocity);
        end += along(j, problem->bodies[body].velocity_end);
    }
    return (work){.by_mean = 0.5 * impulse * (start + end), .by_end = impulse * end};
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

/* Returns the energy (J) of the row's two bodies where they move along the row as fast as it asks for. */
static double energy_asked_for(const pinch_problem *problem, const pinch_joint_row *row)
{
    double length2 = 0, resists = 0;
    for (int side = 0; side < 2; side++) {
        int body = side ? row->body2 : row->body1;
        const double *j = side ? row->j2 : row->j1;
        if (body < 0) continue;
        const pinch_body *b = &problem->bodies[body];
        for (int i = 0; i < 6; i++) length2 += j[i] * j[i];
        for (int i = 0; i < 3; i++) resists += j[3 + i] * pinch_v3_dot(b->inertia + 3 * i, j + 3);
        resists += b->mass * pinch_v3_dot(j, j);
    }
    return length2 > 0 ? 0.5 * row->rhs * row->rhs * resists / (length2 * length2) : 0;
}

/* Returns the energy (J) that errors of position may be taken back with. */
static double tolerated_work(const pinch_island_joints *joints, const pinch_problem *problem, bool swept,
                             double slowest)
{
    static const double OF_SWEPT = 0.01, OF_EXACT = 0.2, OF_LEAST = 0.2, TIMES_ASKED_FOR = 100;
    double energy = 0, least = 0, asked_for = 0;
    for (int b = 0; b < problem->body_count; b++) {
        energy += kinetic_energy(&problem->bodies[b]);
        least += 0.5 * problem->bodies[b].mass * slowest * slowest;
    }
    if (swept) return OF_SWEPT * energy + OF_LEAST * least;
    for (int k = 0; k < joints->joint_rows; k++)
        if (!pinch_row_may_drive(&problem->rows[k])) asked_for += energy_asked_for(problem, &problem->rows[k]);
    return OF_EXACT * energy + OF_LEAST * least + TIMES_ASKED_FOR * asked_for;
}

double pinch_joint_work(const pinch_island_joints *joints, const pinch_problem *problem, bool swept, double slowest)
{
    work sum = {0, 0};
    /* over all rows, because the forces of rows that contradict each other are huge and cancel */
    for (int k = 0; k < joints->joint_rows; k++) {
        bool drives = pinch_row_may_drive(&problem->rows[k]);
        work part = row_work(problem, &problem->rows[k]);
        if (part.by_mean < 0 || !drives) sum.by_mean += part.by_mean;
        if (part.by_end < 0 || !drives) sum.by_end += part.by_end;
    }
    double most = sum.by_end < sum.by_mean ? sum.by_end : sum.by_mean;
    if (most <= 0) return 0;
    return most / tolerated_work(joints, problem, swept, slowest);
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
