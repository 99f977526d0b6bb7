/* A step of the program is Pinch's, or ODE's own where Pinch refuses. */
#define _POSIX_C_SOURCE 200809L

#include "dropin/state.h"
#include "ode_internal.h"

#include <string.h>
#include <time.h>

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int own_step(dWorldID world, dReal h, pinch_ode_stepper stepper)
{
    const pinch_layer_calls *own = pinch_layer_own();
    return stepper == PINCH_ODE_QUICKSTEP ? own->ode_world_quick_step(world, h) : own->ode_world_step(world, h);
}

bool pinch_layer_have_plugin(pinch_live_world *live, const pinch_ode_settings *settings)
{
    if (live->plugin) return true;
    pinch_ode *plugin;
    if (pinch_ode_create(live->id, settings, &plugin) != PINCH_OK) return false;
    pinch_use_joint_poses(plugin, &live->joint_poses);
    for (int i = 0; i < live->materials.count; i++) {
        const pinch_layer_material *m = &live->materials.items[i];
        if (pinch_ode_set_material(plugin, m->geom, &m->material) == PINCH_OK) continue;
        pinch_ode_destroy(plugin);
        return false;
    }
    live->plugin = plugin;
    return true;
}

static void end_plugin(pinch_live_world *live, pinch_dropin_stats *done)
{
    if (!live->plugin) return;
    pinch_ode_stats last = pinch_ode_statistics(live->plugin);
    last.memory = 0;
    pinch_layer_add_plugin_stats(&done->ode, &last);
    pinch_ode_destroy(live->plugin);
    live->plugin = NULL;
}

static bool can_move(dBodyID body)
{
    return body && !dBodyIsKinematic(body);
}

/* Tells whether a contact joint between these bodies does something when ODE steps. */
static bool acts(dJointID joint, const dBodyID body[2])
{
    return (can_move(body[0]) || can_move(body[1])) && dJointIsEnabled(joint);
}

static bool has_geom(dBodyID body, dGeomID geom)
{
    dGeomID own = body ? dBodyGetFirstGeom(body) : NULL;
    while (own && own != geom) own = dBodyGetNextGeom(own);
    return own;
}

static bool has_material(const pinch_live_world *live, dGeomID geom)
{
    for (int i = 0; i < live->materials.count; i++)
        if (live->materials.items[i].geom == geom) return true;
    return false;
}

/*
 * Tells whether a name in a contact is that of a geom on its side of the contact. Programs leave g1 and g2 unset: then
 * they are whatever was in that place of memory, a geom of an earlier contact or no geom at all.
 */
static bool is_meant(const pinch_live_world *live, dGeomID geom, bool known, dBodyID body)
{
    if (!known) return has_geom(body, geom);
    return dGeomGetBody(geom) == body || has_material(live, geom);
}

/* Returns the contact that a joint was made from, without names that mean nothing, in `copy` where there are any. */
static const dContact *meant_contact(const pinch_live_joint *joint, const dBodyID body[2], dContact *copy)
{
    dGeomID g1 = joint->contact.geom.g1, g2 = joint->contact.geom.g2;
    bool first = !g1 || is_meant(joint->world, g1, joint->known[0], body[0]);
    bool second = !g2 || is_meant(joint->world, g2, joint->known[1], body[1]);
    if (first && second) return &joint->contact;
    *copy = joint->contact;
    if (!first) copy->geom.g1 = NULL;
    if (!second) copy->geom.g2 = NULL;
    return copy;
}

static bool any_awake(const pinch_joint_list *list)
{
    for (const pinch_live_joint *joint = list->first; joint; joint = joint->next)
        for (int side = 0; side < 2; side++) {
            dBodyID body = dJointGetBody(joint->joint, side);
            if (body && dBodyIsEnabled(body)) return true;
        }
    return false;
}

/* Counts the contacts of a world that goes on sleeping. */
static void count_asleep(const pinch_live_world *live, pinch_dropin_stats *done)
{
    for (const pinch_live_joint *joint = live->contacts.first; joint; joint = joint->next) {
        const dBodyID body[2] = {dJointGetBody(joint->joint, 0), dJointGetBody(joint->joint, 1)};
        ++*(acts(joint->joint, body) ? &done->contacts_offered : &done->contacts_idle);
    }
    done->ode.contacts_asleep = done->contacts_offered;
}

/* Hands the live contact joints over. Those that act are counted, whatever the outcome. */
static bool offer(pinch_live_world *live, pinch_dropin_stats *done)
{
    bool taken = live->plugin != NULL;
    for (pinch_live_joint *joint = live->contacts.first; joint; joint = joint->next) {
        const dBodyID body[2] = {dJointGetBody(joint->joint, 0), dJointGetBody(joint->joint, 1)};
        if (!acts(joint->joint, body)) {
            done->contacts_idle++;
            continue;
        }
        done->contacts_offered++;
        dContact copy;
        taken = taken && pinch_add_joint_between(live->plugin, joint->joint, body, meant_contact(joint, body, &copy)) ==
                             PINCH_OK;
    }
    return taken;
}

