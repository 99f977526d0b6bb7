/* From pairs and ODE bodies to islands: who takes part, what belongs together, and where their data go. */
#include "plugin.h"

#include <string.h>

/* The step body of an ODE body, -1 for what does not move by itself. -2: no memory. */
static int take_part(pinch_ode *p, dBodyID body)
{
    if (!body) return -1;
    int drive = dBodyIsKinematic(body) ? pinch_drive_of(p, body) : -1;
    if (dBodyIsKinematic(body) && drive < 0) return -1;
    int index = pinch_step_body_of(p, body);
    if (index >= 0) return index;
    index = p->bodies.count;
    if (!PINCH_RESERVE(p->bodies, index + 1) ||
        !pinch_item_index_add(&p->body_index, pinch_body_keys(p), pinch_key_of_pointer(body), index))
        return -2;
    pinch_step_body *b = &p->bodies.items[p->bodies.count++];
    memset(b, 0, sizeof *b);
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

/* Does the joint have a body whose joints were taken before those of the step body `index`? */
static bool met_before(const pinch_ode *p, dJointID joint, int index)
{
    for (int side = 0; side < 2; side++) {
        dBodyID body = dJointGetBody(joint, side);
        int end = body ? pinch_step_body_of(p, body) : -1;
        if (end >= 0 && end < index && p->bodies.items[end].drive < 0) return true;
    }
    return false;
}

/* A joint of the step body `index`. */
static bool take_joint(pinch_ode *p, dJointID joint, int index)
{
    uint64_t key = pinch_key_of_pointer(joint);
    dBodyID body[2];
    if (!pinch_joint_bodies(joint, body)) {
        p->all_modelled = false;
        bool counts = dJointGetType(joint) != dJointTypeContact && dJointGetType(joint) != dJointTypeNull;
        if (counts && !met_before(p, joint, index)) p->stats.joints_unmodelled++;
        return true;
    }
    if (pinch_item_index_get(&p->joint_index, pinch_joint_keys(p), key) >= 0) return true;
    if (!PINCH_RESERVE(p->joints, p->joints.count + 1) ||
        !pinch_item_index_add(&p->joint_index, pinch_joint_keys(p), key, p->joints.count))
        return false;
    pinch_step_joint *step_joint = &p->joints.items[p->joints.count++];
    memset(step_joint, 0, sizeof *step_joint);
    step_joint->joint = joint;
    if (!pinch_joint_reference_of(p, joint, body[0], &step_joint->reference)) return false;
    for (int side = 0; side < 2; side++) {
        step_joint->body[side] = body[side] && dBodyIsKinematic(body[side]) ? -1 : take_part(p, body[side]);
        if (step_joint->body[side] == -2) return false;
    }
    join(p, step_joint->body[0], step_joint->body[1]);
    return true;
}

static bool take_joints(pinch_ode *p, int index)
{
    pinch_step_body *b = &p->bodies.items[index];
    dBodyID body = b->body;
    int joints = dBodyGetNumJoints(body), met = pinch_first_joint(b), first = p->attached.count;
    if (!PINCH_RESERVE(p->attached, first + joints - met)) return false;
    for (int k = met; k < joints; k++) {
        dJointID joint = dBodyGetJoint(body, k);
        if (!dJointIsEnabled(joint)) continue;
        p->attached.items[p->attached.count++] = joint;
        if (!take_joint(p, joint, index)) return false;
    }
    b = &p->bodies.items[index];
    b->first_attached = first;
    b->attached_count = p->attached.count - first;
    return true;
}

static bool collect(pinch_ode *p)
{
    p->bodies.count = 0;
    p->joints.count = 0;
    p->attached.count = 0;
    p->all_modelled = true;
    pinch_item_index_clear(&p->body_index);
    pinch_item_index_clear(&p->joint_index);
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
    bool counted = false;
    for (int i = 0; i < p->bodies.count; i++) { /* grows: joints bring in the bodies at their other ends */
        if (p->bodies.items[i].drive >= 0) continue;
        pinch_count_handed(p, &p->bodies.items[i], &counted);
        if (!take_joints(p, i)) return false;
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
    int n = p->bodies.count, islands = 0;
    if (!PINCH_RESERVE(p->order, n + 1) || !PINCH_RESERVE(p->body_of, n + 1)) return false;
    for (int i = 0; i < n; i++) {
        p->order.items[i] = root_of(p, i);
        islands += p->order.items[i] == i;
    }
    if (!PINCH_RESERVE(p->islands, islands + 1)) return false;
    memset(p->islands.items, 0, (size_t)islands * sizeof *p->islands.items);
    p->islands.count = 0;
    for (int i = 0; i < n; i++) {
        int root = p->order.items[i]; /* never larger than its members */
        pinch_step_body *b = &p->bodies.items[i];
        b->parent = root == i ? p->islands.count++ : p->bodies.items[root].parent;
        b->local = p->islands.items[b->parent].body_count++;
    }
    return true;
}

/* As in ODE, what moves by itself wakes what it touches. */
static void wake_touched(pinch_ode *p, const pinch_pair *pair)
{
    for (int side = 0; side < 2 && pair->manifold.count > 0; side++) {
        dBodyID body = pair->body[side], other = pair->body[!side];
        if (!body || !other || !dBodyIsKinematic(body) || !dBodyIsEnabled(body)) continue;
        int touched = pinch_step_body_of(p, other);
        if (touched >= 0) p->islands.items[p->bodies.items[touched].parent].awake = true;
    }
}

static void find_sleepers(pinch_ode *p)
{
    p->sleepers = false;
    for (int i = 0; i < p->bodies.count; i++) {
        const pinch_step_body *b = &p->bodies.items[i];
        pinch_island *island = &p->islands.items[b->parent];
        bool enabled = b->drive >= 0 || dBodyIsEnabled(b->body);
        bool may_sleep = b->drive < 0 && (!enabled || dBodyGetAutoDisableFlag(b->body));
        island->awake = island->awake || enabled;
        island->may_sleep = island->may_sleep || may_sleep;
        p->sleepers = p->sleepers || may_sleep;
    }
    for (int i = 0; i < p->pairs.count; i++) wake_touched(p, &p->pairs.items[i]);
}

static void lay_out_bodies(pinch_ode *p)
{
    int first = 0;
    for (int k = 0; k < p->islands.count; k++) {
        p->islands.items[k].first_body = first;
        first += p->islands.items[k].body_count;
    }
    for (int i = 0; i < p->bodies.count; i++)
        p->body_of.items[p->islands.items[island_of(p, i)].first_body + p->bodies.items[i].local] = i;
}

/* Where the contacts go, counted per island: read out pair by pair, solved island by island. */
static bool lay_out_contacts(pinch_ode *p)
{
    int total = 0, pairs = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->first_contact = total;
        pair->laid_out = pair->manifold.count;
        if (pair->manifold.count == 0) continue;
        pair->island = island_of(p, pair->step_body[0] >= 0 ? pair->step_body[0] : pair->step_body[1]);
        pinch_island *island = &p->islands.items[pair->island];
        island->contact_count += pair->manifold.count;
        island->pair_count++;
        total += pair->manifold.count;
        pairs++;
    }
    if (!PINCH_RESERVE(p->contacts, total + 1) || !PINCH_RESERVE(p->pair_of, pairs + 1)) return false;
    p->contacts.count = total;
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
        pair->first_core = island->contact_count;
        p->pair_of.items[island->first_pair + island->pair_count++] = i;
        island->contact_count += pair->manifold.count;
    }
    return true;
}

