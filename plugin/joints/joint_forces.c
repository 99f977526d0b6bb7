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

/* Which step joint is it, if this joint's rows are known in full? -1: none. */
static int known_joint(const pinch_ode *p, dJointID joint)
{
    int index = pinch_item_index_get(&p->joint_index, pinch_joint_keys(p), pinch_key_of_pointer(joint));
    return index >= 0 && p->joints.items[index].exact ? index : -1;
}

/* Does nothing act on the island's bodies that ODE would have to solve, but joints whose rows are known? And are all
 * that were solved still there? */
static bool all_known(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive >= 0) continue;
        int joints = dBodyGetNumJoints(b->body);
        for (int i = pinch_first_joint(b); i < joints; i++) {
            dJointID joint = dBodyGetJoint(b->body, i);
            if (!dJointIsEnabled(joint) || dJointGetType(joint) == dJointTypeNull) continue;
            int index = known_joint(p, joint);
            if (index < 0) return false;
            p->joints.items[index].met = true;
        }
    }
    for (int k = 0; k < island->joint_count; k++)
        if (!pinch_island_joint(p, island, k)->met) return false;
    return true;
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

static void take_over(const pinch_ode *p, pinch_step_joint *joint, double h)
{
    double applied[2][6] = {{0}};
    if (joint->applies) pinch_joint_applied(p, joint, h, applied);
    give_feedback(joint->joint, joint->wrench);
    for (int side = 0; side < 2; side++) {
        if (joint->body[side] < 0) continue;
        dBodyID body = p->bodies.items[joint->body[side]].body;
        double w[6];
        for (int i = 0; i < 6; i++) w[i] = joint->wrench[side][i] + applied[side][i];
        dBodyAddForce(body, w[0], w[1], w[2]);
        dBodyAddTorque(body, w[3], w[4], w[5]);
    }
    dJointDisable(joint->joint);
}

void pinch_take_joints_again(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->joint_count; k++) {
        pinch_step_joint *joint = pinch_island_joint(p, island, k);
        give_feedback(joint->joint, joint->wrench);
        dJointDisable(joint->joint);
    }
}

void pinch_give_joint_forces(pinch_ode *p, pinch_island *island, double h)
{
    island->takes_joints = island->solved && island->row_count > 0 && island->rows_hold && !p->settings.joints_by_ode &&
                           all_known(p, island);
    for (int k = 0; k < island->joint_count && island->takes_joints; k++)
        take_over(p, pinch_island_joint(p, island, k), h);
}

void pinch_enable_joints(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->joint_count && island->takes_joints; k++)
        dJointEnable(pinch_island_joint(p, island, k)->joint);
}
