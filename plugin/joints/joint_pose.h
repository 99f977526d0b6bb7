/*
 * What fixed joints, sliders and hinge-2 joints keep of the relative pose they were made in, for which ODE has no
 * getters. ODE takes it when their axes are set (dJointSetFixed, dJointSetSliderAxis, dJointSetHinge2Axes and its older
 * forms), for a slider and a hinge-2 also when they are attached: whoever sees these calls can note it.
 */
#ifndef PINCH_PLUGIN_JOINT_POSE_H
#define PINCH_PLUGIN_JOINT_POSE_H

#include "util/key_map.h"

#include <ode/ode.h>

/* Bodies as in pinch_joint_bodies. */
typedef struct pinch_joint_pose {
    dJointID joint;
    dJointType type;
    dBodyID body[2];
    dVector3 offset;     /* x1 - x2: in the first body's frame for a fixed joint, in the second's for a slider; x1 where
                          * there is no second body */
    dQuaternion turn;    /* q1^-1 q2 */
    double cosine, sine; /* of the angle between a hinge-2's axes; 0 for others */
} pinch_joint_pose;

typedef struct pinch_joint_poses {
    pinch_key_map index;
    pinch_joint_pose *items;
    int count, room;
} pinch_joint_poses;

/* The pose that the joint's bodies have now; false: it is no such joint, or has no body. */
bool pinch_joint_pose_now(dJointID joint, pinch_joint_pose *pose);
/* In place of what was known of this joint. Memory that ran out leaves it unknown. */
void pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose);
/* NULL: not known for these bodies and a joint of this type; another one may be where a destroyed one was */
const pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2]);
/* A hinge-2's axes now, unit vectors of the world, axis1 x axis2, and how long that is: the sine of their angle. */
double pinch_hinge2_axes(dJointID joint, double axis1[4], double axis2[4], double normal[3]);
void pinch_joint_poses_free(pinch_joint_poses *poses);

#endif
