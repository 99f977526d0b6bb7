/*
 * The rows that ODE will solve for a joint: directions of no motion, motors, stops.
 *
 * The contact solver needs them to know what mass a finger on a hinge or slider really has, and finds the joint's
 * forces with them. They are read from ODE's public getters, and from what joint_pose.h has noted where there is none.
 * What is not known is left out: errors of position, which are zero at rest, and motors. `exact` tells the rows in
 * which nothing is missing.
 */
#ifndef PINCH_JOINTS_JOINT_ROWS_H
#define PINCH_JOINTS_JOINT_ROWS_H

#include "joints/joint_pose.h"
#include "step_context.h"

enum { PINCH_JOINT_MAX_ROWS = 11 }; /* nine of its own, two of servos */

typedef struct pinch_joint_rows {
    int count;
    bool exact;           /* these rows are all that ODE would solve for the joint, the correction of errors included */
    pinch_joint_row *row; /* room for PINCH_JOINT_MAX_ROWS; body1 stands for the joint's first body with j1, body2 for
                           * its second; the indices are not set */
    double error, error_angle; /* m, rad: the largest errors of position that they take back; stops, motors and springs
                                * have none */
    unsigned driven;           /* bit k: row k is a motor's, and its rhs a speed */
    bool applies;              /* a motor runs against its stop, and ODE adds a wrench to the two bodies itself: */
    double applied[2][6];      /* in that case, this one */
    pinch_axis_reading *reading; /* a hinge's axis has been read by then, and its rows read the angle where they need
                                  * it, which is not quick; those of a slider read all */
} pinch_joint_rows;

/* Finds the bodies of a joint as pinch_joint_bodies does. Returns false also for a joint of a type that has no rows
 * here: contact joints, null joints and types without getters. */
bool pinch_modelled_joint_bodies(dJointID joint, dBodyID body[2]);

/* Computes the rows of an enabled joint that has some, with its bodies as above. axis2: a hinge's axis in the frame of
 * body[1] (of the world without one), for where it was not noted; pose: what pinch_joint_pose_of knows; both may be
 * NULL. A transmission's pose takes up where ODE will measure its wheels from. */
void pinch_joint_rows_of(const pinch_step_context *context, dJointID joint, const dBodyID body[2], const double *axis2,
                         pinch_joint_pose *pose, pinch_joint_rows *rows);

#endif
