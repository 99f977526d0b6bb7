/* From pairs and ODE bodies to core problems: who takes part, which islands there are, and their data. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static int drive_of(const pinch_ode *p, dBodyID body)
{
    for (int i = 0; i < p->drives.count; i++)
        if (p->drives.items[i].body == body) return i;
    return -1;
}

/* The step body of an ODE body, -1 for what does not move by itself. -2: no memory. */
static int take_part(pinch_ode *p, dBodyID body)
{
    if (!body) return -1;
    int drive = dBodyIsKinematic(body) ? drive_of(p, body) : -1;
    if (dBodyIsKinematic(body) && drive < 0) return -1;
    uint64_t key = (uint64_t)(uintptr_t)body;
    int index = pinch_key_map_get(&p->body_index, key);
    if (index >= 0) return index;
    index = p->bodies.count;
    if (!PINCH_RESERVE(p->bodies, index + 1) || !pinch_key_map_add(&p->body_index, key, index)) return -2;
    pinch_step_body *b = &p->bodies.items[p->bodies.count++];
    b->body = body;
    b->drive = drive;
    b->parent = index;
    if (drive < 0 && !dBodyIsEnabled(body)) dBodyEnable(body);
    return index;
}

static int root_of(pinch_ode *p, int body)
{
    pinch_step_body *b = p->bodies.items;
    while (b[body].parent != body) body = b[body].parent = b[b[body].parent].parent;
    return body;
}

static void join(pinch_ode *p, int a, int b)
{
    if (a < 0 || b < 0) return;
    a = root_of(p, a);
    b = root_of(p, b);
    if (a < b)
        p->bodies.items[b].parent = a;
    else
        p->bodies.items[a].parent = b;
}

/* A kinematic body's motion is given: it belongs to the right hand side. */
static void follow_kinematic(pinch_joint_rows *rows, dBodyID body, int side)
{
    for (int k = 0; k < rows->count; k++) {
        const double *j = side ? rows->row[k].j2 : rows->row[k].j1;
        rows->row[k].rhs -= pinch_v3_dot(j, dBodyGetLinearVel(body)) + pinch_v3_dot(j + 3, dBodyGetAngularVel(body));
    }
}

static bool take_joint(pinch_ode *p, dJointID joint, double h)
{
    uint64_t key = (uint64_t)(uintptr_t)joint;
    if (pinch_key_map_get(&p->joint_index, key) >= 0) return true;
    if (!PINCH_RESERVE(p->joints, p->joints.count + 1) || !pinch_key_map_add(&p->joint_index, key, p->joints.count))
        return false;
    dBodyID body[2];
    pinch_step_joint *step_joint = &p->joints.items[p->joints.count];
    if (!pinch_joint_rows_of(joint, p->world, h, body, &step_joint->rows)) {
        if (dJointGetType(joint) != dJointTypeContact && dJointGetType(joint) != dJointTypeNull)
            p->stats.joints_unmodelled++;
        return true;
    }
    int index = p->joints.count++;
    for (int side = 0; side < 2; side++) {
        bool kinematic = body[side] && dBodyIsKinematic(body[side]);
        int taken = kinematic ? -1 : take_part(p, body[side]);
        if (taken == -2) return false;
        p->joints.items[index].body[side] = taken;
        if (kinematic) follow_kinematic(&p->joints.items[index].rows, body[side], side);
    }
    join(p, p->joints.items[index].body[0], p->joints.items[index].body[1]);
    return true;
}

