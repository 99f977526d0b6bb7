/* The energy ledger of a world, step by step. */
#include "world.h"

#include "common/vector.h"

#include <string.h>

void body_world_inertia(dBodyID body, double inertia[9])
{
    dMass mass;
    dMatrix3 turned, I;
    dBodyGetMass(body, &mass);
    dMultiply2_333(turned, mass.I, dBodyGetRotation(body));
    dMultiply0_333(I, dBodyGetRotation(body), turned);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) inertia[3 * i + j] = I[4 * i + j];
}

/* a . I b */
static double product(const double inertia[9], const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) sum += a[i] * inertia[3 * i + j] * b[j];
    return sum;
}

double body_kinetic_energy(dBodyID body)
{
    dMass mass;
    double inertia[9];
    dBodyGetMass(body, &mass);
    body_world_inertia(body, inertia);
    const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    return 0.5 * (mass.mass * dCalcVectorDot3(v, v) + product(inertia, w, w));
}

static void energy_begin(energy_body *b)
{
    memcpy(b->velocity, dBodyGetLinearVel(b->body), 3 * sizeof(double));
    memcpy(b->velocity + 3, dBodyGetAngularVel(b->body), 3 * sizeof(double));
    body_world_inertia(b->body, b->inertia);
    b->kinetic = body_kinetic_energy(b->body);
}

/* The impulse of ODE's gyroscopic torque in a step of length h: I y - L with (I - h [L]x) y = L and L = I w. */
static void gyroscopic_impulse(const double inertia[9], const double *w, double h, double impulse[3])
{
    double L[3], a[3][4];
    for (int i = 0; i < 3; i++) L[i] = inertia[3 * i] * w[0] + inertia[3 * i + 1] * w[1] + inertia[3 * i + 2] * w[2];
    const double skew[3][3] = {{0, -L[2], L[1]}, {L[2], 0, -L[0]}, {-L[1], L[0], 0}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) a[i][j] = inertia[3 * i + j] - h * skew[i][j];
        a[i][3] = L[i];
    }
    for (int k = 0; k < 3; k++) /* Gauss-Jordan without pivoting: the matrix is nearly an inertia */
        for (int i = 0; i < 3; i++) {
            if (i == k) continue;
            double factor = a[i][k] / a[k][k];
            for (int j = k; j < 4; j++) a[i][j] -= factor * a[k][j];
        }
    for (int i = 0; i < 3; i++) {
        impulse[i] = -L[i];
        for (int j = 0; j < 3; j++) impulse[i] += inertia[3 * i + j] * a[j][3] / a[j][j];
    }
}

/* With M (v+ - v) = h f, the work of the forces along the step's motion is h f.v+ = change of 1/2 v.M v + 1/2 dv.M dv.
 * The second term is lost to the time step. So is the difference between what the rotation of the inertia and the
 * gyroscopic torque do to the kinetic energy. */
static double energy_integrator(const energy_body *b, double h)
{
    dMass mass;
    double inertia[9], change[6], impulse[3];
    dBodyGetMass(b->body, &mass);
    body_world_inertia(b->body, inertia);
    const double *v = dBodyGetLinearVel(b->body), *w = dBodyGetAngularVel(b->body);
    for (int i = 0; i < 3; i++) {
        change[i] = v[i] - b->velocity[i];
        change[3 + i] = w[i] - b->velocity[3 + i];
    }
    gyroscopic_impulse(b->inertia, b->velocity + 3, h, impulse);
    double turned = 0.5 * (product(inertia, w, w) - product(b->inertia, w, w));
    return 0.5 * (mass.mass * dCalcVectorDot3(change, change) + product(b->inertia, change + 3, change + 3)) -
           dCalcVectorDot3(impulse, w) - turned;
}

/* ---- The ledger. ---- */

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

/* Adds `work` to a line of the ledger, and its size to the measure. */
static void add_work(energy_ledger *l, double *line, double work)
{
    *line += work;
    l->work_size += fabs(work);
}

static void add_object(world *w, double h)
{
    energy_ledger *l = &w->ledger;
    const double *v = dBodyGetLinearVel(w->object), *turning = dBodyGetAngularVel(w->object);
    double m = w->scene->objects[0].mass;
    add_work(l, &l->gravity, -h * m * scene_dot(w->loads.v[SCENE_GRAVITY], v));
    add_work(l, &l->work_external,
             h * (scene_dot(w->loads.v[SCENE_FORCE], v) + scene_dot(w->loads.v[SCENE_TORQUE], turning) -
                  m * scene_dot(w->loads.v[SCENE_BASE_ACCELERATION], v)));
    l->integrator += energy_integrator(&w->object_energy, h);
    l->kinetic = body_kinetic_energy(w->object) - w->object_energy.kinetic_start;
}

/* For a tip on a slider, the drive pushes along the axis, the damper brakes the motion against the rail, and a moving
 * rail drags the tip along through the joint. */
static void add_slider(world *w, world_finger *finger, double h)
{
    energy_ledger *l = &w->ledger;
    const double *v = dBodyGetLinearVel(finger->body), rest[3] = {0, 0, 0};
    const double *rail = finger->rail ? dBodyGetLinearVel(finger->rail) : rest;
    const scene_finger *f = finger->finger;
    double speed = 0;
    for (int i = 0; i < 3; i++) speed += finger->push[i] * (v[i] - rail[i]);
    add_work(l, &l->work_drives, h * finger->force * scene_dot(finger->push, v));
    add_work(l, &l->damping, h * f->drive.u.slider.damping * speed * speed);
    if (dBodyGetGravityMode(finger->body)) {
        double m = f->drive.u.slider.mass;
        add_work(l, &l->gravity, -h * m * scene_dot(w->loads.v[SCENE_GRAVITY], v));
        add_work(l, &l->work_external, -h * m * scene_dot(w->loads.v[SCENE_BASE_ACCELERATION], v));
    }
    if (finger->rail) {
        const dJointFeedback *fb = &finger->slider_feedback;
        const double *turning = dBodyGetAngularVel(finger->rail);
        add_work(l, &l->work_drives, -h * (scene_dot(fb->f2, rail) + scene_dot(fb->t2, turning)));
    }
    l->integrator += energy_integrator(&finger->energy, h);
    l->kinetic += body_kinetic_energy(finger->body) - finger->energy.kinetic_start;
}

void world_update_ledger(world *w)
{
    energy_ledger *l = &w->ledger;
    double h = w->scene->step;
    add_object(w, h);
    for (int i = 0; i < w->finger_count; i++)
        if (has_inertia(&w->fingers[i])) add_slider(w, &w->fingers[i], h);

    pinch_ode_energy contacts;
    if (pinch_ode_contact_energy(w->plugin, &contacts) != PINCH_OK) return;
    add_work(l, &l->friction, contacts.friction);
    add_work(l, &l->damping, contacts.damping);
    add_work(l, &l->work_drives, contacts.drives);
    if (w->steps == 0) w->elastic_initial = w->elastic_before = contacts.elastic_start;
    /* Bodies move between two solves, so the contacts hold a little more or less energy than they were left with. */
    l->integrator += contacts.integrator + w->elastic_before - contacts.elastic_start;
    w->elastic_before = contacts.elastic_end;
    l->elastic = contacts.elastic_end - w->elastic_initial;
    l->closure = l->kinetic + l->gravity + l->elastic - l->work_drives - l->work_external + l->friction + l->damping +
                 l->integrator;
}
