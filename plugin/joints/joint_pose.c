#include "joints/joint_pose.h"

#include "joints/joint_rows.h"

#include "support/vec3.h"

#include <stdlib.h>
#include <string.h>

static uint64_t key_of(dJointID joint)
{
    return (uint64_t)(uintptr_t)joint;
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

static void note_axes(pinch_joint_pose *pose)
{
    dVector3 axis1, axis2;
    double normal[3];
    pose->sine = pinch_hinge2_axes(pose->joint, axis1, axis2, normal);
    pose->cosine = pinch_v3_dot(axis1, axis2);
}

/* turn and offset */
static void note_placing(pinch_joint_pose *pose, dJointType type)
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
        note_axes(pose);
    else
        note_placing(pose, type);
    return true;
}

void pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose)
{
    int index = pinch_key_map_get(&poses->index, key_of(pose->joint));
    if (index < 0) {
        if (poses->count == poses->room) {
            int room = 2 * poses->room + 8;
            pinch_joint_pose *moved = realloc(poses->items, (size_t)room * sizeof *moved);
            if (!moved) return;
            poses->items = moved;
            poses->room = room;
        }
        if (!pinch_key_map_add(&poses->index, key_of(pose->joint), poses->count)) return;
        index = poses->count++;
    }
    poses->items[index] = *pose;
}

const pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2])
{
    int index = poses->count > 0 ? pinch_key_map_get(&poses->index, key_of(joint)) : -1;
    if (index < 0) return NULL;
    const pinch_joint_pose *pose = &poses->items[index];
    bool same = pose->type == dJointGetType(joint) && pose->body[0] == body[0] && pose->body[1] == body[1];
    return same ? pose : NULL;
}

void pinch_joint_poses_free(pinch_joint_poses *poses)
{
    pinch_key_map_free(&poses->index);
    free(poses->items);
    memset(poses, 0, sizeof *poses);
}
