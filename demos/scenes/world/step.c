/* One step of a scene's world: move the bases, apply loads, detect collisions, solve, read out. */
#include "world_hand.h"

#include "common/measure.h"

#include <math.h>
#include <string.h>

/* A kinematic body follows the finger's prescribed base: it gets the velocity that takes it there by the end of the
 * step. */
static void move_base(const world *w, dBodyID body, const scene_finger *f, double t0, double t1)
{
    double from[3], to[3], turned_from[4], turned_to[4], turning[3], h = t1 - t0;
    scene_base_pose(w->scene, f, t0, from, turned_from);
    scene_base_pose(w->scene, f, t1, to, turned_to);
    world_turning_velocity(turned_from, turned_to, h, turning);
    if (f->has_normal_force) { /* the distance that force control has travelled turns with the hand */
        dQuaternion turn;
        dMatrix3 R;
        dVector3 travelled, carried;
        for (int i = 0; i < 3; i++) travelled[i] = dBodyGetPosition(body)[i] - from[i];
        dQMultiply2(turn, turned_to, turned_from);
        dQtoR(turn, R);
        dMultiply0_331(carried, R, travelled);
        for (int i = 0; i < 3; i++) to[i] += carried[i] - travelled[i];
    }
    dBodySetLinearVel(body, (to[0] - from[0]) / h, (to[1] - from[1]) / h, (to[2] - from[2]) / h);
    dBodySetAngularVel(body, turning[0], turning[1], turning[2]);
}

static void place_bases(world *w, double t0, double t1)
{
    world_move_hand_bases(w, t0, t1);
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *finger = &w->fingers[i];
        if (finger->hand) continue;
        if (finger->rail)
            move_base(w, finger->rail, finger->finger, t0, t1);
        else if (!finger->slider)
            move_base(w, finger->body, finger->finger, t0, t1);
    }
}

/* After the step a prescribed base is put exactly where the scene has it, so that rounding does not add up. A base
 * under force control stays where it has gone. */
static void put_bases_exactly(world *w, double t)
{
    world_put_hand_bases(w, t);
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        if (finger->finger->has_normal_force || finger->hand) continue;
        dBodyID body = finger->rail ? finger->rail : finger->slider ? NULL : finger->body;
        if (!body) continue;
        world_pose pose;
        scene_base_pose(w->scene, finger->finger, t, pose.position, pose.orientation);
        world_put_body(body, &pose);
    }
}

/* The finger's normal now: the normal at the start, turned with the base. */
static void current_normal(const world_finger *finger, double normal[3])
{
    dQuaternion back, turn;
    const double *start = finger->finger->tip_orientation;
    back[0] = start[0];
    for (int i = 1; i < 4; i++) back[i] = -start[i];
    dQMultiply0(turn, dBodyGetQuaternion(finger->body), back);
    dMatrix3 R;
    dQtoR(turn, R);
    dMultiply0_331(normal, R, finger->finger->normal);
}

static void apply_drives(world *w, double t)
{
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        const scene_finger *f = finger->finger;
        double force, *normal = finger->push;
        if (!scene_finger_force(f, &force)) continue;
        finger->force = force * scene_ramp(t, f->ramp);
        current_normal(finger, normal);
        if (finger->slider)
            dBodyAddForce(finger->body, finger->force * normal[0], finger->force * normal[1],
                          finger->force * normal[2]);
        else
            world_keep_status(w,
                              pinch_ode_set_drive(w->plugin, finger->body, normal, fmin(finger->force, f->max_force)));
    }
}

static void apply_loads(world *w, double t)
{
    scene_schedule_at(w->scene, t, &w->loads);
    const double *g = w->loads.v[SCENE_GRAVITY], *a = w->loads.v[SCENE_BASE_ACCELERATION];
    const double *f = w->loads.v[SCENE_FORCE], *m = w->loads.v[SCENE_TORQUE];
    dWorldSetGravity(w->ode, g[0] - a[0], g[1] - a[1], g[2] - a[2]);
    dBodyAddForce(w->object, f[0], f[1], f[2]);
    dBodyAddTorque(w->object, m[0], m[1], m[2]);
    for (int k = 1; k < w->object_count; k++) {
        const scene_object *o = &w->scene->objects[k];
        dBodyAddForce(w->objects[k].body, o->force[0], o->force[1], o->force[2]);
        dBodyAddTorque(w->objects[k].body, o->torque[0], o->torque[1], o->torque[2]);
    }
}

