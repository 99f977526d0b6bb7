#include "contacts/contact_joints.h"

#include "support/vec3.h"

#include <float.h>
#include <string.h>

/* Returns the joint that stands for a manifold point: the one it came with, or the nearest of the pair's; -1 for none.
 */
static int joint_of(const pinch_contact_store *store, const pinch_pair *pair, int point)
{
    double nearest = DBL_MAX;
    int joint = -1;
    for (int b = pair->first_buffered; b >= 0; b = store->buffer.items[b].next) {
        const pinch_buffered_contact *contact = &store->buffer.items[b];
        double d[3];
        if (contact->joint < 0) continue;
        if (contact->point == point) return contact->joint;
        pinch_v3_sub(contact->found, pair->manifold.point[point].position, d);
        if (pinch_v3_dot(d, d) < nearest) {
            nearest = pinch_v3_dot(d, d);
            joint = contact->joint;
        }
    }
    return joint;
}

/* Adds the point's force, and its moments about the bodies' centres. ODE writes first what acts on the joint's first
 * body that is not NULL. */
static void give_feedback(const pinch_contact_store *store, const pinch_pair *pair, int point)
{
    int index = joint_of(store, pair, point);
    if (index < 0) return;
    const pinch_contact_joint *joint = &store->contact_joints.items[index];
    dJointFeedback *feedback = dJointGetFeedback(joint->joint);
    if (!feedback) return;
    const pinch_ode_contact *c = &store->results.items[pair->first_result + point];
    dBodyID on[2] = {joint->body[0] ? joint->body[0] : joint->body[1], joint->body[0] ? joint->body[1] : NULL};
    double sign = on[0] == c->body1 ? 1 : -1;
    for (int side = 0; side < 2 && on[side]; side++, sign = -sign) {
        double arm[3], turned[3];
        double *force = side ? feedback->f2 : feedback->f1, *torque = side ? feedback->t2 : feedback->t1;
        pinch_v3_sub(c->position, dBodyGetPosition(on[side]), arm);
        pinch_v3_cross(arm, c->force, turned);
        for (int i = 0; i < 3; i++) {
            force[i] += sign * c->force[i];
            torque[i] += sign * (turned[i] + c->torsion * c->normal[i] + c->rolling_moment[i]);
        }
    }
}

static void enable(pinch_contact_joint *joint)
{
    if (joint->disabled) dJointEnable(joint->joint);
    joint->disabled = false;
}

void pinch_enable_contact_joints(pinch_contact_store *store)
{
    for (int i = 0; i < store->contact_joints.count; i++) enable(&store->contact_joints.items[i]);
}

void pinch_disable_contact_joints(pinch_contact_store *store)
{
    for (int i = 0; i < store->contact_joints.count; i++) {
        store->contact_joints.items[i].disabled = true;
        dJointDisable(store->contact_joints.items[i].joint);
    }
}

void pinch_answer_contact_joints(pinch_contact_store *store, const pinch_pair *pair, bool solved)
{
    for (int b = pair->first_buffered; b >= 0; b = store->buffer.items[b].next) {
        int index = store->buffer.items[b].joint;
        if (index < 0) continue;
        pinch_contact_joint *joint = &store->contact_joints.items[index];
        if (!solved)
            enable(joint);
        else if (dJointGetFeedback(joint->joint))
            memset(dJointGetFeedback(joint->joint), 0, sizeof(dJointFeedback));
    }
    for (int k = 0; k < pair->manifold.count && solved; k++) give_feedback(store, pair, k);
}
