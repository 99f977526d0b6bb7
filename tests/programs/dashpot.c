/*
 * A rod of 1 kg hangs on the axle of a rotor of 1 g, which a motor holds at rest with a compliance of 0.5 rad/s per N
 * m. Prints the angle that the rod has fallen by.
 */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 400);
    dBodyID rotor = sim_sphere(s, 0.001, 0.01, 0, 0, 0), rod = sim_box(s, 1, 1, 0.02, 0.02, 0.52, 0, 0);
    dJointID axle = dJointCreateHinge(s->world, NULL), fixed = dJointCreateFixed(s->world, NULL);
    dJointAttach(axle, rotor, NULL);
    dJointSetHingeAnchor(axle, 0, 0, 0);
    dJointSetHingeAxis(axle, 0, 1, 0);
    dJointSetHingeParam(axle, dParamVel, 0);
    dJointSetHingeParam(axle, dParamFMax, dInfinity);
    dJointSetHingeParam(axle, dParamCFM, 0.5);
    dJointAttach(fixed, rotor, rod);
    dJointSetFixed(fixed);
    sim_run(s);
    sim_print(s, "dashpot");
    sim_number("angle", dJointGetHingeAngle(axle));
    return sim_close(s);
}
