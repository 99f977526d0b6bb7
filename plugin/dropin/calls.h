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
/* Calls that make a geom, which the layer notes. dCreateGeomTransform is deprecated; its geoms are found by their body. */
#define PINCH_DROPIN_GEOM_CALLS(VALUE)                                                                                 \
    VALUE(dGeomID, create_sphere, dCreateSphere, (dSpaceID space, dReal radius), (space, radius))                      \
    VALUE(dGeomID, create_box, dCreateBox, (dSpaceID space, dReal lx, dReal ly, dReal lz), (space, lx, ly, lz))        \
    VALUE(dGeomID, create_plane, dCreatePlane, (dSpaceID space, dReal a, dReal b, dReal c, dReal d),                   \
          (space, a, b, c, d))                                                                                         \
    VALUE(dGeomID, create_capsule, dCreateCapsule, (dSpaceID space, dReal radius, dReal length),                       \
          (space, radius, length))                                                                                     \
    VALUE(dGeomID, create_cylinder, dCreateCylinder, (dSpaceID space, dReal radius, dReal length),                     \
          (space, radius, length))                                                                                     \
    VALUE(dGeomID, create_ray, dCreateRay, (dSpaceID space, dReal length), (space, length))                            \
    VALUE(dGeomID, create_convex, dCreateConvex, (dSpaceID space, const dReal *planes, unsigned plane_count,           \
          const dReal *points, unsigned point_count, const unsigned *polygons),                                        \
          (space, planes, plane_count, points, point_count, polygons))                                                 \
    VALUE(dGeomID, create_heightfield, dCreateHeightfield, (dSpaceID space, dHeightfieldDataID data, int placeable),   \
          (space, data, placeable))                                                                                    \
    VALUE(dGeomID, create_trimesh, dCreateTriMesh, (dSpaceID space, dTriMeshDataID data, dTriCallback *callback,       \
          dTriArrayCallback *array_callback, dTriRayCallback *ray_callback),                                           \
          (space, data, callback, array_callback, ray_callback))                                                       \
    VALUE(dGeomID, create_geom, dCreateGeom, (int class_number), (class_number))

/* Calls that make a joint, which the layer notes: bodies that have joints are found through these. */
#define PINCH_DROPIN_JOINT_CALLS(VALUE)                                                                                \
    VALUE(dJointID, joint_create_ball, dJointCreateBall, (dWorldID world, dJointGroupID group), (world, group))        \
    VALUE(dJointID, joint_create_hinge, dJointCreateHinge, (dWorldID world, dJointGroupID group), (world, group))      \
    VALUE(dJointID, joint_create_slider, dJointCreateSlider, (dWorldID world, dJointGroupID group), (world, group))    \
    VALUE(dJointID, joint_create_hinge2, dJointCreateHinge2, (dWorldID world, dJointGroupID group), (world, group))    \
    VALUE(dJointID, joint_create_universal, dJointCreateUniversal,                                                     \
          (dWorldID world, dJointGroupID group), (world, group))                                                       \
    VALUE(dJointID, joint_create_pr, dJointCreatePR, (dWorldID world, dJointGroupID group), (world, group))            \
    VALUE(dJointID, joint_create_pu, dJointCreatePU, (dWorldID world, dJointGroupID group), (world, group))            \
    VALUE(dJointID, joint_create_piston, dJointCreatePiston, (dWorldID world, dJointGroupID group), (world, group))    \
    VALUE(dJointID, joint_create_fixed, dJointCreateFixed, (dWorldID world, dJointGroupID group), (world, group))      \
    VALUE(dJointID, joint_create_amotor, dJointCreateAMotor, (dWorldID world, dJointGroupID group), (world, group))    \
    VALUE(dJointID, joint_create_dball, dJointCreateDBall, (dWorldID world, dJointGroupID group), (world, group))      \
    VALUE(dJointID, joint_create_dhinge, dJointCreateDHinge, (dWorldID world, dJointGroupID group), (world, group))    \
    VALUE(dJointID, joint_create_transmission, dJointCreateTransmission,                                               \
          (dWorldID world, dJointGroupID group), (world, group))