/* Tells whether an island without contacts may be Pinch's (pinch_ode_add_body). */
static bool may_be_all_joints(const pinch_live_world *live, const pinch_ode_settings *settings)
{
    return settings->scope == PINCH_ODE_ALL_CONTACTS && !settings->joints_by_ode && live->others.count > 0;
}

/* Hands over the bodies that have joints, some of them more than once. */
static bool offer_jointed(const pinch_live_world *live)
{
    bool taken = live->plugin != NULL;
    dBodyID last = NULL;
    for (const pinch_live_joint *joint = live->others.first; joint && taken; joint = joint->next)
        for (int side = 0; side < 2 && taken; side++) {
            dBodyID body = dJointGetBody(joint->joint, side);
            if (!body || body == last) continue;
            taken = pinch_ode_add_body(live->plugin, body) == PINCH_OK;
            last = body;
        }
    return taken;
}

static bool find_forces(pinch_live_world *live, dReal h, pinch_ode_stepper stepper, const pinch_ode_settings *settings,
                        pinch_dropin_stats *done)
{
    bool ready = pinch_layer_have_plugin(live, settings) && pinch_ode_set_stepper(live->plugin, stepper) == PINCH_OK;
    if (ready && live->moved_callbacks) pinch_leave_motion_to_ode(live->plugin);
    bool offered = offer(live, done);
    if (ready && may_be_all_joints(live, settings)) offered = offer_jointed(live) && offered;
    return offered && ready && pinch_solve_to_advance(live->plugin, h) == PINCH_OK;
}

/* Steps a world. One that has never had a contact, nor joints that would be Pinch's, is stepped by ODE alone. So is one
 * that sleeps, after a step in which Pinch has told the contacts so. */
static int step_world(pinch_live_world *live, dReal h, pinch_ode_stepper stepper, const pinch_ode_settings *settings,
                      pinch_dropin_stats *done)
{
    double begin = seconds();
    bool needed = live->plugin || live->contacts.count > 0 || may_be_all_joints(live, settings);
    bool asleep = live->plugin && live->contacts.count > 0 && !any_awake(&live->contacts) && !any_awake(&live->others);
    bool slept = live->asleep;
    live->asleep = asleep;
    if (asleep && slept) {
        count_asleep(live, done);
        needed = false;
    }
    bool found = needed && find_forces(live, h, stepper, settings, done);
    double middle = seconds();
    int stepped;
    if (asleep && slept) {
        stepped = own_step(live->id, h, stepper);
    } else if (found) {
        stepped = pinch_ode_advance(live->plugin, h) == PINCH_OK;
    } else {
        end_plugin(live, done); /* contacts that were handed over and not solved go with it */
        stepped = own_step(live->id, h, stepper);
    }
    done->steps = 1;
    done->steps_refused = needed && !found;
    done->contacts_refused = found || !needed ? 0 : done->contacts_offered;
    done->time_pinch = middle - begin;
    done->time_ode = seconds() - middle;
    return stepped;
}

void pinch_layer_release(pinch_live_world *live, const pinch_dropin_stats *done)
{
    void (*backed_off)(long step) = pinch_layer_own()->backed_off;
    (void)pinch_layer_lock();
    while (live->waiting.count > 0) pinch_layer_forget(live, &live->waiting.items[--live->waiting.count]);
    if (live->to_reset && live->plugin) pinch_ode_reset_statistics(live->plugin);
    live->to_reset = false;
    if (done) pinch_layer_add_stats(&live->stats, done);
    if (!live->plugin)
        memset(&live->current, 0, sizeof live->current);
    else if (live->current.memory > 0)
        pinch_count(live->plugin, &live->current);
    else
        live->current = pinch_ode_statistics(live->plugin);
    bool tells = backed_off && !live->told && live->current.backoffs > 0;
    live->told = live->told || tells;
    long steps = live->current.steps;
    live->busy = false;
    pinch_layer_unlock();
    if (tells) backed_off(steps);
}

static int step(dWorldID world, dReal h, pinch_ode_stepper stepper)
{
    if (pinch_layer_is_inside(world)) return own_step(world, h, stepper);
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_world(&state->registry, world);
    bool ours = live && !live->busy;
    if (ours) {
        live->busy = true;
        pinch_registry_drop_names(live);
    }
    pinch_ode_settings settings = state->settings;
    pinch_layer_unlock();
    if (!ours) return own_step(world, h, stepper);

    pinch_dropin_stats done;
    memset(&done, 0, sizeof done);
    if (live->waiting_lost) end_plugin(live, &done);
    live->waiting_lost = false;
    dWorldID outer = pinch_layer_enter(world);
    int stepped = step_world(live, h, stepper, &settings, &done);
    (void)pinch_layer_enter(outer);
    pinch_layer_release(live, &done);
    if (pinch_layer_own()->stepped) pinch_layer_own()->stepped();
    return stepped;
}

int pinch_layer_world_step(dWorldID world, dReal h)
{
    return step(world, h, PINCH_ODE_WORLDSTEP);
}

int pinch_layer_world_quick_step(dWorldID world, dReal h)
{
    return step(world, h, PINCH_ODE_QUICKSTEP);
}
