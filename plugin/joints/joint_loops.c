/* Which bodies joints tie together, and the loops that they close. */
#include "joints/island_joints.h"

/* Each body's `carrier` is its parent in a forest here. The world is a root, with the number after the last body. On
 * the way to a root each body is hung on its parent's parent, so that chains of bodies become short ways. */
static int root_of(const pinch_step_bodies *bodies, pinch_range range, int local)
{
    while (local < range.count) {
        pinch_step_body *body = pinch_island_body(bodies, range, local);
        int parent = body->carrier;
        if (parent == local) break;
        if (parent < range.count) body->carrier = pinch_island_body(bodies, range, parent)->carrier;
        local = parent;
    }
    return local;
}

static bool is_motor_alone(const pinch_step_joint *joint)
{
    dJointType type = dJointGetType(joint->joint);
    return type == dJointTypeAMotor || type == dJointTypeLMotor;
}

/* Finds the roots of a joint's bodies. */
static void find_roots(const pinch_step_bodies *bodies, pinch_range range, const pinch_step_joint *joint, int root[2])
{
    for (int side = 0; side < 2; side++) {
        int body = joint->body[side];
        root[side] = body >= 0 ? root_of(bodies, range, bodies->items[body].local) : range.count;
    }
}

static void unite(const pinch_step_bodies *bodies, pinch_range range, const int root[2])
{
    int lower = root[0] < root[1] ? root[0] : root[1];
    if (root[0] != root[1]) pinch_island_body(bodies, range, lower)->carrier = root[0] + root[1] - lower;
}

static void take_apart(const pinch_step_bodies *bodies, pinch_range range)
{
    for (int k = 0; k < range.count; k++) pinch_island_body(bodies, range, k)->carrier = k;
}

static bool close_loops(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                        const pinch_island_joints *joints)
{
    take_apart(bodies, range);
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        int root[2];
        if (is_motor_alone(joint)) continue;
        find_roots(bodies, range, joint, root);
        if (root[0] == root[1]) return true;
        unite(bodies, range, root);
    }
    return false;
}

bool pinch_joints_close_loops(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                              pinch_island_joints *joints)
{
    if (!joints->loops_known) joints->loops = close_loops(store, bodies, range, joints);
    joints->loops_known = true;
    return joints->loops;
}

void pinch_find_mechanisms(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                           const pinch_island_joints *joints)
{
    take_apart(bodies, range);
    for (int k = 0; k < joints->range.count; k++) {
        int root[2];
        find_roots(bodies, range, pinch_island_joint(store, joints, k), root);
        if (root[0] < range.count && root[1] < range.count) unite(bodies, range, root);
    }
}

int pinch_mechanism_of(const pinch_step_bodies *bodies, pinch_range range, int local)
{
    return root_of(bodies, range, local);
}
