#ifndef PINCH_ODE_DROPIN_H
#define PINCH_ODE_DROPIN_H

#include <ode/objects.h>

#include <ode/collision.h>
#include <ode/collision_space.h>
#include <pinch/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Pinch as the contact solver of an ODE program that stays as it is. Include this header after (or instead of)
 * <ode/ode.h> in every source file that calls ODE, and link libpinch_ode: a file without it that makes one of the calls
 * below hides from Pinch what it sets, as the axis of a joint. The calls below then go through Pinch: contact joints are still
 * contact joints of ODE's, and a step solves those that Pinch has a law for, by their surface parameters, and leaves
 * the others to ODE (see pinch_ode_add_joint in <pinch/ode.h>). A step that Pinch refuses, because memory ran out or
 * the state of a body is not finite, is ODE's own step as the program asked for it, and is counted; the contact
 * histories of the world end with it. In a world in which
 * a body has a moved callback, ODE moves all bodies that are not at rest.
 *
 * Of a contact ODE's solver needs place, normal, depth and surface alone, and programs leave its geoms unset. What is
 * in their place counts as a geom where it was made by the calls below and not destroyed, or is in the list of its
 * body's geoms, and where it belongs to the body on its side of the contact, or has a material. Otherwise that side of
 * the contact is its body as a whole, or the world.
 *
 * In C++, to reach the classes of ODE's C++ interface as well, include this header before <ode/ode.h>.
 *
 * dCollide returns what ODE's does, but for boxes that rounding has it lose (pinch_tip_mend_boxes in
 * <pinch/fingertip.h>), unless the program has a collider of its own for boxes.
 *
 * Different worlds may be stepped from different threads, as in ODE. Settings, statistics and the list of worlds
 * concern the whole process; they are guarded, so that any thread may call any function here for a world that no other
 * uses.
 */
