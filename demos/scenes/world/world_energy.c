/* The energy ledger of a world, step by step. */
#include "world.h"

#include <math.h>

static bool has_inertia(const world_finger *finger)
{
    return finger->slider != NULL;
}

void world_begin_ledger(world *w)
{
    bool first = w->steps == 0;
    w->object_energy.body = w->object;
    energy_begin(&w->object_energy);
    if (first) w->object_energy.kinetic_start = w->object_energy.kinetic;
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        if (!has_inertia(finger)) continue;
        finger->energy.body = finger->body;
        energy_begin(&finger->energy);
        if (first) finger->energy.kinetic_start = finger->energy.kinetic;
    }
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* adds `work` to a line and its size to the measure */
static void book(energy_ledger *l, double *line, double work)
{
    *line += work;
    l->work_size += fabs(work);
}

static void keep_object(world *w, double h)
{
    energy_ledger *l = &w->ledger;
    const double *v = dBodyGetLinearVel(w->object), *turning = dBodyGetAngularVel(w->object);
    double m = w->scene->object.mass;
    book(l, &l->gravity, -h * m * dot(w->loads.v[SCENE_GRAVITY], v));
    book(l, &l->work_external,
         h * (dot(w->loads.v[SCENE_FORCE], v) + dot(w->loads.v[SCENE_TORQUE], turning) -
              m * dot(w->loads.v[SCENE_BASE_ACCELERATION], v)));
    l->integrator += energy_integrator(&w->object_energy, h);
    l->kinetic = energy_kinetic(w->object) - w->object_energy.kinetic_start;
}

/* A tip on a slider: its drive pushes along the axis, its damper brakes the motion against the rail, and a moving rail
 * drags it along through the joint. */
static void keep_slider(world *w, world_finger *finger, double h)
{
    energy_ledger *l = &w->ledger;
    const double *v = dBodyGetLinearVel(finger->body), rest[3] = {0, 0, 0};
    const double *rail = finger->rail ? dBodyGetLinearVel(finger->rail) : rest;
    const scene_finger *f = finger->finger;
    double speed = 0;
    for (int i = 0; i < 3; i++) speed += finger->push[i] * (v[i] - rail[i]);
    book(l, &l->work_drives, h * finger->force * dot(finger->push, v));
    book(l, &l->damping, h * f->drive.u.slider.damping * speed * speed);
    if (dBodyGetGravityMode(finger->body)) {
        double m = f->drive.u.slider.mass;
        book(l, &l->gravity, -h * m * dot(w->loads.v[SCENE_GRAVITY], v));
        book(l, &l->work_external, -h * m * dot(w->loads.v[SCENE_BASE_ACCELERATION], v));
    }
    if (finger->rail) {
        const dJointFeedback *fb = &finger->slider_feedback;
        const double *turning = dBodyGetAngularVel(finger->rail);
        book(l, &l->work_drives, -h * (dot(fb->f2, rail) + dot(fb->t2, turning)));
    }
    l->integrator += energy_integrator(&finger->energy, h);
    l->kinetic += energy_kinetic(finger->body) - finger->energy.kinetic_start;
}

void world_keep_ledger(world *w)
{
    energy_ledger *l = &w->ledger;
    double h = w->scene->step;
    keep_object(w, h);
    for (int i = 0; i < w->finger_count; i++)
        if (has_inertia(&w->fingers[i])) keep_slider(w, &w->fingers[i], h);

    pinch_ode_energy contacts;
    if (pinch_ode_contact_energy(w->plugin, &contacts) != PINCH_OK) return;
    book(l, &l->friction, contacts.friction);
    book(l, &l->damping, contacts.damping);
    book(l, &l->work_drives, contacts.drives);
    if (w->steps == 0) w->elastic_initial = w->elastic_before = contacts.elastic_start;
    /* between the steps the geometry goes its own way: what the contacts hold now is not quite what they were left with
     */
    l->integrator += contacts.integrator + w->elastic_before - contacts.elastic_start;
    w->elastic_before = contacts.elastic_end;
    l->elastic = contacts.elastic_end - w->elastic_initial;
    l->closure = l->kinetic + l->gravity + l->elastic - l->work_drives - l->work_external + l->friction + l->damping +
                 l->integrator;
}
