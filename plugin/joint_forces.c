/*
 * The forces of joints from Pinch's own solve. Where every row that acts on an island's bodies is known in full, its
 * multipliers are what ODE would have to find once more: they go to the bodies with the contact forces, the joints are
 * switched off while ODE steps, and ODE integrates. The program finds its joints as it left them, with the forces where
 * it asked for them (dJointSetFeedback).
 */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* What is left of a row beside the others it depends on (pinch_joint_row.pivot): below, ODE's own compliance decides
 * how the rows share what they carry. */
static const double INDEPENDENT = 1e-3;
/* Error of a row's law, relative to the velocities in it. */
static const double LAW_TOLERANCE = 1e-8;

static double row_velocity(const pinch_ode *p, const pinch_island *island, const pinch_joint_row *row, double *size)
{
    const int body[2] = {row->body1, row->body2};
    const double *j[2] = {row->j1, row->j2};
    double sum = 0;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const double *v = p->core_bodies.items[island->first_body + body[side]].velocity_end;
        for (int i = 0; i < 6; i++) {
            sum += j[side][i] * v[i];
            *size += fabs(j[side][i] * v[i]);
        }
    }
    return sum;
}

/* Does the row's law hold for what was solved? Checked here from the velocities, whatever solved it. */
static bool row_holds(const pinch_ode *p, const pinch_island *island, const pinch_joint_row *row)
{
    double size = fabs(row->rhs), v = row_velocity(p, island, row, &size), give = row->cfm * row->force;
    double missing = row->rhs - v - give, allowed = LAW_TOLERANCE * (size + fabs(give)) + 1e-12;
    bool hard = row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
    if ((hard && !(row->pivot >= INDEPENDENT)) || !isfinite(row->force)) return false;
    /* too slow only where the force is at its upper limit, too fast only at its lower */
    if (missing > allowed) return row->force >= row->high * (1 - LAW_TOLERANCE * copysign(1, row->high));
    if (missing < -allowed) return row->force <= row->low * (1 + LAW_TOLERANCE * copysign(1, row->low));
    return true;
}

/* Which step joint is it, if this joint's rows are known in full? -1: none. */
static int known_joint(const pinch_ode *p, dJointID joint)
{
    int index = pinch_key_map_get(&p->joint_index, (uint64_t)(uintptr_t)joint);
    if (index < 0 || index >= p->joints.count || p->joints.items[index].joint != joint) return -1;
    return p->joints.items[index].rows.exact ? index : -1;
}

/* Does nothing act on the island's bodies that ODE would have to solve, but joints whose rows are known? Marks those.
 */
static bool all_known(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        const pinch_step_body *b = &p->bodies.items[p->body_of.items[island->first_body + k]];
        int joints = b->drive < 0 ? dBodyGetNumJoints(b->body) : 0;
        for (int i = 0; i < joints; i++) {
            dJointID joint = dBodyGetJoint(b->body, i);
            if (!dJointIsEnabled(joint) || dJointGetType(joint) == dJointTypeNull) continue;
            int index = known_joint(p, joint);
            if (index < 0) return false;
            p->joints.items[index].met = true;
        }
    }
    for (int k = 0; k < island->row_count; k++)
        if (!row_holds(p, island, &p->core_rows.items[island->first_row + k])) return false;
    return true;
}

static pinch_island *island_of(pinch_ode *p, const pinch_step_joint *joint)
{
    int body = joint->body[0] >= 0 ? joint->body[0] : joint->body[1];
    return body < 0 ? NULL : &p->islands.items[p->bodies.items[body].parent];
}

/* The joint's force and torque on the two bodies it was attached to. */
static void sum_rows(const pinch_ode *p, const pinch_step_joint *joint, double wrench[2][6])
{
    memset(wrench, 0, sizeof(double[2][6]));
    for (int k = 0; k < joint->rows.count; k++) {
        const pinch_joint_row *row = &joint->rows.row[k];
        double force = p->core_rows.items[joint->first_row + k].force;
        for (int i = 0; i < 6; i++) {
            wrench[0][i] += force * row->j1[i];
            wrench[1][i] += force * row->j2[i];
        }
    }
}

/* ODE's feedback: what its rows exert, first on the joint's first body that is one; not what its motors add besides. */
static void give_feedback(dJointID joint, double wrench[2][6])
{
    dJointFeedback *feedback = dJointGetFeedback(joint);
    if (!feedback) return;
    pinch_v3_copy(feedback->f1, wrench[0]);
    pinch_v3_copy(feedback->t1, wrench[0] + 3);
    if (!dJointGetBody(joint, 0) || !dJointGetBody(joint, 1)) return;
    pinch_v3_copy(feedback->f2, wrench[1]);
    pinch_v3_copy(feedback->t2, wrench[1] + 3);
}

static void take_over(pinch_ode *p, pinch_step_joint *joint)
{
    double wrench[2][6];
    sum_rows(p, joint, wrench);
    give_feedback(joint->joint, wrench);
    for (int side = 0; side < 2; side++) {
        if (joint->body[side] < 0) continue;
        dBodyID body = p->bodies.items[joint->body[side]].body;
        for (int i = 0; i < 6; i++) wrench[side][i] += joint->rows.applied[side][i];
        dBodyAddForce(body, wrench[side][0], wrench[side][1], wrench[side][2]);
        dBodyAddTorque(body, wrench[side][3], wrench[side][4], wrench[side][5]);
    }
    dJointDisable(joint->joint);
    joint->disabled = true;
    p->stats.joints_solved++;
}

void pinch_joint_forces_give(pinch_ode *p)
{
    if (p->joints.count == 0) return;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        /* where bodies may go to sleep, ODE has to see what ties them */
        island->takes_joints = island->solved && !island->may_sleep && island->row_count > 0 &&
                               !p->settings.joints_by_ode && all_known(p, island);
    }
    for (int k = 0; k < p->joints.count; k++) { /* a joint that is gone since the solve leaves its island to ODE */
        pinch_island *island = island_of(p, &p->joints.items[k]);
        if (island && !p->joints.items[k].met) island->takes_joints = false;
    }
    for (int k = 0; k < p->joints.count; k++) {
        pinch_step_joint *joint = &p->joints.items[k];
        const pinch_island *island = island_of(p, joint);
        if (island && island->takes_joints)
            take_over(p, joint);
        else if (island && island->solved)
            p->stats.joints_left++;
    }
}

void pinch_joint_forces_end(pinch_ode *p)
{
    for (int k = 0; k < p->joints.count; k++) {
        if (p->joints.items[k].disabled) dJointEnable(p->joints.items[k].joint);
        p->joints.items[k].disabled = false;
    }
}
