/*
 * Keeping a joint out of ODE's step, for a joint whose forces Pinch has found.
 *
 * As a rule the joint is disabled. But ODE follows a transmission's wheels and an angular motor's Euler angles only
 * while it steps the joint, and programs read them: such a joint stays enabled, and has no row that does anything. A
 * transmission has one for its backlash alone, and a motor needs a force or a stop for one.
 */
#ifndef PINCH_JOINTS_JOINT_ASIDE_H
#define PINCH_JOINTS_JOINT_ASIDE_H

#include <ode/ode.h>
#include <stdbool.h>

typedef struct pinch_joint_aside {
    bool enabled; /* the joint has stayed so, and what follows is to be put back */
    dJointFeedback *feedback;
    double values[3][3];
} pinch_joint_aside;

void pinch_set_joint_aside(dJointID joint, pinch_joint_aside *aside);
void pinch_put_joint_back(dJointID joint, pinch_joint_aside *aside);

#endif
