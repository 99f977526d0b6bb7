/*
 * Contact joints that the program made itself. ODE's own solver must not see those that Pinch has solved, the program
 * must find them as it left them, with the forces where it asked for them (dJointSetFeedback).
 */
#include "plugin.h"

#include "support/vec3.h"

#include <float.h>
#include <string.h>

/* The joint that stands for a manifold point: the one it came with, or of the pair's the nearest. -1: none. */
static int joint_of(const pinch_ode *p, const pinch_pair *pair, int point)
{
    double nearest = DBL_MAX;
    int joint = -1;
    for (int t = pair->first_taken; t >= 0; t = p->taken.items[t].next) {
        const pinch_taken_contact *taken = &p->taken.items[t];
        double d[3];
        if (taken->joint < 0) continue;
        if (taken->point == point) return taken->joint;
        pinch_v3_sub(taken->found, pair->manifold.point[point].position, d);
        if (pinch_v3_dot(d, d) < nearest) {
            nearest = pinch_v3_dot(d, d);
            joint = taken->joint;
        }
    }
    return joint;
}

/* Force and moment about the body's centre. */
static void add_feedback(dBodyID body, const pinch_ode_contact *c, double sign, double *force, double *torque)
{
    double arm[3], turned[3];
    if (!body) return;
    pinch_v3_sub(c->position, dBodyGetPosition(body), arm);
    pinch_v3_cross(arm, c->force, turned);
    for (int i = 0; i < 3; i++) {
        force[i] += sign * c->force[i];
        torque[i] += sign * (turned[i] + c->torsion * c->normal[i] + c->rolling_moment[i]);
    }
}

/* ODE writes first what acts on the joint's first body that is one. */
static void give_feedback(const pinch_ode *p, const pinch_pair *pair, int point)
{
    int index = joint_of(p, pair, point);
    if (index < 0) return;
    const pinch_handed_joint *handed = &p->handed.items[index];
    dJointFeedback *feedback = dJointGetFeedback(handed->joint);
    if (!feedback) return;
    const pinch_ode_contact *c = &p->contacts.items[pair->first_contact + point];
    dBodyID first = handed->body[0] ? handed->body[0] : handed->body[1];
    double sign = first == c->body1 ? 1 : -1;
    add_feedback(first, c, sign, feedback->f1, feedback->t1);
    add_feedback(handed->body[0] ? handed->body[1] : NULL, c, -sign, feedback->f2, feedback->t2);
}

static void switch_on(pinch_handed_joint *handed)
{
    if (handed->disabled) dJointEnable(handed->joint);
    handed->disabled = false;
}

void pinch_handed_disable(pinch_ode *p)
{
    for (int i = 0; i < p->handed.count; i++) {
        p->handed.items[i].disabled = true;
        dJointDisable(p->handed.items[i].joint);
    }
}

/* The joints of one pair, whose island has been solved or is left to ODE. */
static void settle(pinch_ode *p, const pinch_pair *pair, bool solved)
{
    for (int t = pair->first_taken; t >= 0; t = p->taken.items[t].next) {
        int index = p->taken.items[t].joint;
        if (index < 0) continue;
        pinch_handed_joint *handed = &p->handed.items[index];
        if (!solved)
            switch_on(handed);
        else if (dJointGetFeedback(handed->joint))
            memset(dJointGetFeedback(handed->joint), 0, sizeof(dJointFeedback));
    }
    for (int k = 0; k < pair->manifold.count && solved; k++) give_feedback(p, pair, k);
}

void pinch_handed_settle(pinch_ode *p)
{
    for (int i = 0; i < p->pairs.count && p->handed.count > 0; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        bool solved = pair->manifold.count > 0 && p->islands.items[pair->island].solved;
        settle(p, pair, solved);
    }
}

void pinch_handed_enable(pinch_ode *p)
{
    for (int i = 0; i < p->handed.count; i++) switch_on(&p->handed.items[i]);
    p->handed.count = 0;
}
