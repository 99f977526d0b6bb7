/* Does the layout of bodies, joints and islands that the last step found hold for this one? Then nothing is gathered,
 * and islands know what they were. */
#include "plugin.h"

/* Are the enabled joints of a body those that the last step found? */
static bool joints_same(const pinch_ode *p, const pinch_step_body *b)
{
    int met = 0, joints = dBodyGetNumJoints(b->body);
    for (int k = pinch_first_joint(b); k < joints; k++) {
        dJointID joint = dBodyGetJoint(b->body, k);
        if (!dJointIsEnabled(joint)) continue;
        if (met >= b->attached_count || p->attached.items[b->first_attached + met++] != joint) return false;
    }
    return met == b->attached_count;
}

/* Is the body's part in the step what it was? */
static bool part_same(const pinch_ode *p, const pinch_step_body *b)
{
    if (b->drive >= 0) return dBodyIsKinematic(b->body);
    return !dBodyIsKinematic(b->body) && dBodyIsEnabled(b->body) && !dBodyGetAutoDisableFlag(b->body) &&
           joints_same(p, b);
}

/* Does a joint tie the bodies that it tied? */
static bool ties_same(const pinch_ode *p, const pinch_step_joint *joint)
{
    dBodyID body[2];
    if (!pinch_joint_bodies(joint->joint, body)) return false;
    for (int side = 0; side < 2; side++) {
        bool part = body[side] && !dBodyIsKinematic(body[side]);
        if (part != (joint->body[side] >= 0) || (part && p->bodies.items[joint->body[side]].body != body[side]))
            return false;
    }
    return true;
}

bool pinch_layout_holds(pinch_ode *p)
{
    bool counted = false;
    if (!p->layout || p->sleepers || !p->all_modelled) return false;
    for (int i = 0; i < p->pairs.count && !p->unchanged; i++)
        if (p->pairs.items[i].laid_out != p->pairs.items[i].manifold.count) return false;
    for (int i = 0; i < p->bodies.count; i++) {
        pinch_step_body *b = &p->bodies.items[i];
        if (b->drive < 0) pinch_count_handed(p, b, &counted);
        if (!part_same(p, b)) return false;
    }
    for (int i = 0; i < p->joints.count; i++)
        if (!ties_same(p, &p->joints.items[i])) return false;
    for (int i = 0; i < p->joints.count; i++) pinch_joint_reference_keep_up(p, &p->joints.items[i]);
    return true;
}

void pinch_expect_nothing(pinch_ode *p)
{
    p->taken_before = p->directions_before = -1;
    p->places = p->layout = p->unchanged = false;
}