static bool collect(pinch_ode *p, double h)
{
    p->bodies.count = 0;
    p->joints.count = 0;
    pinch_key_map_clear(&p->body_index);
    pinch_key_map_clear(&p->joint_index);
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        int a = take_part(p, pair->body[0]), b = take_part(p, pair->body[1]);
        if (a == -2 || b == -2) return false;
        join(p, a, b);
    }
    for (int i = 0; i < p->bodies.count; i++) { /* grows: joints bring in the bodies at their other ends */
        dBodyID body = p->bodies.items[i].body;
        if (p->bodies.items[i].drive >= 0) continue;
        int joints = dBodyGetNumJoints(body);
        for (int k = 0; k < joints; k++) {
            dJointID joint = dBodyGetJoint(body, k);
            if (dJointIsEnabled(joint) && !take_joint(p, joint, h)) return false;
        }
    }
    return true;
}

static int island_of(pinch_ode *p, int body)
{
    return p->bodies.items[body].parent;
}

/* Islands numbered by their first body; afterwards a step body's `parent` is its island. */
static bool number_islands(pinch_ode *p)
{
    int n = p->bodies.count;
    p->islands.count = 0;
    if (!PINCH_RESERVE(p->islands, n + 1) || !PINCH_RESERVE(p->order, n + 1) || !PINCH_RESERVE(p->body_of, n + 1))
        return false;
    for (int i = 0; i < n; i++) p->order.items[i] = root_of(p, i);
    for (int i = 0; i < n; i++) {
        int root = p->order.items[i]; /* a root is never larger than its members */
        pinch_step_body *b = &p->bodies.items[i];
        if (root == i) {
            memset(&p->islands.items[p->islands.count], 0, sizeof *p->islands.items);
            b->parent = p->islands.count++;
        } else {
            b->parent = p->bodies.items[root].parent;
        }
        b->local = p->islands.items[b->parent].body_count++;
    }
    int first = 0;
    for (int k = 0; k < p->islands.count; k++) {
        p->islands.items[k].first_body = first;
        first += p->islands.items[k].body_count;
    }
    for (int i = 0; i < n; i++)
        p->body_of.items[p->islands.items[island_of(p, i)].first_body + p->bodies.items[i].local] = i;
    return true;
}

static void world_inertia(const dMass *mass, const double *R, double *inertia)
{
    double left[9]; /* R I */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            left[3 * i + j] = R[4 * i] * mass->I[j] + R[4 * i + 1] * mass->I[4 + j] + R[4 * i + 2] * mass->I[8 + j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j <= i; j++) {
            double sum = left[3 * i] * R[4 * j] + left[3 * i + 1] * R[4 * j + 1] + left[3 * i + 2] * R[4 * j + 2];
            inertia[3 * i + j] = inertia[3 * j + i] = sum;
        }
}

/* Solves the 3 x 3 system by Cramer's rule: well conditioned here, an inertia plus a small skew part. */
static void solve3(const double *a, const double *b, double *x)
{
    double c0[3] = {a[0], a[3], a[6]}, c1[3] = {a[1], a[4], a[7]}, c2[3] = {a[2], a[5], a[8]}, t[3];
    pinch_v3_cross(c1, c2, t);
    double determinant = pinch_v3_dot(c0, t);
    x[0] = pinch_v3_dot(b, t) / determinant;
    pinch_v3_cross(c2, c0, t);
    x[1] = pinch_v3_dot(b, t) / determinant;
    pinch_v3_cross(c0, c1, t);
    x[2] = pinch_v3_dot(b, t) / determinant;
}

/*
 * ODE's gyroscopic torque, implicit in the angular momentum L = I w:   tau = (I y - L)/h   with   (I - h [L]x) y = L
 * (Lacoursiere, "Stabilizing gyroscopic forces in rigid multibody simulations", 2006).
 */
static void gyroscopic_torque(const double *inertia, const double *w, double h, double *torque)
{
    double L[3], matrix[9], y[3];
    for (int i = 0; i < 3; i++) L[i] = pinch_v3_dot(inertia + 3 * i, w);
    if (L[0] == 0 && L[1] == 0 && L[2] == 0) return;
    memcpy(matrix, inertia, sizeof matrix);
    matrix[1] += h * L[2];
    matrix[2] -= h * L[1];
    matrix[3] -= h * L[2];
    matrix[5] += h * L[0];
    matrix[6] += h * L[1];
    matrix[7] -= h * L[0];
    solve3(matrix, L, y);
    for (int i = 0; i < 3; i++) torque[i] += (pinch_v3_dot(inertia + 3 * i, y) - L[i]) / h;
}

