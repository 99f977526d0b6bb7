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

static pinch_item_keys keys_of(const pinch_joint_poses *poses)
{
    return PINCH_ITEM_KEYS(*poses, pinch_joint_pose, joint);
}

static int find(const pinch_joint_poses *poses, dJointID joint)
{
    return pinch_item_index_get(&poses->index, keys_of(poses), &joint);
}

/* Returns what a joint of this type keeps of the pose that its bodies have. */
static unsigned kept_of_pose(dJointType type)
{
    switch (type) {
    case dJointTypeFixed:
    case dJointTypeSlider:
    case dJointTypePR:
        return PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET;
    case dJointTypePU:
        return PINCH_KNOWS_OFFSET;
    case dJointTypeHinge:
    case dJointTypeHinge2:
    case dJointTypePiston:
    case dJointTypeDHinge:
    case dJointTypeAMotor:
        return PINCH_KNOWS_TURN;
    case dJointTypeTransmission:
        return PINCH_KNOWS_MESH;
    default:
        return 0;
    }
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
    dQtoR(pose->turn, pose->rotation);
    if (b) {
        pinch_v3_add_scaled(d, -1, dBodyGetPosition(b));
        dBodyVectorFromWorld(type == dJointTypeFixed ? a : b, d[0], d[1], d[2], pose->offset);
    } else {
        pinch_v3_copy(pose->offset, d);
    }
}

/* Reads the anchor of a joint with a prismatic axis in the first body's frame. ODE shows that in the second's, and how
 * far the two are apart along the axis. */
static void read_prismatic_anchor(pinch_joint_pose *pose)
{
    dVector3 anchor, axis;
    bool universal = pose->type == dJointTypePU, mirrored = !dJointGetBody(pose->joint, 0);
    double apart = universal ? dJointGetPUPosition(pose->joint) : dJointGetPRPosition(pose->joint);
    if (universal) {
        dJointGetPUAnchor(pose->joint, anchor);
        dJointGetPUAxisP(pose->joint, axis);
    } else {
        dJointGetPRAnchor(pose->joint, anchor);
        dJointGetPRAxis1(pose->joint, axis);
    }
    double d[3];
    pinch_v3_sub(anchor, dBodyGetPosition(pose->body[0]), d);
    pinch_v3_add_scaled(d, mirrored ? -apart : apart, axis);
    dBodyVectorFromWorld(pose->body[0], d[0], d[1], d[2], pose->offset);
}

bool pinch_joint_reversed(dJointID joint, const dBodyID body[2])
{
    return !body[1] && !dJointGetBody(joint, 0);
}

void pinch_read_hinge(dJointID hinge, const dBodyID body[2], pinch_axis_reading *reading)
{
    reading->reversed = pinch_joint_reversed(hinge, body);
    dJointGetHingeAxis(hinge, reading->axis);
    dBodyVectorFromWorld(body[0], reading->axis[0], reading->axis[1], reading->axis[2], reading->own);
    reading->known = true;
    reading->slides = reading->placed = false;
}

bool pinch_hinge_pose_holds(const pinch_joint_pose *pose, const pinch_axis_reading *reading)
{
    static const double SAME = 1e-9;
    double change[3];
    if (!(pose->known & PINCH_KNOWS_TURN)) return false;
    pinch_v3_sub(reading->own, pose->axis1, change);
    return pinch_v3_norm(change) < SAME;
}

bool pinch_joint_pose_now(dJointID joint, pinch_joint_pose *pose)
{
    dJointType type = dJointGetType(joint);
    memset(pose, 0, sizeof *pose);
    pose->joint = joint;
    pose->type = type;
    pose->known = kept_of_pose(type);
    pose->axis_length = 1;
    if (!pose->known || !pinch_joint_bodies(joint, pose->body)) return false;
    if (type == dJointTypeHinge2)
        read_axes(pose);
    else if (type == dJointTypeTransmission)
        pose->mesh.meshed = -1;
    else
        read_relative_pose(pose, type);
    if (type == dJointTypePR || type == dJointTypePU) read_prismatic_anchor(pose);
    if (type != dJointTypeHinge) return true;
    pinch_axis_reading reading;
    pinch_read_hinge(joint, pose->body, &reading);
    pinch_v3_copy(pose->axis1, reading.own);
    return true;
}

/* ---- what is kept ---- */

/* What does not depend on the bodies, as it may be set before the joint is attached. */
static bool stays_with_joint(dJointType type)
{
    return type == dJointTypePlane2D || type == dJointTypeLMotor;
}

/* Returns the record of a joint, which has one from now on; NULL when memory runs out. */
static pinch_joint_pose *record_of(pinch_joint_poses *poses, dJointID joint)
{
    int index = find(poses, joint);
    if (index >= 0) return &poses->items[index];
    index = poses->count;
    if (!PINCH_RESERVE(*poses, index + 1) || !pinch_item_index_add(&poses->index, keys_of(poses), &joint, index))
        return NULL;
    memset(&poses->items[index], 0, sizeof *poses->items);
    poses->items[index].joint = joint;
    poses->count++;
    return &poses->items[index];
}

/* Tells whether the body was forgotten after the pose was noted. */
static bool is_forgotten(const pinch_joint_poses *poses, const pinch_joint_pose *pose, dBodyID body)
{
    return body && pinch_key_map_get(&poses->forgotten, (uintptr_t)body) > pose->noted;
}

static void drop_noted(pinch_joint_pose *pose)
{
    pose->known = 0;
    pose->body[0] = pose->body[1] = NULL; /* a joint that ties something has a first body */
}

