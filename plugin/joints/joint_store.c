/*
 * The joints of a body that are no contacts handed over. ODE has a list of all joints for each body and finds the k-th
 * by walking there: to look at each of thousands of contact joints would take the square of their number. The newest
 * come first, and contacts mostly are newer than what holds bodies together: where it is known how many there are, the
 * others are found from the list's end.
 */
#include "plugin.h"

enum { FEW = 32 };

static void count(pinch_ode *p)
{
    for (int i = 0; i < p->bodies.count; i++) p->bodies.items[i].handed = 0;
    for (int i = 0; i < p->handed.count; i++)
        for (int side = 0; side < 2; side++) {
            dBodyID body = dJointGetBody(p->handed.items[i].joint, side);
            int index = body ? pinch_step_body_of(p, body) : -1;
            if (index >= 0) p->bodies.items[index].handed++;
        }
}

void pinch_count_handed(pinch_ode *p, pinch_step_body *body, bool *counted)
{
    if (p->handed.count <= FEW || dBodyGetNumJoints(body->body) <= FEW) {
        body->handed = 0;
    } else if (!*counted) {
        count(p);
        *counted = true;
    }
}

int pinch_first_joint(const pinch_step_body *body)
{
    int first = dBodyGetNumJoints(body->body), others = first - body->handed;
    if (body->handed == 0) return 0;
    while (others > 0 && first > 0) {
        dJointID joint = dBodyGetJoint(body->body, --first);
        others -= dJointIsEnabled(joint) || dJointGetType(joint) != dJointTypeContact;
    }
    return first;
}
