/* What the layer does when joints, groups, geoms, spaces and worlds come and go, and meshes change. */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/registry.h"
#include "dropin/state.h"

dJointID pinch_layer_joint_create_contact(dWorldID world, dJointGroupID group, const dContact *contact)
{
    dJointID joint = pinch_layer_own()->ode_joint_create_contact(world, group, contact);
    if (!joint || pinch_layer_is_inside(world) || pinch_layer_is_out_of_scope(contact->surface.mode)) return joint;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, world);
    if (!live || !pinch_registry_add_joint(&state->registry, live, group, joint, contact))
        state->registry.ended.contacts_unrecorded++;
    pinch_layer_unlock();
    return joint;
}

dJointID pinch_layer_note_joint(dWorldID world, dJointGroupID group, dJointID joint)
{
    if (!joint || pinch_layer_is_inside(world)) return joint;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, world);
    if (live) (void)pinch_registry_add_joint(&state->registry, live, group, joint, NULL);
    pinch_layer_unlock();
    return joint;
}

#define CREATE_JOINT(type, name, ode_name, parameters, arguments)                                                      \
    type pinch_layer_##name parameters                                                                                 \
    {                                                                                                                  \
        return pinch_layer_note_joint(world, group, pinch_layer_own()->ode_##name arguments);                          \
    }
PINCH_DROPIN_JOINT_CALLS(CREATE_JOINT)

void pinch_layer_joint_destroy(dJointID joint)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_registry_drop_joint(&state->registry, joint);
    pinch_layer_unlock();
    pinch_layer_own()->ode_joint_destroy(joint);
}

void pinch_layer_joint_group_empty(dJointGroupID group)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_registry_empty_group(&state->registry, group);
    pinch_layer_unlock();
    pinch_layer_own()->ode_joint_group_empty(group);
}

void pinch_layer_joint_group_destroy(dJointGroupID group)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_registry_drop_group(&state->registry, group);
    pinch_layer_unlock();
    pinch_layer_own()->ode_joint_group_destroy(group);
}

void pinch_layer_world_destroy(dWorldID world)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_find_world(&state->registry, world);
    if (live) {
        pinch_registry_take_world(&state->registry, live);
        pinch_layer_update_scope();
        pinch_layer_add_stats(&state->registry.ended, &live->stats);
        live->current.memory = 0;
        pinch_layer_add_plugin_stats(&state->registry.ended.ode, &live->current);
        state->registry.ended.worlds++;
    }
    pinch_layer_unlock();
    if (live) {
        pinch_ode_destroy(live->plugin);
        pinch_registry_free_world(live);
    }
    pinch_layer_own()->ode_world_destroy(world);
}

static void forget_geom_in(pinch_live_world *live, dGeomID geom)
{
    for (int i = 0; i < live->materials.count; i++) { /* first: the geom may be gone, and its size is still known */
        if (live->materials.items[i].geom != geom) continue;
        live->materials.items[i] = live->materials.items[--live->materials.count];
        if (live->plugin) (void)pinch_ode_set_material(live->plugin, geom, NULL);
        pinch_layer_update_scope();
        break;
    }
    if (live->plugin) (void)pinch_ode_forget_geom(live->plugin, geom);
}

static void forget_body_in(pinch_live_world *live, dBodyID body)
{
    if (live->plugin && pinch_ode_forget_body(live->plugin, body) == PINCH_OK) return;
    pinch_joint_poses_forget_body(&live->joint_poses, body);
    live->waiting_lost = live->waiting_lost || live->plugin;
}

void pinch_layer_forget(pinch_live_world *live, const pinch_layer_gone *gone)
{
    if (gone->geom) forget_geom_in(live, gone->geom);
    if (gone->body) forget_body_in(live, gone->body);
    if (gone->joint && live->plugin) (void)pinch_ode_forget_joint(live->plugin, gone->joint);
    if (gone->joint && !live->plugin) pinch_joint_poses_forget_joint(&live->joint_poses, gone->joint);
}

/* At once, or when the step that is under way is done. */
static void forget(pinch_live_world *live, const pinch_layer_gone *gone)
{
    if (!live->busy)
        pinch_layer_forget(live, gone);
    else if (PINCH_RESERVE(live->waiting, live->waiting.count + 1))
        live->waiting.items[live->waiting.count++] = *gone;
    else
        live->waiting_lost = true;
}

void pinch_layer_joint_gone(pinch_live_world *live, dJointID joint)
{
    forget(live, &(pinch_layer_gone){.joint = joint});
}

static void forget_geom(pinch_registry *registry, dGeomID geom)
{
    pinch_registry_drop_geom(registry, geom);
    for (pinch_live_world *live = registry->worlds; live; live = live->next) {
        pinch_registry_forget_geom(live, geom);
        forget(live, &(pinch_layer_gone){.geom = geom});
    }
}

