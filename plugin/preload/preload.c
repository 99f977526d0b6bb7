/*
 * What `pinch exec` loads before a program's other libraries: the few functions of ODE's that the drop-in layer stands
 * behind. Nothing else is exported.
 */
#define _GNU_SOURCE /* RTLD_NOLOAD */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/layer.h"
#include "preload/report.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static pinch_layer_calls own;
static void (*own_close)(void);
static pthread_once_t once = PTHREAD_ONCE_INIT;
static atomic_bool found;

/* POSIX has a function's address be a void * */
static void find(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    if (!address) abort(); /* no libode.so.8 is without them */
    memcpy(function, &address, sizeof address);
}

/* RTLD_NEXT would not see an ODE that came with a dlopen of local scope. */
static void find_ode(void)
{
    void *library = dlopen("libode.so.8", RTLD_LAZY | RTLD_NOLOAD);
    if (!library) library = dlopen("libode.so.8", RTLD_LAZY);
    if (!library) abort(); /* this library is linked with it */
    find(library, "dJointCreateContact", &own.joint_create_contact);
    find(library, "dJointAttach", &own.joint_attach);
    find(library, "dJointSetFixed", &own.joint_set_fixed);
    find(library, "dJointSetSliderAxis", &own.joint_set_slider_axis);
    find(library, "dJointSetHinge2Axes", &own.joint_set_hinge2_axes);
    find(library, "dJointDestroy", &own.joint_destroy);
    find(library, "dJointGroupEmpty", &own.joint_group_empty);
    find(library, "dJointGroupDestroy", &own.joint_group_destroy);
    find(library, "dWorldStep", &own.world_step);
    find(library, "dWorldQuickStep", &own.world_quick_step);
    find(library, "dWorldDestroy", &own.world_destroy);
    find(library, "dGeomDestroy", &own.geom_destroy);
    find(library, "dSpaceDestroy", &own.space_destroy);
    find(library, "dSpaceClean", &own.space_clean);
    find(library, "dCloseODE", &own_close);
    pinch_layer_set_calls(&own);
    pinch_report_start();
    atomic_store_explicit(&found, true, memory_order_release);
}

/* Other libraries' constructors may call ODE before this one's has run. */
__attribute__((constructor)) static void ready(void)
{
    if (!atomic_load_explicit(&found, memory_order_acquire)) (void)pthread_once(&once, find_ode);
}

__attribute__((destructor)) static void leave(void)
{
    pinch_report_end();
}

#define PRELOADED __attribute__((visibility("default")))

PRELOADED dJointID dJointCreateContact(dWorldID world, dJointGroupID group, const dContact *contact)
{
    ready();
    return pinch_layer_joint_create_contact(world, group, contact);
}

PRELOADED void dJointAttach(dJointID joint, dBodyID body1, dBodyID body2)
{
    ready();
    pinch_layer_joint_attach(joint, body1, body2);
}

PRELOADED void dJointSetFixed(dJointID joint)
{
    ready();
    pinch_layer_joint_set_fixed(joint);
}

PRELOADED void dJointSetSliderAxis(dJointID joint, dReal x, dReal y, dReal z)
{
    ready();
    pinch_layer_joint_set_slider_axis(joint, x, y, z);
}

PRELOADED void dJointSetHinge2Axes(dJointID joint, const dReal *axis1, const dReal *axis2)
{
    ready();
    pinch_layer_joint_set_hinge2_axes(joint, axis1, axis2);
}

PRELOADED void dJointSetHinge2Axis1(dJointID joint, dReal x, dReal y, dReal z)
{
    ready();
    pinch_layer_joint_set_hinge2_axis1(joint, x, y, z);
}

PRELOADED void dJointSetHinge2Axis2(dJointID joint, dReal x, dReal y, dReal z)
{
    ready();
    pinch_layer_joint_set_hinge2_axis2(joint, x, y, z);
}

PRELOADED void dJointDestroy(dJointID joint)
{
    ready();
    pinch_layer_joint_destroy(joint);
}

PRELOADED void dJointGroupEmpty(dJointGroupID group)
{
    ready();
    pinch_layer_joint_group_empty(group);
}

PRELOADED void dJointGroupDestroy(dJointGroupID group)
{
    ready();
    pinch_layer_joint_group_destroy(group);
}

PRELOADED int dWorldStep(dWorldID world, dReal h)
{
    ready();
    return pinch_layer_step(world, h, PINCH_ODE_WORLDSTEP);
}

PRELOADED int dWorldQuickStep(dWorldID world, dReal h)
{
    ready();
    return pinch_layer_step(world, h, PINCH_ODE_QUICKSTEP);
}

PRELOADED void dWorldDestroy(dWorldID world)
{
    ready();
    pinch_layer_world_destroy(world);
    pinch_report_sometimes();
}

PRELOADED void dGeomDestroy(dGeomID geom)
{
    ready();
    pinch_layer_geom_destroy(geom);
}

PRELOADED void dSpaceDestroy(dSpaceID space)
{
    ready();
    pinch_layer_space_destroy(space);
}

PRELOADED void dSpaceClean(dSpaceID space)
{
    ready();
    pinch_layer_space_clean(space);
}

/* Programs have crashed in here, and after it. */
PRELOADED void dCloseODE(void)
{
    ready();
    pinch_report_now();
    own_close();
}
