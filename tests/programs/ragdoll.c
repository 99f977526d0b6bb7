/* A body of capsules on ball, hinge and universal joints with stops falls over. */
#include "sim.h"

#include <math.h>

static void hinge(sim *s, dBodyID a, dBodyID b, double x, double z)
{
    dJointID joint = dJointCreateHinge(s->world, NULL);
    dJointAttach(joint, a, b);
    dJointSetHingeAnchor(joint, x, 0, z);
    dJointSetHingeAxis(joint, 0, 1, 0);
    dJointSetHingeParam(joint, dParamLoStop, -1.5);
    dJointSetHingeParam(joint, dParamHiStop, 0.1);
}

static void universal(sim *s, dBodyID a, dBodyID b, double x, double z)
{
    dJointID joint = dJointCreateUniversal(s->world, NULL);
    dJointAttach(joint, a, b);
    dJointSetUniversalAnchor(joint, x, 0, z);
    dJointSetUniversalAxis1(joint, 1, 0, 0);
    dJointSetUniversalAxis2(joint, 0, 1, 0);
    for (int group = 0; group < 2; group++) {
        dJointSetUniversalParam(joint, dParamLoStop + group * dParamGroup2, -0.8);
        dJointSetUniversalParam(joint, dParamHiStop + group * dParamGroup2, 0.8);
    }
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 5000);
    sim_ground(s);
    dBodyID torso = sim_capsule(s, 30, 0.15, 0.35, 0, 0, 1.2), head = sim_sphere(s, 5, 0.12, 0, 0, 1.68);
    dJointID neck = dJointCreateBall(s->world, NULL);
    dJointAttach(neck, torso, head);
    dJointSetBallAnchor(neck, 0, 0, 1.55);
    for (int side = -1; side <= 1; side += 2) {
        dBodyID upper = sim_capsule(s, 3, 0.05, 0.2, side * 0.23, 0, 1.25);
        dBodyID fore = sim_capsule(s, 2, 0.04, 0.2, side * 0.23, 0, 0.93);
        universal(s, torso, upper, side * 0.23, 1.4);
        hinge(s, upper, fore, side * 0.23, 1.08);
        dBodyID thigh = sim_capsule(s, 7, 0.07, 0.25, side * 0.1, 0, 0.67);
        dBodyID shin = sim_capsule(s, 4, 0.05, 0.25, side * 0.1, 0, 0.26);
        universal(s, torso, thigh, side * 0.1, 0.87);
        hinge(s, thigh, shin, side * 0.1, 0.46);
    }
    dBodySetLinearVel(torso, 0, 1, 0);
    dBodySetAngularVel(torso, 0.5, 0.3 * dRandReal(), 0);
    dWorldSetAngularDamping(s->world, 0.02);
    sim_run(s);
    sim_print(s, "ragdoll");
    sim_number("head", dBodyGetPosition(head)[2]);
    return sim_close(s);
}