void world_external_wrench(const world *w, int object, double force[3], double moment[3])
{
    const scene_object *o = &w->scene->objects[object];
    for (int i = 0; i < 3; i++) {
        force[i] = (object ? o->force : w->loads.v[SCENE_FORCE])[i] +
                   o->mass * (w->loads.v[SCENE_GRAVITY][i] - w->loads.v[SCENE_BASE_ACCELERATION][i]);
        moment[i] = (object ? o->torque : w->loads.v[SCENE_TORQUE])[i];
    }
}

/* Fingers that touch nothing are solved, too. Returns false when memory runs out. */
static bool hand_over_fingers(world *w)
{
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++)
            if (pinch_ode_add_body(w->plugin, w->hands[k].joints[i].body) != PINCH_OK) return false;
    return true;
}

static world_status step_with_pinch(world *w)
{
    double start = clock_seconds();
    if (!hand_over_fingers(w)) return WORLD_NO_MEMORY;
    for (int i = 0; i < w->contact_count; i++)
        if (pinch_ode_add_contact(w->plugin, &w->contacts[i].contact, w->contacts[i].body[0], w->contacts[i].body[1]) !=
            PINCH_OK)
            return WORLD_NO_MEMORY;
    double handed_over = clock_seconds();
    /* In one call the forces cannot change in between, and what has joints comes to rest and keeps its answer. */
    bool at_once = !w->observe;
    pinch_status status =
        at_once ? pinch_ode_step(w->plugin, w->scene->step) : pinch_ode_solve(w->plugin, w->scene->step);
    w->solve_s += clock_seconds() - handed_over;
    if (status == PINCH_OK && w->observe) w->observe(w->observe_context, w);
    if (status == PINCH_OK && !at_once) status = pinch_ode_advance(w->plugin, w->scene->step);
    w->step_s += clock_seconds() - start;
    if (status == PINCH_INVALID_ARGUMENT) return WORLD_DIVERGED;
    return status == PINCH_OK ? WORLD_OK : WORLD_NO_MEMORY;
}

/* The plane joint holds the object but for rounding, which is removed: z, roll and pitch stay zero. */
static void stay_in_plane(dBodyID object)
{
    const double *x = dBodyGetPosition(object), *q = dBodyGetQuaternion(object);
    const double *v = dBodyGetLinearVel(object), *w = dBodyGetAngularVel(object);
    if (x[2] != 0) dBodySetPosition(object, x[0], x[1], 0);
    if (v[2] != 0) dBodySetLinearVel(object, v[0], v[1], 0);
    if (w[0] != 0 || w[1] != 0) dBodySetAngularVel(object, 0, 0, w[2]);
    if (q[1] == 0 && q[2] == 0) return;
    dQuaternion flat = {q[0], 0, 0, q[3]};
    dBodySetQuaternion(object, flat); /* normalizes */
}

/* ODE aborts on a NaN. No NaN may get in, and nothing that would overflow on the way. */
static bool in_range(const double *values, int count)
{
    static const double LARGEST = 1e100;
    for (int i = 0; i < count; i++)
        if (!(fabs(values[i]) < LARGEST)) return false;
    return true;
}

static bool state_in_range(const world *w)
{
    bool fine = in_range(&w->loads.v[0][0], 3 * SCENE_CHANNEL_COUNT) && in_range(dBodyGetPosition(w->object), 3);
    for (int i = 0; i < w->body_count; i++) {
        const dBodyID body = w->bodies[i];
        fine = fine && in_range(dBodyGetLinearVel(body), 3) && in_range(dBodyGetAngularVel(body), 3);
    }
    return fine;
}

world_status world_advance(world *w)
{
    double h = w->scene->step, t0 = w->steps * h, t1 = (w->steps + 1) * h;
    place_bases(w, t0, t1);
    apply_loads(w, t1);
    apply_drives(w, t1);
    world_drive_hands(w, t1);
    if (w->no_memory) return WORLD_NO_MEMORY;

    w->diverged = !state_in_range(w);
    if (w->diverged) return WORLD_DIVERGED;
    if (w->plugin) world_begin_ledger(w);

    double start = clock_seconds();
    world_status status = w->contacts_given ? WORLD_OK : world_collide(w);
    w->contacts_given = false;
    w->collide_s += clock_seconds() - start;
    if (status != WORLD_OK) return status;
    status = world_guarded_step(w, w->settings.contact_solver == WORLD_PINCH ? step_with_pinch : world_step_with_ode);
    w->diverged = status == WORLD_DIVERGED;
    if (status != WORLD_OK) return status;
    if (w->scene->dimension == 2) stay_in_plane(w->object);
    world_read_joints(w);
    if (w->plugin) world_update_ledger(w);
    put_bases_exactly(w, t1);
    w->steps++;
    w->timed_steps++;
    w->time = t1;
    return world_read_fingers(w);
}