#define PINCH_DROPIN_CALLS(VALUE, VOID)                                                                                \
    PINCH_DROPIN_GEOM_CALLS(VALUE)                                                                                     \
    PINCH_DROPIN_JOINT_CALLS(VALUE)                                                                                    \
    VALUE(dJointID, joint_create_contact, dJointCreateContact,                                                         \
          (dWorldID world, dJointGroupID group, const dContact *contact), (world, group, contact))                     \
    VALUE(int, collide, dCollide, (dGeomID g1, dGeomID g2, int flags, dContactGeom *contacts, int skip),               \
          (g1, g2, flags, contacts, skip))                                                                             \
    VOID(set_collider_override, dSetColliderOverride, (int class1, int class2, dColliderFn *collider),                 \
         (class1, class2, collider))                                                                                   \
    VOID(joint_attach, dJointAttach, (dJointID joint, dBodyID body1, dBodyID body2), (joint, body1, body2))            \
    VALUE(dJointID, joint_create_plane2d, dJointCreatePlane2D, (dWorldID world, dJointGroupID group), (world, group))  \
    VALUE(dJointID, joint_create_lmotor, dJointCreateLMotor, (dWorldID world, dJointGroupID group), (world, group))    \
    VOID(joint_set_fixed, dJointSetFixed, (dJointID joint), (joint))                                                   \
    VOID(joint_set_slider_axis, dJointSetSliderAxis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))    \
    VOID(joint_set_slider_axis_delta, dJointSetSliderAxisDelta,                                                        \
         (dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz), (joint, x, y, z, dx, dy, dz))      \
    VOID(joint_set_hinge_axis, dJointSetHingeAxis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))      \
    VOID(joint_set_hinge_axis_offset, dJointSetHingeAxisOffset,                                                        \
         (dJointID joint, dReal x, dReal y, dReal z, dReal angle), (joint, x, y, z, angle))                            \
    VOID(joint_set_hinge2_axes, dJointSetHinge2Axes,                                                                   \
         (dJointID joint, const dReal *axis1, const dReal *axis2), (joint, axis1, axis2))                              \
    VOID(joint_set_dhinge_axis, dJointSetDHingeAxis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))    \
    VOID(joint_set_pr_anchor, dJointSetPRAnchor, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))        \
    VOID(joint_set_pr_axis2, dJointSetPRAxis2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))          \
    VOID(joint_set_pu_anchor, dJointSetPUAnchor, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))        \
    VOID(joint_set_pu_anchor_delta, dJointSetPUAnchorDelta,                                                            \
         (dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz), (joint, x, y, z, dx, dy, dz))      \
    VOID(joint_set_pu_anchor_offset, dJointSetPUAnchorOffset,                                                          \
         (dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz), (joint, x, y, z, dx, dy, dz))      \
    VOID(joint_set_piston_axis, dJointSetPistonAxis, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))    \
    VOID(joint_set_piston_axis_delta, dJointSetPistonAxisDelta,                                                        \
         (dJointID joint, dReal x, dReal y, dReal z, dReal dx, dReal dy, dReal dz), (joint, x, y, z, dx, dy, dz))      \
    VOID(joint_set_amotor_mode, dJointSetAMotorMode, (dJointID joint, int mode), (joint, mode))                        \
    VOID(joint_set_amotor_axis, dJointSetAMotorAxis,                                                                   \
         (dJointID joint, int axis, int frame, dReal x, dReal y, dReal z), (joint, axis, frame, x, y, z))              \
    VOID(joint_set_lmotor_axis, dJointSetLMotorAxis,                                                                   \
         (dJointID joint, int axis, int frame, dReal x, dReal y, dReal z), (joint, axis, frame, x, y, z))              \
    VOID(joint_set_plane2d_x_param, dJointSetPlane2DXParam,                                                            \
         (dJointID joint, int parameter, dReal value), (joint, parameter, value))                                      \
    VOID(joint_set_plane2d_y_param, dJointSetPlane2DYParam,                                                            \
         (dJointID joint, int parameter, dReal value), (joint, parameter, value))                                      \
    VOID(joint_set_plane2d_angle_param, dJointSetPlane2DAngleParam,                                                    \
         (dJointID joint, int parameter, dReal value), (joint, parameter, value))                                      \
    VOID(joint_set_transmission_axis, dJointSetTransmissionAxis,                                                       \
         (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))                                                \
    VOID(joint_set_transmission_axis1, dJointSetTransmissionAxis1,                                                     \
         (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))                                                \
    VOID(joint_set_transmission_axis2, dJointSetTransmissionAxis2,                                                     \
         (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))                                                \
    VOID(joint_set_transmission_anchor1, dJointSetTransmissionAnchor1,                                                 \
         (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))                                                \
    VOID(joint_set_transmission_anchor2, dJointSetTransmissionAnchor2,                                                 \
         (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))                                                \
    VOID(body_set_moved_callback, dBodySetMovedCallback, (dBodyID body, void (*callback)(dBodyID)), (body, callback))  \
    VOID(joint_destroy, dJointDestroy, (dJointID joint), (joint))                                                      \
    VOID(joint_group_empty, dJointGroupEmpty, (dJointGroupID group), (group))                                          \
    VOID(joint_group_destroy, dJointGroupDestroy, (dJointGroupID group), (group))                                      \
    VALUE(int, world_step, dWorldStep, (dWorldID world, dReal h), (world, h))                                          \
    VALUE(int, world_quick_step, dWorldQuickStep, (dWorldID world, dReal h), (world, h))                               \
    VOID(world_destroy, dWorldDestroy, (dWorldID world), (world))                                                      \
    VOID(body_destroy, dBodyDestroy, (dBodyID body), (body))                                                           \
    VOID(geom_destroy, dGeomDestroy, (dGeomID geom), (geom))                                                           \
    VOID(space_destroy, dSpaceDestroy, (dSpaceID space), (space))                                                      \
    VOID(space_clean, dSpaceClean, (dSpaceID space), (space))                                                          \
    VOID(space_add, dSpaceAdd, (dSpaceID space, dGeomID geom), (space, geom))                                          \
    VOID(geom_trimesh_set_data, dGeomTriMeshSetData, (dGeomID mesh, dTriMeshDataID data), (mesh, data))

/* Older forms of calls in the first table, which the layer makes of those: it never calls them in ODE. */
#define PINCH_DROPIN_OLDER_CALLS(VOID)                                                                                 \
    VOID(joint_set_hinge2_axis1, dJointSetHinge2Axis1, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))  \
    VOID(joint_set_hinge2_axis2, dJointSetHinge2Axis2, (dJointID joint, dReal x, dReal y, dReal z), (joint, x, y, z))
/* clang-format on */

#endif
