#include "joints/joint_pose.h"

#include "support/vec3.h"

#include <stdlib.h>
#include <string.h>

bool pinch_joint_bodies(dJointID joint, dBodyID body[2])
{
    body[0] = dJointGetBody(joint, 0);
    body[1] = dJointGetBody(joint, 1);
    if (!body[0]) {
        body[0] = body[1];
        body[1] = NULL;
    }
    return body[0];
}

static int find(const pinch_joint_poses *poses, dJointID joint)
{
    return pinch_item_index_get(&poses->index, PINCH_ITEM_KEYS(*poses, pinch_joint_pose, joint), &joint);
}

static bool keeps_pose(dJointType type)
{
    return type == dJointTypeFixed || type == dJointTypeSlider || type == dJointTypeHinge2;
}

double pinch_hinge2_axes(dJointID joint, double axis1[4], double axis2[4], double normal[3])
{
    dJointGetHinge2Axis1(joint, axis1);
    dJointGetHinge2Axis2(joint, axis2);
    pinch_v3_cross(axis1, axis2, normal);
    return pinch_v3_norm(normal);
}

static void read_axes(pinch_joint_pose *pose)
{
    dVector3 axis1, axis2;
    double normal[3];
    pose->sine = pinch_hinge2_axes(pose->joint, axis1, axis2, normal);
    pose->cosine = pinch_v3_dot(axis1, axis2);
}

static void read_relative_pose(pinch_joint_pose *pose, dJointType type)
{
    static const dQuaternion world = {1, 0, 0, 0};
    dBodyID a = pose->body[0], b = pose->body[1];
    double d[3];
    pinch_v3_copy(d, dBodyGetPosition(a));
    dQMultiply1(pose->turn, dBodyGetQuaternion(a), b ? dBodyGetQuaternion(b) : world);
    if (b) {
        pinch_v3_add_scaled(d, -1, dBodyGetPosition(b));
        dBodyVectorFromWorld(type == dJointTypeFixed ? a : b, d[0], d[1], d[2], pose->offset);
    } else {
        pinch_v3_copy(pose->offset, d);
    }
}

bool pinch_joint_pose_now(dJointID joint, pinch_joint_pose *pose)
{
    dJointType type = dJointGetType(joint);
    memset(pose, 0, sizeof *pose);
    pose->joint = joint;
    pose->type = type;
    if (!keeps_pose(type) || !pinch_joint_bodies(joint, pose->body)) return false;
    if (type == dJointTypeHinge2)
        read_axes(pose);
    else
        read_relative_pose(pose, type);
    return true;
}

void pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose)
{
    int index = find(poses, pose->joint);
    if (index < 0) {
        index = poses->count;
        if (!PINCH_RESERVE(*poses, index + 1) ||
            !pinch_item_index_add(&poses->index, PINCH_ITEM_KEYS(*poses, pinch_joint_pose, joint), &pose->joint, index))
            return;
        poses->count++;
    }
    poses->items[index] = *pose;
}

const pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2])
{
    int index = find(poses, joint);
    if (index < 0) return NULL;
    const pinch_joint_pose *pose = &poses->items[index];
    bool same = pose->type == dJointGetType(joint) && pose->body[0] == body[0] && pose->body[1] == body[1];
    return same ? pose : NULL;
}

void pinch_joint_poses_free(pinch_joint_poses *poses)
{
    pinch_item_index_free(&poses->index);
    free(poses->items);
    memset(poses, 0, sizeof *poses);
}
