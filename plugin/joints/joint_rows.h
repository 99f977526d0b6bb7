/*
 * The rows that ODE will solve for a joint, from its public getters: directions of no motion, motors, stops. ODE
 * enforces the joints itself; the contact solver needs them to know what mass a finger on a hinge or slider really has.
 *
 * The errors that ODE corrects in position rows come from the anchors. For a hinge's axis in its second body, and for
 * what sliders, fixed and hinge-2 joints keep of a relative pose, it has no getters: the hinge's is found by other
 * means (joint_reference.h), the others' is noted where it is set (joint_pose.h); where it was not, the errors, which
 * at rest are zero, are left out: those rows ask for no relative motion. A linear motor's getter returns its axis in
 * the frame that it is fixed in without saying in which: it is taken as the world's, which is wrong for an axis that
 * turns with a body. A plane joint's motors have no getters at all. What this leaves is reported as the step mismatch;
 * `exact` tells which joints it cannot come from.
 */
#ifndef PINCH_PLUGIN_JOINTS_H
#define PINCH_PLUGIN_JOINTS_H

#include "joints/joint_pose.h"

#include <pinch/problem.h>

enum { PINCH_JOINT_MAX_ROWS = 9 };

typedef struct pinch_joint_rows {
    int count;
    bool exact;           /* they are all that ODE would solve for this joint, the correction of its errors included */
    pinch_joint_row *row; /* room for PINCH_JOINT_MAX_ROWS; body1: the joint's first body with j1, body2: its second;
                           * indices unset */
    double applied[2][6]; /* wrench that ODE adds to the two bodies itself (a motor against its stop) */
} pinch_joint_rows;

/*
 * The bodies that a joint's j1 and j2 act on: body[1] may be NULL, body[0] not. False for a joint without bodies or of
 * a type that has no rows here (contact joints, null joints and types without getters).
 */
bool pinch_joint_bodies(dJointID joint, dBodyID body[2]);

/* The rows of an enabled joint that has some, with its bodies as above, for a step h. axis2: a hinge's axis in the
 * frame of body[1] (of the world without one); pose: what pinch_joint_pose_of knows. NULL where it is not known. */
void pinch_joint_rows_of(dJointID joint, const dBodyID body[2], dWorldID world, double h, const double *axis2,
                         const pinch_joint_pose *pose, pinch_joint_rows *rows);

#endif