static void drop_if_forgotten(const pinch_joint_poses *poses, pinch_joint_pose *pose)
{
    if (stays_with_joint(pose->type) || poses->forgotten_count == 0) return;
    if (is_forgotten(poses, pose, pose->body[0]) || is_forgotten(poses, pose, pose->body[1])) drop_noted(pose);
}

void pinch_joint_poses_drop_forgotten(pinch_joint_poses *poses)
{
    if (poses->forgotten_count == 0) return;
    for (int k = 0; k < poses->count; k++) {
        drop_if_forgotten(poses, &poses->items[k]);
        poses->items[k].noted = 0;
    }
    poses->forgotten_count = 0;
    pinch_key_map_clear(&poses->forgotten);
}

bool pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose)
{
    pinch_joint_pose *record = record_of(poses, pose->joint);
    if (!record) return false;
    drop_if_forgotten(poses, record);
    pinch_joint_pose was = *record;
    bool same = was.type == pose->type && was.body[0] == pose->body[0] && was.body[1] == pose->body[1];
    *record = *pose;
    record->noted = poses->forgotten_count;
    unsigned still = same ? was.known & ~pose->known : 0;
    if (still & PINCH_KNOWS_TURN) {
        memcpy(record->turn, was.turn, sizeof was.turn);
        memcpy(record->rotation, was.rotation, sizeof was.rotation);
        record->axis_length = was.axis_length;
        memcpy(record->axis1, was.axis1, sizeof was.axis1);
    }
    if (still & PINCH_KNOWS_OFFSET) memcpy(record->offset, was.offset, sizeof was.offset);
    record->known |= still;
    return true;
}

void pinch_joint_pose_forget(pinch_joint_poses *poses, dJointID joint, unsigned things)
{
    int index = find(poses, joint);
    if (index >= 0) poses->items[index].known &= ~things;
}

void pinch_joint_poses_forget_body(pinch_joint_poses *poses, dBodyID body)
{
    if (poses->forgotten_count >= poses->count) pinch_joint_poses_drop_forgotten(poses); /* where nobody reads them */
    if (poses->count == 0) return;
    if (pinch_key_map_set(&poses->forgotten, (uintptr_t)body, poses->forgotten_count + 1)) {
        poses->forgotten_count++;
        return;
    }
    for (int k = 0; k < poses->count; k++) { /* no memory for the name */
        pinch_joint_pose *pose = &poses->items[k];
        if (!stays_with_joint(pose->type) && (pose->body[0] == body || pose->body[1] == body)) drop_noted(pose);
    }
}

void pinch_joint_poses_forget_joint(pinch_joint_poses *poses, dJointID joint)
{
    int index = find(poses, joint);
    if (index >= 0) poses->items[index] = (pinch_joint_pose){.joint = joint};
}

bool pinch_joint_is_new(pinch_joint_poses *poses, dJointID joint, dJointType type, double cfm)
{
    pinch_joint_pose *record = record_of(poses, joint);
    if (!record) return false;
    memset(record, 0, sizeof *record);
    record->joint = joint;
    record->type = type;
    if (type != dJointTypePlane2D) return true;
    record->known = PINCH_KNOWS_MOTORS;
    for (int i = 0; i < 3; i++) record->motor[i].cfm = cfm;
    return true;
}

bool pinch_note_motor_frame(pinch_joint_poses *poses, dJointID joint, int axis, int frame)
{
    if (axis < 0 || axis > 2 || frame < 0 || frame > 2) return false;
    pinch_joint_pose *record = record_of(poses, joint);
    if (!record) return true;
    if (record->type != dJointTypeLMotor) (void)pinch_joint_is_new(poses, joint, dJointTypeLMotor, 0);
    bool second = dJointGetBody(joint, 0) && dJointGetBody(joint, 1);
    record->frame[axis] = frame == 2 && !second ? 1 : frame; /* as ODE takes it */
    record->known |= (unsigned)PINCH_KNOWS_FRAME << axis;
    return true;
}

bool pinch_note_plane_motor(pinch_joint_poses *poses, dJointID joint, int motor, int parameter, double value)
{
    int index = find(poses, joint);
    if (motor < 0 || motor > 2) return false;
    if (index < 0 || !(poses->items[index].known & PINCH_KNOWS_MOTORS)) return true;
    pinch_plane_motor *m = &poses->items[index].motor[motor];
    if (parameter == dParamVel) m->velocity = value;
    if (parameter == dParamFMax && value >= 0) m->fmax = value;
    if (parameter == dParamCFM) m->cfm = value;
    return true;
}

bool pinch_joint_is_noted(const pinch_joint_poses *poses, dJointID joint)
{
    int index = find(poses, joint);
    return index >= 0 && poses->items[index].type != dJointTypeNone;
}

pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2], int *hint)
{
    int index = pinch_item_index_find(&poses->index, keys_of(poses), &joint, hint);
    if (index < 0) return NULL;
    pinch_joint_pose *pose = &poses->items[index];
    bool same = pose->type == dJointGetType(joint) &&
                (stays_with_joint(pose->type) || (pose->body[0] == body[0] && pose->body[1] == body[1]));
    return same ? pose : NULL;
}

void pinch_joint_poses_free(pinch_joint_poses *poses)
{
    pinch_item_index_free(&poses->index);
    pinch_key_map_free(&poses->forgotten);
    free(poses->items);
    memset(poses, 0, sizeof *poses);
}
