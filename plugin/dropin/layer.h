/*
 * The drop-in layer: what an ODE program calls, with Pinch in between. One layer serves both levels, the header's
 * macros and the preloaded library; they differ in where ODE's own functions are found.
 */
#ifndef PINCH_DROPIN_LAYER_H
#define PINCH_DROPIN_LAYER_H

#include <pinch/ode_dropin.h>

/* ODE's own functions. */
typedef struct pinch_layer_calls {
    dJointID (*joint_create_contact)(dWorldID world, dJointGroupID group, const dContact *contact);
    void (*joint_attach)(dJointID joint, dBodyID body1, dBodyID body2);
    void (*joint_set_fixed)(dJointID joint);
    void (*joint_set_slider_axis)(dJointID joint, dReal x, dReal y, dReal z);
    void (*joint_set_hinge2_axes)(dJointID joint, const dReal *axis1, const dReal *axis2);
    void (*joint_destroy)(dJointID joint);
    void (*joint_group_empty)(dJointGroupID group);
    void (*joint_group_destroy)(dJointGroupID group);
    int (*world_step)(dWorldID world, dReal h);
    int (*world_quick_step)(dWorldID world, dReal h);
    void (*world_destroy)(dWorldID world);
    void (*geom_destroy)(dGeomID geom);
    void (*space_destroy)(dSpaceID space);
    void (*space_clean)(dSpaceID space);
} pinch_layer_calls;

/* Before any other call. The table must stay. */
void pinch_layer_set_calls(const pinch_layer_calls *calls);

dJointID pinch_layer_joint_create_contact(dWorldID world, dJointGroupID group, const dContact *contact);
void pinch_layer_joint_attach(dJointID joint, dBodyID body1, dBodyID body2);
void pinch_layer_joint_set_fixed(dJointID joint);
void pinch_layer_joint_set_slider_axis(dJointID joint, dReal x, dReal y, dReal z);
void pinch_layer_joint_set_hinge2_axes(dJointID joint, const dReal *axis1, const dReal *axis2);
void pinch_layer_joint_set_hinge2_axis1(dJointID joint, dReal x, dReal y, dReal z);
void pinch_layer_joint_set_hinge2_axis2(dJointID joint, dReal x, dReal y, dReal z);
void pinch_layer_joint_destroy(dJointID joint);
void pinch_layer_joint_group_empty(dJointGroupID group);
void pinch_layer_joint_group_destroy(dJointGroupID group);
int pinch_layer_step(dWorldID world, dReal h, pinch_ode_stepper stepper);
void pinch_layer_world_destroy(dWorldID world);
void pinch_layer_geom_destroy(dGeomID geom);
void pinch_layer_space_destroy(dSpaceID space);
void pinch_layer_space_clean(dSpaceID space);

/* statistics.c */
void pinch_layer_add_plugin_stats(pinch_ode_stats *sum, const pinch_ode_stats *more);
void pinch_layer_add_stats(pinch_dropin_stats *sum, const pinch_dropin_stats *more);
int pinch_layer_write_statistics(const pinch_dropin_stats *stats, const pinch_ode_settings *settings, char *text,
                                 size_t size);

#endif
