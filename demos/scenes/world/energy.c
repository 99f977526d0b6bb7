/* The energy ledger of a world, step by step. */
#include "world_hand.h"

#include "common/vector.h"

#include <string.h>

/* ---- The ledger. ---- */

static bool has_inertia(const world_finger *finger)
{
    return finger->slider != NULL;
}

void world_begin_ledger(world *w)
{
    bool first = w->steps == 0;
    for (int k = 0; k < w->object_count; k++) {
        w->objects[k].energy.body = w->objects[k].body;
        energy_body_begin(&w->objects[k].energy, first);
    }
    world_begin_hand_ledger(w, first);
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        if (!has_inertia(finger)) continue;
        finger->energy.body = finger->body;
        energy_body_begin(&finger->energy, first);
    }
}

static void add_object(world *w, int k, double h)
{
    energy_ledger *l = &w->ledger;
    const world_object *o = &w->objects[k];
    const scene_object *of = &w->scene->objects[k];
    const double *v = dBodyGetLinearVel(o->body), *turning = dBodyGetAngularVel(o->body);
    const double *force = k ? of->force : w->loads.v[SCENE_FORCE], *torque = k ? of->torque : w->loads.v[SCENE_TORQUE];
    double m = of->mass;
    ledger_add(l, &l->gravity, -h * m * scene_dot(w->loads.v[SCENE_GRAVITY], v));
    ledger_add(
        l, &l->work_external,
        h * (scene_dot(force, v) + scene_dot(torque, turning) - m * scene_dot(w->loads.v[SCENE_BASE_ACCELERATION], v)));
    l->integrator += energy_body_integrator(&o->energy, h);
    l->kinetic += body_kinetic_energy(o->body) - o->energy.kinetic_start;
}

/* For a tip on a slider, the drive pushes along the axis, the damper brakes the motion against the rail, and a moving
 * rail drags the tip along through the joint. A rail that turns leaves errors of position in each step. What the joint
 * gives besides as it takes them back is an effect of the time step. */
static void add_slider(world *w, world_finger *finger, double h)
{
    energy_ledger *l = &w->ledger;
    const double *v = dBodyGetLinearVel(finger->body), rest[3] = {0, 0, 0};
    const double *rail = finger->rail ? dBodyGetLinearVel(finger->rail) : rest;
    const scene_finger *f = finger->finger;
    double speed = 0;
    for (int i = 0; i < 3; i++) speed += finger->push[i] * (v[i] - rail[i]);
    ledger_add(l, &l->work_drives, h * finger->force * scene_dot(finger->push, v));
    ledger_add(l, &l->damping, h * f->drive.u.slider.damping * speed * speed);
    if (dBodyGetGravityMode(finger->body)) {
        double m = f->drive.u.slider.mass;
        ledger_add(l, &l->gravity, -h * m * scene_dot(w->loads.v[SCENE_GRAVITY], v));
        ledger_add(l, &l->work_external, -h * m * scene_dot(w->loads.v[SCENE_BASE_ACCELERATION], v));
    }
    if (finger->rail) {
        const dJointFeedback *fb = &finger->slider_feedback;
        const double *turning = dBodyGetAngularVel(finger->rail), *own = dBodyGetAngularVel(finger->body);
        double given = -scene_dot(fb->f2, rail) - scene_dot(fb->t2, turning);
        double taken = scene_dot(fb->f1, v) + scene_dot(fb->t1, own) + f->drive.u.slider.damping * speed * speed;
        ledger_add(l, &l->work_drives, h * given);
        l->integrator += h * (given - taken);
    }
    l->integrator += energy_body_integrator(&finger->energy, h);
    l->kinetic += body_kinetic_energy(finger->body) - finger->energy.kinetic_start;
}

void world_update_ledger(world *w)
{
    energy_ledger *l = &w->ledger;
    double h = w->scene->step;
    l->kinetic = 0;
    for (int k = 0; k < w->object_count; k++) add_object(w, k, h);
    for (int i = 0; i < w->finger_count; i++)
        if (has_inertia(&w->fingers[i])) add_slider(w, &w->fingers[i], h);
    l->elastic = 0;
    world_update_hand_ledger(w);

    pinch_ode_energy contacts;
    if (pinch_ode_contact_energy(w->plugin, &contacts) != PINCH_OK) return;
    ledger_add(l, &l->friction, contacts.friction);
    ledger_add(l, &l->damping, contacts.damping);
    ledger_add(l, &l->work_drives, contacts.drives);
    if (w->steps == 0) w->elastic_initial = w->elastic_before = contacts.elastic_start;
    /* Bodies move between two solves, so the contacts hold a little more or less energy than they were left with. */
    l->integrator += contacts.integrator + w->elastic_before - contacts.elastic_start;
    w->elastic_before = contacts.elastic_end;
    l->elastic += contacts.elastic_end - w->elastic_initial;
    l->closure = l->kinetic + l->gravity + l->elastic - l->work_drives - l->work_external + l->friction + l->damping +
                 l->integrator;
}