/* One core body: mass and inertia, and the velocity that gravity, applied forces and gyroscopic torque lead to. */
static void fill_body(pinch_ode *p, const pinch_step_body *from, double h, pinch_body *b)
{
    memset(b, 0, sizeof *b);
    pinch_v3_copy(b->position, dBodyGetPosition(from->body));
    b->radius = 1;
    if (from->drive >= 0) {
        const pinch_drive *drive = &p->drives.items[from->drive];
        pinch_v3_copy(b->drive_axis, drive->axis);
        b->drive_force = drive->force;
        pinch_v3_add_scaled(b->velocity, drive->speed, drive->axis);
        return;
    }
    dMass mass;
    dBodyGetMass(from->body, &mass);
    b->mass = mass.mass;
    world_inertia(&mass, dBodyGetRotation(from->body), b->inertia);
    /* the radius of the homogeneous ball with the same trace of inertia */
    b->radius = sqrt(2.5 * (b->inertia[0] + b->inertia[4] + b->inertia[8]) / (3 * mass.mass));

    pinch_v3_copy(b->velocity, dBodyGetLinearVel(from->body));
    pinch_v3_copy(b->velocity + 3, dBodyGetAngularVel(from->body));
    pinch_v3_copy(b->external, dBodyGetForce(from->body));
    pinch_v3_copy(b->external + 3, dBodyGetTorque(from->body));
    if (dBodyGetGravityMode(from->body)) {
        dVector3 gravity;
        dWorldGetGravity(p->world, gravity);
        pinch_v3_add_scaled(b->external, mass.mass, gravity);
    }
    if (dBodyGetGyroscopicMode(from->body)) gyroscopic_torque(b->inertia, b->velocity + 3, h, b->external + 3);
}

static void apply_external(pinch_body *b, double h)
{
    double spin[3];
    if (b->mass == 0) return;
    pinch_v3_add_scaled(b->velocity, h / b->mass, b->external);
    solve3(b->inertia, b->external + 3, spin);
    pinch_v3_add_scaled(b->velocity + 3, h, spin);
}

static bool fill_bodies(pinch_ode *p, double h)
{
    int n = p->bodies.count;
    if (!PINCH_RESERVE(p->core_bodies, n + 1)) return false;
    p->core_bodies.count = n;
    for (int i = 0; i < n; i++) fill_body(p, &p->bodies.items[p->body_of.items[i]], h, &p->core_bodies.items[i]);
    for (int j = 0; j < p->joints.count; j++) { /* what ODE's motors will add by themselves */
        const pinch_step_joint *joint = &p->joints.items[j];
        for (int side = 0; side < 2; side++) {
            if (joint->body[side] < 0) continue;
            const pinch_step_body *b = &p->bodies.items[joint->body[side]];
            pinch_body *core = &p->core_bodies.items[p->islands.items[b->parent].first_body + b->local];
            for (int i = 0; i < 6; i++) core->external[i] += joint->rows.applied[side][i];
        }
    }
    for (int i = 0; i < n; i++) apply_external(&p->core_bodies.items[i], h);
    return true;
}

/* The velocity of a body that is no unknown, at a point; a driven body's own prescribed motion included. */
static void prescribed_velocity(const pinch_ode *p, dBodyID body, int step_body, const double *point, double sign,
                                double *linear, double *angular)
{
    if (!body || (step_body >= 0 && p->bodies.items[step_body].drive < 0)) return;
    const double *w = dBodyGetAngularVel(body);
    double arm[3], turned[3];
    pinch_v3_sub(point, dBodyGetPosition(body), arm);
    pinch_v3_cross(w, arm, turned);
    pinch_v3_add_scaled(linear, sign, dBodyGetLinearVel(body));
    pinch_v3_add_scaled(linear, sign, turned);
    pinch_v3_add_scaled(angular, sign, w);
}

