/*
 * The rows that ODE will solve for a joint, from its public getters: directions of no motion, motors, stops. ODE
 * enforces the joints itself; the contact solver needs them to know what mass a finger on a hinge or slider really has.
 *
 * The errors that ODE corrects in position rows come from the anchors; it has no getters for orientation errors, which
 * at rest are zero: those rows ask for no relative rotation. A linear motor's getter returns its axis in the frame that
 * it is fixed in without saying in which: it is taken as the world's, which is wrong for an axis that turns with a
 * body. What this leaves is reported as the step mismatch.
 */
#ifndef PINCH_PLUGIN_JOINTS_H
#define PINCH_PLUGIN_JOINTS_H

#include <ode/ode.h>
#include <pinch/problem.h>

enum { PINCH_JOINT_MAX_ROWS = 9 };

typedef struct pinch_joint_rows {
    int count;
    pinch_joint_row
        row[PINCH_JOINT_MAX_ROWS]; /* body1: the joint's first body with j1, body2: its second; indices unset */
    double applied[2][6];          /* wrench that ODE adds to the two bodies itself (a motor against its stop) */
} pinch_joint_rows;

/*
 * The rows of an enabled joint for a step h. body[0], body[1]: the bodies j1 and j2 act on; body[1] may be NULL,
 * body[0] not. False for a joint type that has no rows here (contact joints, null joints and types without getters).
 */
bool pinch_joint_rows_of(dJointID joint, dWorldID world, double h, dBodyID body[2], pinch_joint_rows *rows);

#endif
