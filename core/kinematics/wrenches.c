#include "kinematics/wrenches.h"

#include "support/dense.h"

#include <string.h>

static void add_wrench(const pinch_problem *problem, int body, const double *point, const double *force,
                       const double *couple, double sign, double *wrench)
{
    if (body < 0) return;
    double arm[3], *f = wrench + 6 * body;
    for (int i = 0; i < 3; i++) {
        arm[i] = point[i] - problem->bodies[body].position[i];
        f[i] += sign * force[i];
        f[3 + i] += sign * couple[i];
    }
    f[3] += sign * (arm[1] * force[2] - arm[2] * force[1]);
    f[4] += sign * (arm[2] * force[0] - arm[0] * force[2]);
    f[5] += sign * (arm[0] * force[1] - arm[1] * force[0]);
}

static void contact_wrenches(const pinch_problem *problem, double *wrench)
{
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        const double *n = c->normal, *t = c->tangent1, *r = c->force;
        double t2[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
        double force[3], couple[3];
        for (int i = 0; i < 3; i++) {
            force[i] = n[i] * r[0] + t[i] * r[1] + t2[i] * r[2];
            couple[i] = n[i] * r[3] + t[i] * c->rolling_moment[0] + t2[i] * c->rolling_moment[1];
        }
        add_wrench(problem, c->body1, c->position, force, couple, 1, wrench);
        add_wrench(problem, c->body2, c->position, force, couple, -1, wrench);
    }
}

static void row_wrenches(const pinch_problem *problem, const pinch_mobility *mobility, double *wrench)
{
    for (int k = 0; k < mobility->remaining_count; k++) {
        const pinch_joint_row *row = &problem->rows[mobility->remaining[k]];
        if (row->body1 >= 0) pinch_add_multiple6(row->force, row->j1, wrench + 6 * row->body1);
        if (row->body2 >= 0) pinch_add_multiple6(row->force, row->j2, wrench + 6 * row->body2);
    }
}

void pinch_joint_forces(pinch_problem *problem, const pinch_mobility *mobility, double *scratch)
{
    if (mobility->eliminated_count == 0) return;
    memset(scratch, 0, sizeof(double) * 6 * (size_t)problem->body_count);
    contact_wrenches(problem, scratch);
    row_wrenches(problem, mobility, scratch);
    pinch_mobility_joint_forces(mobility, problem, scratch);
}