/* The first tangent: a material's facet axis, turned with its geom, or any. */
static void choose_tangent(const pinch_ode *p, const pinch_pair *pair, const double *normal, double *tangent)
{
    for (int side = 0; side < 2; side++) {
        const pinch_geom_record *record = &p->geoms.items[pair->geom[side]];
        const double *axis = record->material.facet_axis;
        if (!record->has_material || (axis[0] == 0 && axis[1] == 0 && axis[2] == 0)) continue;
        const double *R = pinch_geom_pose(record->geom).rotation;
        for (int i = 0; i < 3; i++) tangent[i] = pinch_v3_dot(R + 4 * i, axis);
        double length = pinch_v3_norm(tangent);
        pinch_v3_make_perpendicular(tangent, normal);
        double left = pinch_v3_norm(tangent);
        if (left > 1e-6 * length) {
            pinch_v3_scale(tangent, 1 / left);
            return;
        }
    }
    pinch_v3_any_perpendicular(normal, tangent);
}

static void fill_contact(pinch_ode *p, const pinch_pair *pair, const pinch_material *material, const int body[2],
                         const pinch_manifold_point *point, pinch_contact *c)
{
    int points = pair->manifold.count;
    memset(c, 0, sizeof *c);
    c->body1 = body[0] >= 0 ? p->bodies.items[body[0]].local : PINCH_STATIC_BODY;
    c->body2 = body[1] >= 0 ? p->bodies.items[body[1]].local : PINCH_STATIC_BODY;
    c->model = material->model;
    pinch_v3_copy(c->position, point->position);
    pinch_v3_copy(c->normal, point->normal);
    choose_tangent(p, pair, c->normal, c->tangent1);
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    c->depth = point->depth;
    for (int i = 0; i < 3; i++) { /* the fingertip's stiffness, shared by the points of its manifold */
        c->stiffness[i] = material->stiffness[i] / points;
        c->damping[i] = material->damping[i] / points;
    }
    c->friction[0] = c->friction[1] = point->slipping ? material->friction_kinetic : material->friction;
    c->torsional_friction = material->torsional_friction;
    c->max_force = material->max_force / points;
    c->elastic[0] = pinch_v3_dot(c->tangent1, point->elastic);
    c->elastic[1] = pinch_v3_dot(t2, point->elastic);
    c->elastic[2] = point->twist;
    c->force[0] = point->normal_force;
    c->force[1] = pinch_v3_dot(c->tangent1, point->friction);
    c->force[2] = pinch_v3_dot(t2, point->friction);
    c->force[3] = point->torsion;

    double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        prescribed_velocity(p, pair->body[side], body[side], point->position, side ? -1 : 1, linear, angular);
        /* a driven finger's force is its drive's: a limit below it would leave nothing to balance it */
        if (body[side] >= 0 && p->bodies.items[body[side]].drive >= 0) c->max_force = INFINITY;
    }
    c->surface_velocity[0] = pinch_v3_dot(c->normal, linear);
    c->surface_velocity[1] = pinch_v3_dot(c->tangent1, linear);
    c->surface_velocity[2] = pinch_v3_dot(t2, linear);
    c->surface_velocity[3] = pinch_v3_dot(c->normal, angular);
}

static int step_body_of(const pinch_ode *p, dBodyID body)
{
    return body ? pinch_key_map_get(&p->body_index, (uint64_t)(uintptr_t)body) : -1;
}

