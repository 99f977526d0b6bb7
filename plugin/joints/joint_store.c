#include "joints/joint_store.h"

#include "joints/joint_rows.h"

#include <stdlib.h>
#include <string.h>

void pinch_joint_store_free(pinch_joint_store *store)
{
    free(store->items);
    free(store->forces.items);
    free(store->by_island.items);
    free(store->attached.items);
    free(store->references.items);
    pinch_item_index_free(&store->index);
    pinch_item_index_free(&store->forces.index);
    pinch_item_index_free(&store->references.index);
    pinch_joint_poses_free(&store->own_poses);
    pinch_servos_free(&store->servos);
    pinch_couplings_free(&store->couplings);
}

size_t pinch_joint_store_bytes(const pinch_joint_store *s)
{
    return PINCH_LIST_BYTES(*s) + PINCH_LIST_BYTES(s->by_island) + PINCH_LIST_BYTES(s->attached) +
           PINCH_LIST_BYTES(s->references) + pinch_item_index_bytes(&s->index) +
           pinch_item_index_bytes(&s->references.index) + PINCH_LIST_BYTES(s->servos) + PINCH_LIST_BYTES(s->couplings) +
           PINCH_LIST_BYTES(s->couplings.by_island) + PINCH_LIST_BYTES(s->forces) +
           pinch_item_index_bytes(&s->forces.index);
}

static pinch_item_keys keys_of(const pinch_joint_store *store)
{
    return PINCH_ITEM_KEYS(*store, pinch_step_joint, joint);
}

int pinch_step_joint_of(const pinch_joint_store *store, dJointID joint, int *hint)
{
    return pinch_item_index_find(&store->index, keys_of(store), &joint, hint);
}

/*
 * ---- the joints of a body that are no contact joints of Pinch's ----
 *
 * ODE has a list of all joints of a body and finds the k-th by walking there: looking at each of thousands of contact
 * joints would take the square of their number. The newest joints come first, and contacts mostly are newer than what
 * holds bodies together. So where it is known how many contact joints there are, the others are found from the list's
 * end.
 */

enum { FEW = 32 };

static void count_for_all_bodies(pinch_step_bodies *bodies, const pinch_contact_store *contacts)
{
    for (int i = 0; i < bodies->count; i++) bodies->items[i].contact_joints = 0;
    for (int i = 0; i < contacts->contact_joints.count; i++)
        for (int side = 0; side < 2; side++) {
            dBodyID body = dJointGetBody(contacts->contact_joints.items[i].joint, side);
            int index = body ? pinch_step_body_of(bodies, body) : -1;
            if (index >= 0) bodies->items[index].contact_joints++;
        }
}

/* Tells a body how many of its joints are contact joints of Pinch's, where it has many. *counted is false at first, and
 * the same variable for all bodies. */
static void count_contact_joints(pinch_step_bodies *bodies, const pinch_contact_store *contacts, int index,
                                 bool *counted)
{
    pinch_step_body *body = &bodies->items[index];
    if (contacts->contact_joints.count <= FEW || dBodyGetNumJoints(body->body) <= FEW) {
        body->contact_joints = 0;
    } else if (!*counted) {
        count_for_all_bodies(bodies, contacts);
        *counted = true;
    }
}

int pinch_first_joint(const pinch_step_body *body)
{
    if (body->contact_joints == 0) return 0;
    int first = dBodyGetNumJoints(body->body), others = first - body->contact_joints;
    while (others > 0 && first > 0) {
        dJointID joint = dBodyGetJoint(body->body, --first);
        others -= dJointIsEnabled(joint) || dJointGetType(joint) != dJointTypeContact;
    }
    return first;
}

/* ---- collecting joints ---- */

/* Tells whether the joint has been found on a dynamic step body before the one with this index. */
static bool already_found(const pinch_step_bodies *bodies, dJointID joint, int index)
{
    for (int side = 0; side < 2; side++) {
        dBodyID body = dJointGetBody(joint, side);
        int end = body ? pinch_step_body_of(bodies, body) : -1;
        if (end >= 0 && end < index && bodies->items[end].drive < 0) return true;
    }
    return false;
}

static pinch_item_keys keys_of_forces(const pinch_joint_store *store)
{
    return PINCH_ITEM_KEYS(store->forces, pinch_row_forces, joint);
}

/* Puts the forces of all joints of the last step aside, by joint: they may come back in another order. Returns false
 * when memory runs out. */