/* Forgets a geom and what ODE frees with it. ODE deprecates transforms, but programs still have them. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
static void forget_geoms_of(pinch_registry *registry, dGeomID geom)
{
    if (dGeomGetClass(geom) == dGeomTransformClass && dGeomTransformGetCleanup(geom)) {
        dGeomID inner = dGeomTransformGetGeom(geom);
        if (inner) forget_geom(registry, inner);
    }
    forget_geom(registry, geom);
}
#pragma GCC diagnostic pop

static dGeomID note_geom(dGeomID geom)
{
    if (!geom) return NULL;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_registry_note_geom(&state->registry, geom);
    pinch_layer_unlock();
    return geom;
}

#define CREATE_GEOM(type, name, ode_name, parameters, arguments)                                                       \
    type pinch_layer_##name parameters                                                                                 \
    {                                                                                                                  \
        return note_geom(pinch_layer_own()->ode_##name arguments);                                                     \
    }
PINCH_DROPIN_GEOM_CALLS(CREATE_GEOM)

void pinch_layer_body_destroy(dBodyID body)
{
    dWorldID world = dBodyGetWorld(body);
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_find_world(&state->registry, world);
    if (live) forget(live, &(pinch_layer_gone){.body = body});
    pinch_layer_unlock();
    pinch_layer_own()->ode_body_destroy(body);
}

void pinch_layer_geom_destroy(dGeomID geom)
{
    pinch_layer_state *state = pinch_layer_lock();
    forget_geoms_of(&state->registry, geom);
    pinch_layer_unlock();
    pinch_layer_own()->ode_geom_destroy(geom);
}

static void forget_any_geom(void)
{
    const pinch_layer_state *state = pinch_layer_lock();
    for (pinch_live_world *live = state->registry.worlds; live; live = live->next) pinch_registry_forget_any_geom(live);
    pinch_layer_unlock();
}

/* Forgets the geoms that a space takes with it. A quadtree space does not list its geoms: no contact made so far names
 * any of them then, and what else is noted of them stays. To ask all geoms that there are would touch some that ODE has
 * freed by itself. */
static void forget_space(dSpaceID space)
{
    if (dSpaceGetClass(space) == dQuadTreeSpaceClass) {
        forget_any_geom();
        return;
    }
    int count = dSpaceGetNumGeoms(space);
    for (int i = 0; i < count; i++) {
        dGeomID geom = dSpaceGetGeom(space, i);
        if (dGeomIsSpace(geom) && dSpaceGetCleanup((dSpaceID)geom)) forget_space((dSpaceID)geom);
        pinch_layer_state *state = pinch_layer_lock();
        forget_geoms_of(&state->registry, geom);
        pinch_layer_unlock();
    }
}

void pinch_layer_space_destroy(dSpaceID space)
{
    if (dSpaceGetCleanup(space)) forget_space(space);
    pinch_layer_own()->ode_space_destroy(space);
}

void pinch_layer_space_clean(dSpaceID space)
{
    forget_space(space);
    pinch_layer_own()->ode_space_clean(space);
}

/* Has a geom's spaces look at it anew, as where it has moved. */
static void put_where_it_is(dGeomID geom)
{
    dBodyID body = dGeomGetBody(geom);
    const dReal *x = dGeomGetPosition(geom);
    if (body)
        dGeomSetBody(geom, body); /* keeps the last bits of an offset */
    else
        dGeomSetPosition(geom, x[0], x[1], x[2]);
}

/*
 * A space looks at the geoms first in its list up to the first that has not moved. ODE says of a mesh with other data
 * that it has moved, and leaves it where it is in the list: there it is found only where all geoms before it move, as
 * the bodies on it do in ODE's step, but not while they are at rest. ODE ends the program where a space then meets it.
 */
void pinch_layer_geom_trimesh_set_data(dGeomID mesh, dTriMeshDataID data)
{
    put_where_it_is(mesh);
    pinch_layer_own()->ode_geom_trimesh_set_data(mesh, data);
}

/* Tells whether ODE may have no place for a geom: it does not show that of a height field. */
static bool may_have_no_place(dGeomID geom)
{
    int class = dGeomGetClass(geom);
    return dGeomIsSpace(geom) || class == dPlaneClass || (class == dHeightfieldClass && !dGeomGetBody(geom));
}

static void meets_nothing(void *data, dGeomID a, dGeomID b)
{
    (void)data, (void)a, (void)b;
}

/* Has a space look at all of its geoms that have moved. */
static void look_around(dSpaceID space)
{
    static const double POINT = 1e-9;
    dGeomID point = pinch_layer_own()->ode_create_sphere(NULL, POINT);
    dSpaceCollide2((dGeomID)space, point, NULL, meets_nothing);
    pinch_layer_own()->ode_geom_destroy(point);
}

/*
 * ODE puts a geom that it adds first in the list, and does not say that it has moved. So the space does not look at
 * those behind it that have, such as the space that the geom was taken from, until the geom's body moves, which does
 * not happen at rest. A geom without a place cannot be said to have moved: the space looks at the others before it
 * comes. ODE itself adds a geom that it makes, of no class yet, which the space looks at.
 */
void pinch_layer_space_add(dSpaceID space, dGeomID geom)
{
    bool new = dGeomGetClass(geom) < 0, placed = !new && !may_have_no_place(geom);
    if (!new && !placed) look_around(space);
    pinch_layer_own()->ode_space_add(space, geom);
    if (placed) put_where_it_is(geom);
}