/* The island of a joint, NULL: it ties nothing that moves by itself. */
static pinch_island *island_of_joint(pinch_ode *p, const pinch_step_joint *joint)
{
    int body = joint->body[0] >= 0 ? joint->body[0] : joint->body[1];
    return body < 0 ? NULL : &p->islands.items[island_of(p, body)];
}

static bool lay_out_joints(pinch_ode *p)
{
    if (!PINCH_RESERVE(p->joint_of, p->joints.count + 1)) return false;
    for (int j = 0; j < p->joints.count; j++) {
        pinch_island *island = island_of_joint(p, &p->joints.items[j]);
        if (island) island->joint_count++;
    }
    int first = 0;
    for (int k = 0; k < p->islands.count; k++) {
        pinch_island *island = &p->islands.items[k];
        island->first_joint = first;
        first += island->joint_count;
        island->joint_count = 0;
    }
    for (int j = 0; j < p->joints.count; j++) {
        pinch_island *island = island_of_joint(p, &p->joints.items[j]);
        if (island) p->joint_of.items[island->first_joint + island->joint_count++] = j;
    }
    return true;
}

/* Room for all islands' problems at once, where they are to stay. */
static bool lay_out_kept(pinch_ode *p)
{
    pinch_desk *kept = &p->kept;
    if (!p->settings.keep_islands) return true;
    kept->bodies.count = p->bodies.count;
    kept->contacts.count = p->contacts.count;
    kept->rows.count = PINCH_JOINT_MAX_ROWS * p->joints.count;
    return PINCH_RESERVE(kept->bodies, kept->bodies.count + 1) &&
           PINCH_RESERVE(kept->contacts, kept->contacts.count + 1) && PINCH_RESERVE(kept->rows, kept->rows.count + 1);
}

/* A few memories more than there are islands, as many as the list has room for: in heaps the number of islands wanders.
 */
static bool remember_islands(pinch_ode *p)
{
    if (!PINCH_RESERVE(p->memories, p->islands.count)) return false;
    while (p->memories.count < p->memories.room && p->memories.items) {
        if (pinch_step_memory_create(&p->memories.items[p->memories.count]) != PINCH_OK) break;
        p->memories.count++;
    }
    return p->memories.count >= p->islands.count;
}

bool pinch_gather(pinch_ode *p)
{
    if (!collect(p) || !number_islands(p) || !remember_islands(p)) return false;
    find_sleepers(p);
    lay_out_bodies(p);
    return lay_out_contacts(p) && lay_out_joints(p) && lay_out_kept(p);
}
