/*
 * The table of ODE's functions that the drop-in layer stands behind.
 *
 * Each row has the function's name in the layer, its name in ODE, its parameters, and these as arguments. VALUE rows
 * also have the type that is returned; VOID rows return nothing. Everything that must know all of these functions is
 * generated from the table: the layer's declarations (layer.h), the ODE functions it calls itself (state.c), what the
 * macros of <pinch/ode_dropin.h> stand for (source.c), and what the preloaded library exports (preload/preload.c).
 */
#ifndef PINCH_DROPIN_CALLS_H
#define PINCH_DROPIN_CALLS_H

/* clang-format off */
#define PINCH_DROPIN_CALLS(VALUE, VOID)                                                                                \
    VALUE(dJointID, joint_create_contact, dJointCreateContact,                                                         \
          (dWorldID world, dJointGroupID group, const dContact *contact), (world, group, contact))                     \
    VOID(joint_attach, dJointAttach, (dJointID joint, dBodyID body1, dBodyID body2), (joint, body1, body2))            \
    VOID(joint_set_fixed, dJointSetFixed, (dJointID joint), (joint))                                                   \
    VOID(joint_set_slider_axis, dJointSetSliderAxis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))    \
    VOID(joint_set_hinge2_axes, dJointSetHinge2Axes, (dJointID joint, const dReal *axis1, const dReal *axis2),         \
         (joint, axis1, axis2))                                                                                        \
    VOID(joint_destroy, dJointDestroy, (dJointID joint), (joint))                                                      \
    VOID(joint_group_empty, dJointGroupEmpty, (dJointGroupID group), (group))                                          \
    VOID(joint_group_destroy, dJointGroupDestroy, (dJointGroupID group), (group))                                      \
    VALUE(int, world_step, dWorldStep, (dWorldID world, dReal h), (world, h))                                          \
    VALUE(int, world_quick_step, dWorldQuickStep, (dWorldID world, dReal h), (world, h))                               \
    VOID(world_destroy, dWorldDestroy, (dWorldID world), (world))                                                      \
    VOID(geom_destroy, dGeomDestroy, (dGeomID geom), (geom))                                                           \
    VOID(space_destroy, dSpaceDestroy, (dSpaceID space), (space))                                                      \
    VOID(space_clean, dSpaceClean, (dSpaceID space), (space))

/* Older forms of calls in the first table, which the layer makes of those: it never calls them in ODE. */
#define PINCH_DROPIN_OLDER_CALLS(VOID)                                                                                 \
    VOID(joint_set_hinge2_axis1, dJointSetHinge2Axis1, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))  \
    VOID(joint_set_hinge2_axis2, dJointSetHinge2Axis2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
/* clang-format on */

#endif