PINCH_API dJointID pinch_dropin_joint_create_contact(dWorldID world, dJointGroupID group, const dContact *contact);
PINCH_API int pinch_dropin_collide(dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip);
PINCH_API void pinch_dropin_set_collider_override(int class1, int class2, dColliderFn *collider);
PINCH_API void pinch_dropin_joint_attach(dJointID joint, dBodyID body1, dBodyID body2);
PINCH_API dJointID pinch_dropin_joint_create_ball(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_hinge(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_slider(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_hinge2(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_universal(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_pr(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_pu(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_piston(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_fixed(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_amotor(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_dball(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_dhinge(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_transmission(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_plane2d(dWorldID world, dJointGroupID group);
PINCH_API dJointID pinch_dropin_joint_create_lmotor(dWorldID world, dJointGroupID group);
PINCH_API void pinch_dropin_joint_set_fixed(dJointID joint);
PINCH_API void pinch_dropin_joint_set_slider_axis(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_slider_axis_delta(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy,
                                                        dReal dz);
PINCH_API void pinch_dropin_joint_set_hinge_axis(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_hinge_axis_offset(dJointID joint, dReal x, dReal y, dReal z, dReal angle);
PINCH_API void pinch_dropin_joint_set_hinge2_axes(dJointID joint, const dReal *axis1, const dReal *axis2);
PINCH_API void pinch_dropin_joint_set_dhinge_axis(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_pr_anchor(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_pr_axis2(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_pu_anchor(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_pu_anchor_delta(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy,
                                                      dReal dz);
PINCH_API void pinch_dropin_joint_set_pu_anchor_offset(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy,
                                                       dReal dz);
PINCH_API void pinch_dropin_joint_set_piston_axis(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_piston_axis_delta(dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy,
                                                        dReal dz);
PINCH_API void pinch_dropin_joint_set_amotor_mode(dJointID joint, int mode);
PINCH_API void pinch_dropin_joint_set_amotor_axis(dJointID joint, int axis, int frame, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_lmotor_axis(dJointID joint, int axis, int frame, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_plane2d_x_param(dJointID joint, int parameter, dReal value);
PINCH_API void pinch_dropin_joint_set_plane2d_y_param(dJointID joint, int parameter, dReal value);
PINCH_API void pinch_dropin_joint_set_plane2d_angle_param(dJointID joint, int parameter, dReal value);
PINCH_API void pinch_dropin_joint_set_transmission_axis(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_transmission_axis1(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_transmission_axis2(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_transmission_anchor1(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_transmission_anchor2(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_hinge2_axis1(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_joint_set_hinge2_axis2(dJointID joint, dReal x, dReal y, dReal z);
PINCH_API void pinch_dropin_body_set_moved_callback(dBodyID body, void (*callback)(dBodyID));
PINCH_API void pinch_dropin_joint_destroy(dJointID joint);
PINCH_API void pinch_dropin_joint_group_empty(dJointGroupID group);
PINCH_API void pinch_dropin_joint_group_destroy(dJointGroupID group);
PINCH_API int pinch_dropin_world_step(dWorldID world, dReal h);
PINCH_API int pinch_dropin_world_quick_step(dWorldID world, dReal h);
PINCH_API void pinch_dropin_world_destroy(dWorldID world);
PINCH_API void pinch_dropin_body_destroy(dBodyID body);
PINCH_API void pinch_dropin_geom_destroy(dGeomID geom);
PINCH_API void pinch_dropin_space_destroy(dSpaceID space);
PINCH_API void pinch_dropin_space_clean(dSpaceID space);
PINCH_API void pinch_dropin_space_add(dSpaceID space, dGeomID geom);
PINCH_API void pinch_dropin_geom_trimesh_set_data(dGeomID mesh, dTriMeshDataID data);
PINCH_API dGeomID pinch_dropin_create_sphere(dSpaceID space, dReal radius);
PINCH_API dGeomID pinch_dropin_create_box(dSpaceID space, dReal lx, dReal ly, dReal lz);
PINCH_API dGeomID pinch_dropin_create_plane(dSpaceID space, dReal a, dReal b, dReal c, dReal d);
PINCH_API dGeomID pinch_dropin_create_capsule(dSpaceID space, dReal radius, dReal length);
PINCH_API dGeomID pinch_dropin_create_cylinder(dSpaceID space, dReal radius, dReal length);
PINCH_API dGeomID pinch_dropin_create_ray(dSpaceID space, dReal length);
PINCH_API dGeomID pinch_dropin_create_convex(dSpaceID space, const dReal *planes, unsigned plane_count,
                                             const dReal *points, unsigned point_count, const unsigned *polygons);
PINCH_API dGeomID pinch_dropin_create_heightfield(dSpaceID space, dHeightfieldDataID data, int placeable);
PINCH_API dGeomID pinch_dropin_create_trimesh(dSpaceID space, dTriMeshDataID data, dTriCallback *callback,
                                              dTriArrayCallback *array_callback, dTriRayCallback *ray_callback);
PINCH_API dGeomID pinch_dropin_create_geom(int class_number);

#ifdef __cplusplus
}
#endif

#ifndef PINCH_DROPIN_NO_MACROS
#define dJointCreateContact          pinch_dropin_joint_create_contact
#define dCollide                     pinch_dropin_collide
#define dSetColliderOverride         pinch_dropin_set_collider_override
#define dJointAttach                 pinch_dropin_joint_attach
#define dJointCreateBall             pinch_dropin_joint_create_ball
#define dJointCreateHinge            pinch_dropin_joint_create_hinge
#define dJointCreateSlider           pinch_dropin_joint_create_slider
#define dJointCreateHinge2           pinch_dropin_joint_create_hinge2
#define dJointCreateUniversal        pinch_dropin_joint_create_universal
#define dJointCreatePR               pinch_dropin_joint_create_pr
#define dJointCreatePU               pinch_dropin_joint_create_pu
#define dJointCreatePiston           pinch_dropin_joint_create_piston
#define dJointCreateFixed            pinch_dropin_joint_create_fixed
#define dJointCreateAMotor           pinch_dropin_joint_create_amotor
#define dJointCreateDBall            pinch_dropin_joint_create_dball
#define dJointCreateDHinge           pinch_dropin_joint_create_dhinge
#define dJointCreateTransmission     pinch_dropin_joint_create_transmission
#define dJointCreatePlane2D          pinch_dropin_joint_create_plane2d
#define dJointCreateLMotor           pinch_dropin_joint_create_lmotor
#define dJointSetFixed               pinch_dropin_joint_set_fixed
#define dJointSetSliderAxis          pinch_dropin_joint_set_slider_axis
#define dJointSetSliderAxisDelta     pinch_dropin_joint_set_slider_axis_delta
#define dJointSetHingeAxis           pinch_dropin_joint_set_hinge_axis
#define dJointSetHingeAxisOffset     pinch_dropin_joint_set_hinge_axis_offset
#define dJointSetHinge2Axes          pinch_dropin_joint_set_hinge2_axes
#define dJointSetDHingeAxis          pinch_dropin_joint_set_dhinge_axis
#define dJointSetPRAnchor            pinch_dropin_joint_set_pr_anchor
#define dJointSetPRAxis2             pinch_dropin_joint_set_pr_axis2
#define dJointSetPUAnchor            pinch_dropin_joint_set_pu_anchor
#define dJointSetPUAnchorDelta       pinch_dropin_joint_set_pu_anchor_delta
#define dJointSetPUAnchorOffset      pinch_dropin_joint_set_pu_anchor_offset
#define dJointSetPistonAxis          pinch_dropin_joint_set_piston_axis
#define dJointSetPistonAxisDelta     pinch_dropin_joint_set_piston_axis_delta
#define dJointSetAMotorMode          pinch_dropin_joint_set_amotor_mode
#define dJointSetAMotorAxis          pinch_dropin_joint_set_amotor_axis
#define dJointSetLMotorAxis          pinch_dropin_joint_set_lmotor_axis
#define dJointSetPlane2DXParam       pinch_dropin_joint_set_plane2d_x_param
#define dJointSetPlane2DYParam       pinch_dropin_joint_set_plane2d_y_param
#define dJointSetPlane2DAngleParam   pinch_dropin_joint_set_plane2d_angle_param
#define dJointSetTransmissionAxis    pinch_dropin_joint_set_transmission_axis
#define dJointSetTransmissionAxis1   pinch_dropin_joint_set_transmission_axis1
#define dJointSetTransmissionAxis2   pinch_dropin_joint_set_transmission_axis2
#define dJointSetTransmissionAnchor1 pinch_dropin_joint_set_transmission_anchor1
#define dJointSetTransmissionAnchor2 pinch_dropin_joint_set_transmission_anchor2
#define dJointSetHinge2Axis1         pinch_dropin_joint_set_hinge2_axis1
#define dJointSetHinge2Axis2         pinch_dropin_joint_set_hinge2_axis2
#define dBodySetMovedCallback        pinch_dropin_body_set_moved_callback
#define dJointDestroy                pinch_dropin_joint_destroy
#define dJointGroupEmpty             pinch_dropin_joint_group_empty
#define dJointGroupDestroy           pinch_dropin_joint_group_destroy
#define dWorldStep                   pinch_dropin_world_step
#define dWorldQuickStep              pinch_dropin_world_quick_step
#define dWorldDestroy                pinch_dropin_world_destroy
#define dBodyDestroy                 pinch_dropin_body_destroy
#define dGeomDestroy                 pinch_dropin_geom_destroy
#define dSpaceDestroy                pinch_dropin_space_destroy
#define dSpaceClean                  pinch_dropin_space_clean
#define dSpaceAdd                    pinch_dropin_space_add
#define dGeomTriMeshSetData          pinch_dropin_geom_trimesh_set_data
#define dCreateSphere                pinch_dropin_create_sphere
#define dCreateBox                   pinch_dropin_create_box
#define dCreatePlane                 pinch_dropin_create_plane
#define dCreateCapsule               pinch_dropin_create_capsule
#define dCreateCylinder              pinch_dropin_create_cylinder
#define dCreateRay                   pinch_dropin_create_ray
#define dCreateConvex                pinch_dropin_create_convex
#define dCreateHeightfield           pinch_dropin_create_heightfield
#define dCreateTriMesh               pinch_dropin_create_trimesh
#define dCreateGeom                  pinch_dropin_create_geom
#endif

/* after the macros: with them ODE's C++ classes, which call these functions inline, are rerouted as well */
#include <pinch/ode.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Settings of the worlds in which no contact has been made yet; `stepper` is not used: it is the one that the program
 * calls. Defaults: pinch_ode_default_settings(). PINCH_INVALID_ARGUMENT and PINCH_UNSUPPORTED as pinch_ode_create.
 */
PINCH_API pinch_status pinch_dropin_set_settings(const pinch_ode_settings *settings);
PINCH_API pinch_ode_settings pinch_dropin_settings(void);

/* pinch_ode_set_material for a geom in the contacts of `world`; ends by itself when the geom is destroyed.
 * Outside of settings.scope, the first material counts for contacts that are made after it.
 * PINCH_INVALID_ARGUMENT also while the world is being stepped. */
PINCH_API pinch_status pinch_dropin_set_material(dWorldID world, dGeomID geom, const pinch_material *material);

/* pinch_ode_contacts of the step that `world` has just done; count 0 for a world without contacts. */
PINCH_API pinch_status pinch_dropin_contacts(dWorldID world, const pinch_ode_contact **list, int *count);

/* pinch_ode_geom_load, or pinch_ode_pair_load where `partner` is not NULL, of the step that `world` has just done; no
 * load in a world without contacts. */
PINCH_API pinch_status pinch_dropin_geom_load(dWorldID world, dGeomID geom, dGeomID partner, const double about[3],
                                              pinch_ode_load *load);

/* Sums and maxima over all worlds, the destroyed ones included. */
typedef struct pinch_dropin_stats {
    long worlds;           /* in which a contact was made or a step was done */
    long steps;            /* of all worlds, done or refused */
    long steps_refused;    /* left to ODE alone */
    long contacts_offered; /* to Pinch: contact joints, summed over steps */
    long contacts_idle;    /* contact joints that act on nothing: not attached, disabled, or of no body that moves */
    long contacts_out_of_scope; /* made outside of settings.scope while no geom had a material: never offered, and
                                 * counted once, when they were made */
    long contacts_refused;      /* left to ODE in refused steps */
    long contacts_unrecorded;   /* left to ODE for good, because memory ran out when they were made */
    double time_pinch;          /* s, finding forces */
    double time_ode;            /* s, ODE's own step with what belongs to it: joints, integration, contact histories */
    pinch_ode_stats ode;        /* `steps`: those that Pinch did; `memory`: held now */
} pinch_dropin_stats;

PINCH_API pinch_dropin_stats pinch_dropin_statistics(void);
/* Since the start again; contact histories stay. Not while a world is being stepped. */
PINCH_API void pinch_dropin_reset_statistics(void);

/*
 * The statistics and the settings as a JSON document that ends with a line feed: pinch exec --stats. As snprintf:
 * writes at most `size` bytes with the NUL, returns the length without it that the whole has.
 */
PINCH_API int pinch_dropin_write_statistics(char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
