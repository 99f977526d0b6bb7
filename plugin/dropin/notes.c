/*
 * The layer notes what ODE keeps of joints and has no getters for: the pose that the bodies have when axes or anchors
 * are set, and the arguments of some setters (joints/joint_pose.h). It also notes which worlds have moved callbacks.
 */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/registry.h"
#include "dropin/state.h"

#include "support/vec3.h"

#include <math.h>

/* Notes `things` of the pose of a joint's bodies, which the joint has just taken. */
static void note_pose(dJointID joint, unsigned things, double axis_length)
{
    pinch_joint_pose pose;
    if (!pinch_joint_pose_now(joint, &pose)) return;
    pose.known &= things;
    if (!pose.body[1]) pose.axis_length = axis_length;
    dWorldID world = dBodyGetWorld(pose.body[0]);
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, world);
    if (live) (void)pinch_joint_pose_keep(&live->joint_poses, &pose);
    pinch_layer_unlock();
}

/* Calls after which a joint has taken some of the pose. */
#define NOTES(things, name, parameters, arguments)                                                                     \
    void pinch_layer_##name parameters                                                                                 \
    {                                                                                                                  \
        pinch_layer_own()->ode_##name arguments;                                                                       \
        note_pose(joint, things, 1);                                                                                   \
    }
