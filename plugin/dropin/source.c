/* What the macros of <pinch/ode_dropin.h> stand for. */
#include "dropin/layer.h"

dJointID pinch_dropin_joint_create_contact(dWorldID world, dJointGroupID group, const dContact *contact)
{
    return pinch_layer_joint_create_contact(world, group, contact);
}

void pinch_dropin_joint_attach(dJointID joint, dBodyID body1, dBodyID body2)
{
    pinch_layer_joint_attach(joint, body1, body2);
}

void pinch_dropin_joint_set_fixed(dJointID joint)
{
    pinch_layer_joint_set_fixed(joint);
}

void pinch_dropin_joint_set_slider_axis(dJointID joint, dReal x, dReal y, dReal z)
{
    pinch_layer_joint_set_slider_axis(joint, x, y, z);
}

void pinch_dropin_joint_set_hinge2_axes(dJointID joint, const dReal *axis1, const dReal *axis2)
{
    pinch_layer_joint_set_hinge2_axes(joint, axis1, axis2);
}

void pinch_dropin_joint_set_hinge2_axis1(dJointID joint, dReal x, dReal y, dReal z)
{
    pinch_layer_joint_set_hinge2_axis1(joint, x, y, z);
}

void pinch_dropin_joint_set_hinge2_axis2(dJointID joint, dReal x, dReal y, dReal z)
{
    pinch_layer_joint_set_hinge2_axis2(joint, x, y, z);
}

void pinch_dropin_joint_destroy(dJointID joint)
{
    pinch_layer_joint_destroy(joint);
}

void pinch_dropin_joint_group_empty(dJointGroupID group)
{
    pinch_layer_joint_group_empty(group);
}

void pinch_dropin_joint_group_destroy(dJointGroupID group)
{
    pinch_layer_joint_group_destroy(group);
}

int pinch_dropin_world_step(dWorldID world, dReal h)
{
    return pinch_layer_step(world, h, PINCH_ODE_WORLDSTEP);
}

int pinch_dropin_world_quick_step(dWorldID world, dReal h)
{
    return pinch_layer_step(world, h, PINCH_ODE_QUICKSTEP);
}

void pinch_dropin_world_destroy(dWorldID world)
{
    pinch_layer_world_destroy(world);
}

void pinch_dropin_geom_destroy(dGeomID geom)
{
    pinch_layer_geom_destroy(geom);
}

void pinch_dropin_space_destroy(dSpaceID space)
{
    pinch_layer_space_destroy(space);
}

void pinch_dropin_space_clean(dSpaceID space)
{
    pinch_layer_space_clean(space);
}