static bool put_forces_aside(pinch_joint_store *store)
{
    store->forces.count = 0;
    pinch_item_index_clear(&store->forces.index);
    if (!PINCH_RESERVE(store->forces, store->count)) return false;
    for (int k = 0; k < store->count; k++) {
        const pinch_row_forces *of = &store->items[k].forces;
        if (of->count == 0) continue;
        int place = store->forces.count++;
        store->forces.items[place] = *of;
        if (!pinch_item_index_add(&store->forces.index, keys_of_forces(store), &of->joint, place)) return false;
    }
    return true;
}

/* Adds a joint and the bodies at its ends. Returns false when memory runs out. */
static bool add_joint(pinch_joint_store *store, pinch_step_bodies *bodies, dJointID joint, const dBodyID body[2],
                      long step)
{
    pinch_item_keys keys = keys_of(store);
    if (pinch_item_index_get(&store->index, keys, &joint) >= 0) return true;
    if (!PINCH_RESERVE(*store, store->count + 1)) return false;
    keys = keys_of(store); /* the list may have moved */
    if (!pinch_item_index_add(&store->index, keys, &joint, store->count)) return false;
    pinch_step_joint *step_joint = &store->items[store->count++];
    memset(step_joint, 0, sizeof *step_joint);
    step_joint->joint = joint;
    int known = pinch_item_index_get(&store->forces.index, keys_of_forces(store), &joint);
    if (known >= 0) step_joint->forces = store->forces.items[known];
    if (!pinch_add_hinge_reference(&store->references, joint, body[0], step, &step_joint->reference)) return false;
    for (int side = 0; side < 2; side++) {
        bool dynamic = body[side] && !dBodyIsKinematic(body[side]);
        step_joint->body[side] = dynamic ? pinch_step_bodies_add(bodies, body[side]) : PINCH_NOT_A_STEP_BODY;
        if (step_joint->body[side] == PINCH_NO_ROOM_FOR_BODY) return false;
    }
    pinch_step_bodies_join(bodies, step_joint->body[0], step_joint->body[1]);
    return true;
}

/* Collects the joints of a step body. Returns false when memory runs out. */
static bool collect_joints_of(pinch_joint_store *store, pinch_step_bodies *bodies, int index, long step,
                              long *unmodelled)
{
    dBodyID body = bodies->items[index].body, ends[2];
    int first = pinch_first_joint(&bodies->items[index]), end = dBodyGetNumJoints(body), found = store->attached.count;
    bodies->items[index].first_joint = found;
    if (!PINCH_RESERVE(store->attached, found + end - first)) return false;
    for (int k = first; k < end; k++) {
        dJointID joint = dBodyGetJoint(body, k);
        if (!dJointIsEnabled(joint)) continue;
        store->attached.items[store->attached.count++] = (pinch_attached_joint){.joint = joint};
        if (pinch_modelled_joint_bodies(joint, ends)) {
            if (!add_joint(store, bodies, joint, ends, step)) return false;
            continue;
        }
        store->all_modelled = false;
        bool counts = dJointGetType(joint) != dJointTypeContact && dJointGetType(joint) != dJointTypeNull;
        if (counts && !already_found(bodies, joint, index)) (*unmodelled)++;
    }
    bodies->items[index].joint_count = store->attached.count - found;
    return true;
}

bool pinch_collect_joints(pinch_joint_store *store, pinch_step_bodies *bodies, const pinch_contact_store *contacts,
                          long step, long *unmodelled)
{
    bool counted = false;
    if (!put_forces_aside(store)) return false;
    store->count = store->attached.count = 0;
    store->all_modelled = true;
    store->no_kinematic_hinges = false;
    pinch_item_index_clear(&store->index);
    if (!pinch_sweep_hinge_references(&store->references, step)) return false;
    if (!pinch_collect_couplings(&store->couplings, bodies)) return false;
    for (int i = 0; i < bodies->count; i++) { /* grows, as joints bring in the bodies at their other ends */
        if (bodies->items[i].drive >= 0) continue;
        count_contact_joints(bodies, contacts, i, &counted);
        if (!collect_joints_of(store, bodies, i, step, unmodelled)) return false;
    }
    return true;
}

/* ---- comparing with the last step ---- */

/* Whether step bodies have become kinematic is asked of each body by itself. */
static bool same_bodies_of(const pinch_step_bodies *bodies, const pinch_step_joint *joint)
{
    dBodyID body[2];
    if (!pinch_modelled_joint_bodies(joint->joint, body)) return false;
    for (int side = 0; side < 2; side++) {
        int index = joint->body[side];
        if (index >= 0 ? bodies->items[index].body != body[side] : body[side] && !dBodyIsKinematic(body[side]))
            return false;
    }
    return true;
}