/* clang-format off */
NOTES(PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET, joint_set_fixed, (dJointID joint), (joint))
NOTES(PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET, joint_set_slider_axis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_TURN, joint_set_hinge2_axes, (dJointID joint, const dReal *axis1, const dReal *axis2), (joint, axis1, axis2))
NOTES(PINCH_KNOWS_TURN, joint_set_dhinge_axis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_OFFSET, joint_set_pr_anchor, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_OFFSET, joint_set_pu_anchor, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_MESH, joint_set_transmission_axis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_MESH, joint_set_transmission_axis1, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_MESH, joint_set_transmission_axis2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_MESH, joint_set_transmission_anchor1, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES(PINCH_KNOWS_MESH, joint_set_transmission_anchor2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
/* clang-format on */

/* Calls that set an axis of the second body's from x, y, z. ODE takes the vector as it is where that is the world. */
#define NOTES_AXIS(name, parameters, arguments)                                                                        \
    void pinch_layer_##name parameters                                                                                 \
    {                                                                                                                  \
        const double axis[3] = {x, y, z};                                                                              \
        pinch_layer_own()->ode_##name arguments;                                                                       \
        note_pose(joint, PINCH_KNOWS_TURN, pinch_v3_norm(axis));                                                       \
    }
/* clang-format off */
NOTES_AXIS(joint_set_hinge_axis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES_AXIS(joint_set_hinge_axis_offset, (dJointID joint, dReal x, dReal y, dReal z, dReal angle), (joint, x, y, z, angle))
NOTES_AXIS(joint_set_pr_axis2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES_AXIS(joint_set_piston_axis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
NOTES_AXIS(joint_set_piston_axis_delta, (dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz), (joint, x, y, z, dx, dy, dz))
/* clang-format on */

/* An anchor that is set as if the first body were elsewhere. Along the axis ODE shows how far; across it, nobody knows.
 */
static void note_moved_anchor(dJointID joint, double dx, double dy, double dz)
{
    static const double ACROSS = 1e-12;
    const double moved[3] = {dx, dy, dz};
    dVector3 axis;
    double across[3];
    dBodyID body[2];
    if (!pinch_joint_bodies(joint, body)) return;
    note_pose(joint, PINCH_KNOWS_OFFSET, 1);
    dJointGetPUAxisP(joint, axis);
    pinch_v3_cross(moved, axis, across);
    if (pinch_v3_norm(across) <= ACROSS * pinch_v3_norm(moved)) return;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, dBodyGetWorld(body[0]));
    if (live) pinch_joint_pose_forget(&live->joint_poses, joint, PINCH_KNOWS_OFFSET);
    pinch_layer_unlock();
}

void pinch_layer_joint_set_pu_anchor_delta(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz)
{
    pinch_layer_own()->ode_joint_set_pu_anchor_delta(joint, x, y, z, dx, dy, dz);
    note_moved_anchor(joint, dx, dy, dz);
}

void pinch_layer_joint_set_pu_anchor_offset(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz)
{
    pinch_layer_own()->ode_joint_set_pu_anchor_offset(joint, x, y, z, dx, dy, dz);
    note_moved_anchor(joint, dx, dy, dz);
}

/* ODE moves the place of a slider's body in the world by the delta, and ignores that between two bodies. */
void pinch_layer_joint_set_slider_axis_delta(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz)
{
    pinch_joint_pose pose;
    const double delta[3] = {dx, dy, dz};
    pinch_layer_own()->ode_joint_set_slider_axis_delta(joint, x, y, z, dx, dy, dz);
    if (!pinch_joint_pose_now(joint, &pose)) return;
    if (!pose.body[1]) pinch_v3_add_scaled(pose.offset, 1, delta);
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, dBodyGetWorld(pose.body[0]));
    if (live) (void)pinch_joint_pose_keep(&live->joint_poses, &pose);
    pinch_layer_unlock();
}

void pinch_layer_joint_set_hinge2_axis1(dJointID joint, dReal x, dReal y, dReal z)
{
    const dVector3 axis = {x, y, z};
    pinch_layer_joint_set_hinge2_axes(joint, axis, NULL); /* ODE's older forms are these */
}

void pinch_layer_joint_set_hinge2_axis2(dJointID joint, dReal x, dReal y, dReal z)
{
    const dVector3 axis = {x, y, z};
    pinch_layer_joint_set_hinge2_axes(joint, NULL, axis);
}

/* Returns what a joint of this type takes of the pose when it is attached. */
static unsigned taken_when_attached(dJointType type)
{
    switch (type) {
    case dJointTypeSlider:
    case dJointTypePR:
        return PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET;
    case dJointTypePU:
        return PINCH_KNOWS_OFFSET;
    case dJointTypeHinge:
    case dJointTypeHinge2:
    case dJointTypePiston:
        return PINCH_KNOWS_TURN;
    default:
        return 0;
    }
}

void pinch_layer_joint_attach(dJointID joint, dBodyID body1, dBodyID body2)
{
    pinch_layer_own()->ode_joint_attach(joint, body1, body2);
    unsigned things = taken_when_attached(dJointGetType(joint));
    if (things) note_pose(joint, things, 1);
}

/* ODE calls them as it moves bodies, and shows nobody which bodies have one. */
void pinch_layer_body_set_moved_callback(dBodyID body, void (*callback)(dBodyID))
{
    pinch_layer_own()->ode_body_set_moved_callback(body, callback);
    if (!callback) return;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, dBodyGetWorld(body));
    if (live) live->moved_callbacks = true;
    pinch_layer_unlock();
}

/* ---- motors ---- */

/* In Euler mode a motor measures its angles from the pose in which mode or axes were set last. */
static void note_euler(dJointID joint)
{
    if (dJointGetAMotorMode(joint) == dAMotorEuler) note_pose(joint, PINCH_KNOWS_TURN, 1);
}

void pinch_layer_joint_set_amotor_mode(dJointID joint, int mode)
{
    pinch_layer_own()->ode_joint_set_amotor_mode(joint, mode);
    note_euler(joint);
}

void pinch_layer_joint_set_amotor_axis(dJointID joint, int axis, int frame, dReal x, dReal y, dReal z)
{
    pinch_layer_own()->ode_joint_set_amotor_axis(joint, axis, frame, x, y, z);
    note_euler(joint);
}

/* These may be made and set before they are attached, and so before their world can be asked for. */
static void is_new(dWorldID world, dJointID joint, dJointType type)
{
    double cfm = dWorldGetCFM(world);
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, world);
    if (live && joint) (void)pinch_joint_is_new(&live->joint_poses, joint, type, cfm);
    pinch_layer_unlock();
}

dJointID pinch_layer_joint_create_plane2d(dWorldID world, dJointGroupID group)
{
    dJointID joint = pinch_layer_note_joint(world, group, pinch_layer_own()->ode_joint_create_plane2d(world, group));
    is_new(world, joint, dJointTypePlane2D);
    return joint;
}

dJointID pinch_layer_joint_create_lmotor(dWorldID world, dJointGroupID group)
{
    dJointID joint = pinch_layer_note_joint(world, group, pinch_layer_own()->ode_joint_create_lmotor(world, group));
    is_new(world, joint, dJointTypeLMotor);
    return joint;
}

void pinch_layer_joint_set_lmotor_axis(dJointID joint, int axis, int frame, dReal x, dReal y, dReal z)
{
    pinch_layer_own()->ode_joint_set_lmotor_axis(joint, axis, frame, x, y, z);
    pinch_layer_state *state = pinch_layer_lock();
    for (pinch_live_world *live = state->registry.worlds; live; live = live->next)
        if (pinch_joint_is_noted(&live->joint_poses, joint))
            (void)pinch_note_motor_frame(&live->joint_poses, joint, axis, frame);
    pinch_layer_unlock();
}

static void note_plane_motor(dJointID joint, int motor, int parameter, dReal value)
{
    pinch_layer_state *state = pinch_layer_lock();
    for (pinch_live_world *live = state->registry.worlds; live; live = live->next)
        (void)pinch_note_plane_motor(&live->joint_poses, joint, motor, parameter, value);
    pinch_layer_unlock();
}

#define NOTES_PLANE_MOTOR(name, motor)                                                                                 \
    void pinch_layer_##name(dJointID joint, int parameter, dReal value)                                                \
    {                                                                                                                  \
        pinch_layer_own()->ode_##name(joint, parameter, value);                                                        \
        note_plane_motor(joint, motor, parameter, value);                                                              \
    }
NOTES_PLANE_MOTOR(joint_set_plane2d_x_param, 0)
NOTES_PLANE_MOTOR(joint_set_plane2d_y_param, 1)
NOTES_PLANE_MOTOR(joint_set_plane2d_angle_param, 2)