/* Contact points and joint rows, counted per island and then laid out island by island. */
static bool fill_contacts(pinch_ode *p)
{
    int total = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        int a = step_body_of(p, pair->body[0]), b = step_body_of(p, pair->body[1]);
        p->islands.items[island_of(p, a >= 0 ? a : b)].contact_count += pair->manifold.count;
        total += pair->manifold.count;
    }
    if (!PINCH_RESERVE(p->core_contacts, total + 1) || !PINCH_RESERVE(p->contacts, total + 1) ||
        !PINCH_RESERVE(p->point_of, total + 1))
        return false;
    p->core_contacts.count = p->contacts.count = p->point_of.count = total;
    int first = 0;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        island->first_contact = first;
        first += island->contact_count;
        island->contact_count = 0;
    }
    total = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->first_contact = total;
        if (pair->manifold.count == 0) continue;
        pinch_material material;
        (void)pinch_pair_material(p, pair, &material); /* a pair has a material or it would have been left to ODE */
        int body[2] = {step_body_of(p, pair->body[0]), step_body_of(p, pair->body[1])};
        pinch_island *island = &p->islands.items[island_of(p, body[0] >= 0 ? body[0] : body[1])];
        for (int k = 0; k < pair->manifold.count; k++) {
            int place = island->first_contact + island->contact_count++;
            fill_contact(p, pair, &material, body, &pair->manifold.point[k], &p->core_contacts.items[place]);
            p->point_of.items[place] = total++;
        }
    }
    return true;
}

static bool fill_rows(pinch_ode *p)
{
    int total = 0;
    for (int j = 0; j < p->joints.count; j++) {
        const pinch_step_joint *joint = &p->joints.items[j];
        int body = joint->body[0] >= 0 ? joint->body[0] : joint->body[1];
        if (body < 0) continue;
        p->islands.items[island_of(p, body)].row_count += joint->rows.count;
        total += joint->rows.count;
    }
    if (!PINCH_RESERVE(p->core_rows, total + 1)) return false;
    p->core_rows.count = total;
    int first = 0;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        island->first_row = first;
        first += island->row_count;
        island->row_count = 0;
    }
    for (int j = 0; j < p->joints.count; j++) {
        const pinch_step_joint *joint = &p->joints.items[j];
        int body = joint->body[0] >= 0 ? joint->body[0] : joint->body[1];
        if (body < 0) continue;
        pinch_island *island = &p->islands.items[island_of(p, body)];
        for (int k = 0; k < joint->rows.count; k++) {
            pinch_joint_row *row = &p->core_rows.items[island->first_row + island->row_count++];
            *row = joint->rows.row[k];
            row->body1 = joint->body[0] >= 0 ? p->bodies.items[joint->body[0]].local : PINCH_STATIC_BODY;
            row->body2 = joint->body[1] >= 0 ? p->bodies.items[joint->body[1]].local : PINCH_STATIC_BODY;
        }
    }
    return true;
}

static bool remember_islands(pinch_ode *p)
{
    if (!PINCH_RESERVE(p->memories, p->islands.count)) return false;
    while (p->memories.count < p->islands.count) {
        if (pinch_step_memory_create(&p->memories.items[p->memories.count]) != PINCH_OK) return false;
        p->memories.count++;
    }
    return true;
}

bool pinch_gather(pinch_ode *p, double h)
{
    return collect(p, h) && number_islands(p) && remember_islands(p) && fill_bodies(p, h) && fill_contacts(p) &&
           fill_rows(p);
}

pinch_problem pinch_island_problem(pinch_ode *p, const pinch_island *island, double h)
{
    pinch_problem problem = {
        .step = h,
        .faces = p->settings.faces,
        .memory = p->memories.items[island - p->islands.items],
        .tag = (uint64_t)(uintptr_t)p->bodies.items[p->body_of.items[island->first_body]].body,
        .body_count = island->body_count,
        .contact_count = island->contact_count,
        .row_count = island->row_count,
        .bodies = p->core_bodies.items + island->first_body,
        .contacts = p->core_contacts.items + island->first_contact,
        .rows = p->core_rows.items + island->first_row,
    };
    return problem;
}
