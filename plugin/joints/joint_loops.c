/* Loops that joints close. */
#include "joints/island_joints.h"

/* Each body's `carrier` is its parent in a forest here. The world is a root, with the number after the last body. */
static int root_of(const pinch_step_bodies *bodies, pinch_range range, int local)
{
    while (local < range.count) {
        int parent = pinch_island_body(bodies, range, local)->carrier;
        if (parent == local) break;
        local = parent;
    }
    return local;
}

static bool close_loops(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                        const pinch_island_joints *joints)
{
    for (int k = 0; k < range.count; k++) pinch_island_body(bodies, range, k)->carrier = k;
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        dJointType type = dJointGetType(joint->joint);
        if (type == dJointTypeAMotor || type == dJointTypeLMotor) continue;
        int root[2] = {range.count, range.count};
        for (int side = 0; side < 2; side++)
            if (joint->body[side] >= 0) root[side] = root_of(bodies, range, bodies->items[joint->body[side]].local);
        if (root[0] == root[1]) return true;
        int lower = root[0] < root[1] ? root[0] : root[1];
        pinch_island_body(bodies, range, lower)->carrier = root[0] + root[1] - lower;
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
