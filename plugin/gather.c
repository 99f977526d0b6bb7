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
    memset(b->applied, 0, sizeof b->applied);
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
    const double *axis2;
    pinch_step_joint *step_joint = &p->joints.items[p->joints.count];
    if (!pinch_joint_reference_of(p, joint, &axis2)) return false;
    if (!pinch_joint_rows_of(joint, p->world, h, axis2, body, &step_joint->rows)) {
        if (dJointGetType(joint) != dJointTypeContact && dJointGetType(joint) != dJointTypeNull)
            p->stats.joints_unmodelled++;
        return true;
    }
    int index = p->joints.count++;
    step_joint->joint = joint;
    step_joint->met = step_joint->disabled = false;
    for (int side = 0; side < 2; side++) {
        bool kinematic = body[side] && dBodyIsKinematic(body[side]);
        /* its drive's speed is found with the contacts, not in these rows */
        if (kinematic && drive_of(p, body[side]) >= 0) p->joints.items[index].rows.exact = false;
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
    if (!pinch_joint_references_sweep(p)) return false;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        for (int side = 0; side < 2; side++) {
            pair->step_body[side] = take_part(p, pair->body[side]);
            if (pair->step_body[side] == -2) return false;
        }
        join(p, pair->step_body[0], pair->step_body[1]);
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

/* Where the contacts go, counted per island: read out pair by pair, in core island by island. */
static bool lay_out_contacts(pinch_ode *p)
{
    int total = 0, pairs = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->first_contact = total;
        if (pair->manifold.count == 0) continue;
        pair->island = island_of(p, pair->step_body[0] >= 0 ? pair->step_body[0] : pair->step_body[1]);
        pinch_island *island = &p->islands.items[pair->island];
        island->contact_count += pair->manifold.count;
        island->pair_count++;
        total += pair->manifold.count;
        pairs++;
    }
    if (!PINCH_RESERVE(p->core_contacts, total + 1) || !PINCH_RESERVE(p->contacts, total + 1) ||
        !PINCH_RESERVE(p->pair_of, pairs + 1))
        return false;
    p->core_contacts.count = p->contacts.count = total;
    int first = 0, first_pair = 0;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        island->first_contact = first;
        island->first_pair = first_pair;
        first += island->contact_count;
        first_pair += island->pair_count;
        island->contact_count = island->pair_count = 0;
    }
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        pinch_island *island = &p->islands.items[pair->island];
        pair->first_core = island->first_contact + island->contact_count;
        p->pair_of.items[island->first_pair + island->pair_count++] = i;
        island->contact_count += pair->manifold.count;
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
        for (int side = 0; side < 2; side++) /* what ODE's motors will add by themselves */
            for (int i = 0; i < 6 && joint->body[side] >= 0; i++)
                p->bodies.items[joint->body[side]].applied[i] += joint->rows.applied[side][i];
        p->joints.items[j].first_row = island->first_row + island->row_count;
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
    if (!collect(p, h) || !number_islands(p) || !remember_islands(p) || !lay_out_contacts(p) || !fill_rows(p))
        return false;
    p->core_bodies.count = p->bodies.count;
    return PINCH_RESERVE(p->core_bodies, p->bodies.count + 1);
}
