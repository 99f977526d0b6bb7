/*
 * The rows that ODE will solve for a joint: directions of no motion, motors, stops.
 *
 * ODE enforces the joints itself. The contact solver needs their rows to know what mass a finger on a hinge or slider
 * really has. They are read from ODE's public getters, which leaves gaps:
 *
 *   - The errors that ODE corrects in position rows come from the anchors. ODE has no getters for a hinge's axis in its
 *     second body, and for the relative pose that sliders, fixed and hinge-2 joints keep. hinge_reference.h finds the
 *     first out; joint_pose.h notes the second where it is set. Where it was not noted, the errors, which are zero at
 *     rest, are left out, and the rows ask for no relative motion.
 *   - A linear motor's getter returns its axis without saying in which frame it is fixed. It is taken as the world's,
 *     which is wrong for an axis that turns with a body.
 *   - A plane joint's motors have no getters at all.
 *
 * What these gaps leave is reported as the step mismatch; `exact` tells which joints it cannot come from.
 */
#ifndef PINCH_JOINTS_JOINT_ROWS_H
#define PINCH_JOINTS_JOINT_ROWS_H

#include "joints/joint_pose.h"
#include "step_context.h"

enum { PINCH_JOINT_MAX_ROWS = 9 };

typedef struct pinch_joint_rows {
    int count;
    bool exact;           /* these rows are all that ODE would solve for the joint, the correction of errors included */
    pinch_joint_row *row; /* room for PINCH_JOINT_MAX_ROWS; body1 stands for the joint's first body with j1, body2 for
                           * its second; the indices are not set */
    double applied[2][6]; /* wrench that ODE adds to the two bodies itself (a motor against its stop) */
} pinch_joint_rows;

/* Finds the bodies of a joint as pinch_joint_bodies does. Returns false also for a joint of a type that has no rows
 * here: contact joints, null joints and types without getters. */
bool pinch_modelled_joint_bodies(dJointID joint, dBodyID body[2]);

/* Computes the rows of an enabled joint that has some, with its bodies as above. axis2: a hinge's axis in the frame of
 * body[1] (of the world without one); pose: what pinch_joint_pose_of knows; both NULL where they are not known. */
void pinch_joint_rows_of(const pinch_step_context *context, dJointID joint, const dBodyID body[2], const double *axis2,
                         const pinch_joint_pose *pose, pinch_joint_rows *rows);

#endif