/*
 * Compares the joints on a step body, and what those tie that it was the first to have: *next counts them. In this
 * order nothing is asked of a body that was destroyed, because every body is reached through joints of one before it,
 * or was handed over for this step.
 */
static bool same_joints_on(const pinch_joint_store *store, const pinch_step_bodies *bodies, int index, int *next)
{
    const pinch_step_body *b = &bodies->items[index];
    int found = 0, joints = dBodyGetNumJoints(b->body);
    for (int k = pinch_first_joint(b); k < joints; k++) {
        dJointID joint = dBodyGetJoint(b->body, k);
        if (!dJointIsEnabled(joint)) continue;
        if (found >= b->joint_count || store->attached.items[b->first_joint + found++].joint != joint) return false;
        if (*next < store->count && store->items[*next].joint == joint &&
            !same_bodies_of(bodies, &store->items[(*next)++]))
            return false;
    }
    return found == b->joint_count;
}

/* Tells whether a coupling acts where it did. Step joints, which are those of the last step by now, let it. */
static bool same_coupling(const pinch_joint_store *store, pinch_coupling *c)
{
    bool tied = c->acts;
    for (int i = 0; i < c->count && tied; i++)
        tied = pinch_step_joint_of(store, c->coupled[i].term.joint, &c->coupled[i].joint) >= 0;
    return tied ? pinch_coupling_has_law(c) : c->acts == pinch_coupling_can_act(c);
}

/* Asks ahead for the beginnings of a body and of the joints on it, which tell what is compared here. */
static void prefetch_beginnings(const pinch_joint_store *store, const pinch_step_body *b)
{
    pinch_prefetch(b->body, PINCH_CACHE_LINE);
    for (int k = 0; k < b->joint_count; k++)
        pinch_prefetch(store->attached.items[b->first_joint + k].joint, PINCH_JOINT_TIES);
}

/* Asks ahead for what is compared of a body some places later, and for what tells where ODE has it of one still later.
 * next: the joint at hand. */
static void prefetch_later(const pinch_joint_store *store, const pinch_step_bodies *bodies, int index, int next)
{
    enum { AHEAD = 12 };
    const pinch_step_body *b = &bodies->items[index];
    if (index + 2 * AHEAD < bodies->count) pinch_prefetch(b + 2 * AHEAD, PINCH_STEP_BODY_LINKS);
    if (next + AHEAD < store->count) pinch_prefetch(&store->items[next + AHEAD], PINCH_STEP_JOINT_AT_REST);
    if (index + AHEAD < bodies->count) prefetch_beginnings(store, b + AHEAD);
}

bool pinch_same_joints_and_bodies(const pinch_joint_store *store, pinch_step_bodies *bodies,
                                  const pinch_contact_store *contacts)
{
    enum { MANY = 1000 };
    bool counted = false, many = bodies->count >= MANY;
    int next = 0;
    if (!store->all_modelled || store->couplings.changed) return false;
    for (int i = 0; i < bodies->count; i++) {
        if (many) prefetch_later(store, bodies, i, next);
        if (!pinch_takes_same_part(&bodies->items[i])) return false;
        if (bodies->items[i].drive >= 0) continue;
        count_contact_joints(bodies, contacts, i, &counted);
        if (!same_joints_on(store, bodies, i, &next)) return false;
    }
    for (int k = 0; k < store->couplings.count && next == store->count; k++)
        if (!same_coupling(store, &store->couplings.items[k])) return false;
    return next == store->count;
}

void pinch_update_kinematic_hinges(pinch_joint_store *store, long step)
{
    if (store->no_kinematic_hinges) return;
    store->no_kinematic_hinges = true;
    for (int i = 0; i < store->count; i++) { /* the first body of a hinge is kinematic where it is no step body */
        if (store->items[i].reference < 0 || store->items[i].body[0] >= 0) continue;
        pinch_update_hinge(&store->references, store->items[i].reference, step);
        store->no_kinematic_hinges = false;
    }
}

/* ---- what is gone ---- */

void pinch_joint_store_forget_joint(pinch_joint_store *store, dJointID joint)
{
    int hint = 0, index = pinch_step_joint_of(store, joint, &hint);
    if (index >= 0) store->items[index].forces.count = 0;
    for (int axis = 0; axis < PINCH_JOINT_AXES; axis++) (void)pinch_servo_set(&store->servos, joint, axis, NULL);
    pinch_hinge_references_forget_joint(&store->references, joint);
    pinch_joint_poses_forget_joint(store->poses, joint);
}
