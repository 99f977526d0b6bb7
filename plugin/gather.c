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
    for (int i = 0; i < n; i++) {
        const pinch_step_body *b = &p->bodies.items[i];
        pinch_island *island = &p->islands.items[b->parent];
        bool enabled = b->drive >= 0 || dBodyIsEnabled(b->body);
        island->awake = island->awake || enabled;
        island->may_sleep = island->may_sleep || (b->drive < 0 && (!enabled || dBodyGetAutoDisableFlag(b->body)));
    }
    for (int i = 0; i < p->pairs.count; i++) /* as in ODE, what moves by itself wakes what it touches */
        for (int side = 0; side < 2; side++) {
            const pinch_pair *pair = &p->pairs.items[i];
            dBodyID body = pair->body[side], other = pair->body[!side];
            if (pair->manifold.count == 0 || !body || !other || !dBodyIsKinematic(body) || !dBodyIsEnabled(body))
                continue;
            int touched = pinch_key_map_get(&p->body_index, (uint64_t)(uintptr_t)other);
            if (touched >= 0) p->islands.items[p->bodies.items[touched].parent].awake = true;
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

/* The first tangent: a material's facet axis, turned with its geom, where there are facets; a cone is round. */
static void choose_tangent(const pinch_ode *p, const pinch_pair *pair, const double *normal, double *tangent)
{
    for (int side = 0; side < 2 && p->settings.faces; side++) {
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

/* The fingertip's law, shared by the points of its manifold. */
static void apply_material(const pinch_ode *p, const pinch_pair *pair, const pinch_material *material,
                           const pinch_manifold_point *point, pinch_contact *c)
{
    int points = pair->manifold.count;
    c->model = material->model;
    choose_tangent(p, pair, c->normal, c->tangent1);
    for (int i = 0; i < 3; i++) { /* the fingertip's stiffness, shared by the points of its manifold */
        c->stiffness[i] = material->stiffness[i] / points;
        c->damping[i] = material->damping[i] / points;
    }
    c->friction[0] = c->friction[1] = point->slipping ? material->friction_kinetic : material->friction;
    c->torsional_friction = material->torsional_friction;
    c->max_force = material->max_force / points;
}

/* A point with surface parameters of its own; the velocities are those at the start of the step. */
static void apply_surface(const pinch_ode *p, const pinch_pair *pair, double h, const int body[2],
                          const pinch_manifold_point *point, pinch_contact *c)
{
    double mobility = 0, linear[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        dBodyID b = pair->body[side];
        dVector3 velocity;
        if (!b) continue;
        dBodyGetPointVel(b, point->position[0], point->position[1], point->position[2], velocity);
        pinch_v3_add_scaled(linear, side ? -1 : 1, velocity);
        if (body[side] < 0) continue;
        dMass mass;
        dBodyGetMass(b, &mass);
        mobility += 1 / mass.mass;
    }
    c->max_force = INFINITY;
    double size = fmin(p->geoms.items[pair->geom[0]].size, p->geoms.items[pair->geom[1]].size);
    pinch_surface_apply(&point->surface, p->world, h, p->settings.tangential_ratio, mobility, size,
                        pinch_v3_dot(linear, c->normal), point->normal_force > 0, c);
    pinch_v3_copy(c->compliance, point->compliance);
    c->floor = point->floor;
    c->hold = point->hold;
}

static void fill_history(const pinch_manifold_point *point, pinch_contact *c)
{
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    c->elastic[0] = pinch_v3_dot(c->tangent1, point->elastic);
    c->elastic[1] = pinch_v3_dot(t2, point->elastic);
    c->elastic[2] = point->twist;
    c->force[0] = point->normal_force;
    c->force[1] = pinch_v3_dot(c->tangent1, point->friction);
    c->force[2] = pinch_v3_dot(t2, point->friction);
    c->force[3] = point->torsion;
    if (c->model != PINCH_CONTACT_ROLLING) return;
    c->rolling_elastic[0] = pinch_v3_dot(c->tangent1, point->rolled);
    c->rolling_elastic[1] = pinch_v3_dot(t2, point->rolled);
    c->rolling_moment[0] = pinch_v3_dot(c->tangent1, point->rolling_moment);
    c->rolling_moment[1] = pinch_v3_dot(t2, point->rolling_moment);
}

/* material: NULL where the points have surface parameters. */
static void fill_contact(pinch_ode *p, const pinch_pair *pair, const pinch_material *material, double h,
                         const int body[2], const pinch_manifold_point *point, pinch_contact *c)
{
    memset(c, 0, sizeof *c);
    c->body1 = body[0] >= 0 ? p->bodies.items[body[0]].local : PINCH_STATIC_BODY;
    c->body2 = body[1] >= 0 ? p->bodies.items[body[1]].local : PINCH_STATIC_BODY;
    pinch_v3_copy(c->position, point->position);
    pinch_v3_copy(c->normal, point->normal);
    c->depth = point->depth;
    if (material)
        apply_material(p, pair, material, point, c);
    else
        apply_surface(p, pair, h, body, point, c);
    fill_history(point, c);

    double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        prescribed_velocity(p, pair->body[side], body[side], point->position, side ? -1 : 1, linear, angular);
        /* a driven finger's force is its drive's: a limit below it would leave nothing to balance it */
        if (body[side] >= 0 && p->bodies.items[body[side]].drive >= 0) c->max_force = INFINITY;
    }
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    c->surface_velocity[0] += pinch_v3_dot(c->normal, linear);
    c->surface_velocity[1] += pinch_v3_dot(c->tangent1, linear);
    c->surface_velocity[2] += pinch_v3_dot(t2, linear);
    c->surface_velocity[3] += pinch_v3_dot(c->normal, angular);
    if (c->model != PINCH_CONTACT_ROLLING) return;
    c->surface_velocity[4] += pinch_v3_dot(c->tangent1, angular);
    c->surface_velocity[5] += pinch_v3_dot(t2, angular);
}

static int step_body_of(const pinch_ode *p, dBodyID body)
{
    return body ? pinch_key_map_get(&p->body_index, (uint64_t)(uintptr_t)body) : -1;
}

/* Contact points and joint rows, counted per island and then laid out island by island. */
static bool fill_contacts(pinch_ode *p, double h)
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
        !PINCH_RESERVE(p->point_of, total + 1) || !PINCH_RESERVE(p->core_of, total + 1))
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
        bool has_material = pair->has_material && pinch_pair_material(p, pair, &material);
        int body[2] = {step_body_of(p, pair->body[0]), step_body_of(p, pair->body[1])};
        pair->island = island_of(p, body[0] >= 0 ? body[0] : body[1]);
        pinch_island *island = &p->islands.items[pair->island];
        for (int k = 0; k < pair->manifold.count; k++) {
            int place = island->first_contact + island->contact_count++;
            fill_contact(p, pair, has_material ? &material : NULL, h, body, &pair->manifold.point[k],
                         &p->core_contacts.items[place]);
            p->core_of.items[total] = place;
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
    return collect(p, h) && number_islands(p) && remember_islands(p) && pinch_fill_bodies(p, h) &&
           fill_contacts(p, h) && fill_rows(p);
}

pinch_problem pinch_island_problem(pinch_ode *p, const pinch_island *island, double h)
{
    pinch_problem problem = {
        .step = h,
        .faces = p->settings.faces,
        .memory = p->settings.cold_start ? NULL : p->memories.items[island - p->islands.items],
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
