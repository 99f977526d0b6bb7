/*
 * Fixed joints, sliders and hinge-2 joints keep the relative pose that they were made in, for which ODE has no getters.
 * ODE takes it when their axes are set (dJointSetFixed, dJointSetSliderAxis, dJointSetHinge2Axes and its older forms),
 * for a slider and a hinge-2 also when they are attached. Whoever sees these calls can note the pose here.
 */
#ifndef PINCH_JOINTS_JOINT_POSE_H
#define PINCH_JOINTS_JOINT_POSE_H

#include "util/list.h"

#include <ode/ode.h>

/*
 * Finds the bodies that a joint's j1 and j2 act on: body[1] may be NULL, body[0] not. Returns false for a joint without
 * bodies.
 */
bool pinch_joint_bodies(dJointID joint, dBodyID body[2]);

/* The bodies are those of pinch_joint_bodies. */
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
    pinch_joint_pose *items;
    int count, room;
    pinch_item_index index;
} pinch_joint_poses;

/* Reads the pose that the joint's bodies have now. Returns false for a joint of another type or without bodies. */
bool pinch_joint_pose_now(dJointID joint, pinch_joint_pose *pose);
/* Keeps a pose in place of what was known of its joint. The pose stays unknown where memory runs out. */
void pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose);
/* Returns NULL where no pose is known for these bodies and a joint of this type; another joint may be where a destroyed
 * one was. */
const pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2]);
/* Reads a hinge-2's axes, unit vectors of the world, and axis1 x axis2. Returns its length, the sine of their angle. */
double pinch_hinge2_axes(dJointID joint, double axis1[4], double axis2[4], double normal[3]);
void pinch_joint_poses_free(pinch_joint_poses *poses);

#endif
