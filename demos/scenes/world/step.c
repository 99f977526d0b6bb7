/* One step of a scene's world: move the bases, apply loads, detect collisions, solve, read out. */
#include "world.h"

#include "common/measure.h"

#include <pinch/fingertip.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_POINTS = 16 }; /* contact points of one pair */

/* The angular velocity that turns orientation a into b in h seconds. */
static void turning_velocity(const double a[4], const double b[4], double h, double w[3])
{
    dQuaternion turn; /* b a^-1 */
    dQMultiply2(turn, b, a);
    double sine = sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    double angle = 2 * atan2(sine, fabs(turn[0])), scale = sine > 0 ? angle / (sine * h) : 0;
    if (turn[0] < 0) scale = -scale;
    for (int i = 0; i < 3; i++) w[i] = scale * turn[1 + i];
}

/* A kinematic body follows the finger's prescribed base: it gets the velocity that takes it there by the end of the
 * step. */
static void move_base(const world *w, dBodyID body, const scene_finger *f, double t0, double t1)
{
    double from[3], to[3], turned_from[4], turned_to[4], turning[3], h = t1 - t0;
    scene_base_pose(w->scene, f, t0, from, turned_from);
    scene_base_pose(w->scene, f, t1, to, turned_to);
    turning_velocity(turned_from, turned_to, h, turning);
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

static void place_bases(const world *w, double t0, double t1)
{
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *finger = &w->fingers[i];
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
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        if (finger->finger->has_normal_force) continue;
        dBodyID body = finger->rail ? finger->rail : finger->slider ? NULL : finger->body;
        if (!body) continue;
        const double *v = dBodyGetLinearVel(body), *turning = dBodyGetAngularVel(body);
        if (v[0] == 0 && v[1] == 0 && v[2] == 0 && turning[0] == 0 && turning[1] == 0 && turning[2] == 0) continue;
        double position[3], orientation[4];
        scene_base_pose(w->scene, finger->finger, t, position, orientation);
        dBodySetPosition(body, position[0], position[1], position[2]);
        dBodySetQuaternion(body, orientation);
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
            (void)pinch_ode_set_drive(w->plugin, finger->body, normal, fmin(finger->force, f->max_force));
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
}

void world_external_wrench(const world *w, double force[3], double moment[3])
{
    for (int i = 0; i < 3; i++) {
        force[i] = w->loads.v[SCENE_FORCE][i] +
                   w->scene->objects[0].mass * (w->loads.v[SCENE_GRAVITY][i] - w->loads.v[SCENE_BASE_ACCELERATION][i]);
        moment[i] = w->loads.v[SCENE_TORQUE][i];
    }
}

static bool boxes_apart(const dReal *a, const dReal *b)
{
    return a[0] > b[1] || b[0] > a[1] || a[2] > b[3] || b[2] > a[3] || a[4] > b[5] || b[4] > a[5];
}

/* Can what it meets stop this tip? It can where the tip is on a slider or under force control. */
static bool can_be_stopped(const world *w, int geom)
{
    int finger = w->categories[geom];
    return finger >= 0 && (w->fingers[finger].slider || w->fingers[finger].finger->has_normal_force);
}

/* Spheres, boxes and capsules are left to ODE's own colliders. */
static bool exact_in_ode(int class)
{
    return class == dSphereClass || class == dBoxClass || class == dCapsuleClass;
}

static int find_contacts(dGeomID a, dGeomID b, dContactGeom *contacts)
{
    if (exact_in_ode(dGeomGetClass(a)) && exact_in_ode(dGeomGetClass(b)))
        return dCollide(a, b, MAX_POINTS, contacts, sizeof contacts[0]);
    return pinch_tip_collide(a, b, MAX_POINTS, contacts, sizeof contacts[0]);
}

/* index_a and index_b are places in `geoms`; -1 stands for the object. */
static world_status collide_two(world *w, int index_a, int index_b, int owner)
{
    dGeomID a = index_a < 0 ? w->object_geom : w->geoms[index_a], b = w->geoms[index_b];
    const pinch_material *material = &w->materials[index_a < 0 ? index_b : index_a];
    dReal box_a[6], box_b[6];
    dGeomGetAABB(a, box_a);
    dGeomGetAABB(b, box_b);
    if (boxes_apart(box_a, box_b)) return WORLD_OK;
    if (!world_contact_room(w, w->contact_count + MAX_POINTS)) return WORLD_NO_MEMORY;
    dContactGeom geoms[MAX_POINTS];
    int count = find_contacts(a, b, geoms);
    for (int i = 0; i < count; i++) {
        world_contact *c = &w->contacts[w->contact_count++];
        memset(c, 0, sizeof *c);
        c->contact.geom = geoms[i];
        c->body[0] = dGeomGetBody(geoms[i].g1);
        c->body[1] = dGeomGetBody(geoms[i].g2);
        c->owner = owner;
        c->sharing = count;
        c->material = material;
        w->depth_max = fmax(w->depth_max, geoms[i].depth);
        if (index_a < 0 && owner < 0) w->environment_touched = true;
    }
    return WORLD_OK;
}

/* The object is tested against everything. Tips that can be stopped are tested against the other tips and the
 * environment, too. */
static world_status collide(world *w)
{
    w->contact_count = 0;
    w->environment_touched = false;
    world_status status = WORLD_OK;
    for (int i = 0; i < w->geom_count && status == WORLD_OK; i++) status = collide_two(w, -1, i, w->categories[i]);
    for (int i = 0; i < w->geom_count; i++) {
        if (w->categories[i] < 0) continue;
        for (int k = 0; k < w->geom_count && status == WORLD_OK; k++) {
            bool both_tips = w->categories[k] >= 0;
            if (k == i || (both_tips && k < i)) continue;
            if (!can_be_stopped(w, i) && !(both_tips && can_be_stopped(w, k))) continue;
            status = collide_two(w, i, k, -1);
        }
    }
    return status;
}

static world_status step_with_pinch(world *w)
{
    double start = clock_seconds();
    for (int i = 0; i < w->contact_count; i++)
        if (pinch_ode_add_contact(w->plugin, &w->contacts[i].contact, w->contacts[i].body[0], w->contacts[i].body[1]) !=
            PINCH_OK)
            return WORLD_NO_MEMORY;
    double handed_over = clock_seconds();
    pinch_status status = pinch_ode_solve(w->plugin, w->scene->step);
    w->solve_s += clock_seconds() - handed_over;
    if (status == PINCH_OK && w->observe) w->observe(w->observe_context, w);
    if (status == PINCH_OK) status = pinch_ode_advance(w->plugin, w->scene->step);
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
    bool fine = in_range(&w->loads.v[0][0], 3 * SCENE_CHANNEL_COUNT) && in_range(dBodyGetPosition(w->object), 3) &&
                in_range(dBodyGetLinearVel(w->object), 3) && in_range(dBodyGetAngularVel(w->object), 3);
    for (int i = 0; i < w->finger_count; i++) {
        const dBodyID body = w->fingers[i].body;
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

    w->diverged = !state_in_range(w);
    if (w->diverged) return WORLD_DIVERGED;
    if (w->plugin) world_begin_ledger(w);

    double start = clock_seconds();
    world_status status = w->contacts_given ? WORLD_OK : collide(w);
    w->contacts_given = false;
    w->collide_s += clock_seconds() - start;
    if (status != WORLD_OK) return status;
    status = world_guarded_step(w, w->settings.contact_solver == WORLD_PINCH ? step_with_pinch : world_step_with_ode);
    w->diverged = status == WORLD_DIVERGED;
    if (status != WORLD_OK) return status;
    if (w->scene->dimension == 2) stay_in_plane(w->object);
    if (w->plugin) world_update_ledger(w);
    put_bases_exactly(w, t1);
    w->steps++;
    w->time = t1;
    return world_read_fingers(w);
}
