/* A car on hinge-2 suspension drives over bumps. */
#include "sim.h"

#include <math.h>

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 5000);
    enum { WHEELS = 4, BUMPS = 6 };
    sim_ground(s);
    s->surface.mode |= dContactSlip1 | dContactSlip2 | dContactSoftERP | dContactSoftCFM;
    s->surface.mu = 1;
    s->surface.slip1 = s->surface.slip2 = 0.001;
    s->surface.soft_erp = 0.5;
    s->surface.soft_cfm = 1e-4;
    dBodyID chassis = sim_box(s, 20, 1.6, 0.8, 0.2, 0, 0, 0.5);
    dMatrix3 upright;
    dRFromAxisAndAngle(upright, 1, 0, 0, M_PI / 2);
    dJointID joint[WHEELS];
    for (int i = 0; i < WHEELS; i++) {
        double x = i < 2 ? 0.6 : -0.6, y = i % 2 ? 0.55 : -0.55;
        dBodyID wheel = sim_sphere(s, 2, 0.25, x, y, 0.3);
        dBodySetRotation(wheel, upright);
        joint[i] = dJointCreateHinge2(s->world, NULL);
        dJointAttach(joint[i], chassis, wheel);
        dJointSetHinge2Anchor(joint[i], x, y, 0.3);
        const dReal up[3] = {0, 0, 1}, across[3] = {0, 1, 0};
        dJointSetHinge2Axes(joint[i], up, across);
        dJointSetHinge2Param(joint[i], dParamLoStop, 0);
        dJointSetHinge2Param(joint[i], dParamHiStop, 0);
        dJointSetHinge2Param(joint[i], dParamSuspensionERP, 0.4);
        dJointSetHinge2Param(joint[i], dParamSuspensionCFM, 0.002);
        dJointSetHinge2Param(joint[i], dParamVel2, -8);
        dJointSetHinge2Param(joint[i], dParamFMax2, i < 2 ? 0 : 30);
    }
    for (int i = 0; i < BUMPS; i++) dGeomSetPosition(dCreateBox(s->space, 0.2, 4, 0.06), 3 + 2.5 * i, 0, 0.02);
    sim_run(s);
    sim_print(s, "car");
    sim_number("distance", dBodyGetPosition(chassis)[0]);
    sim_number("height", dBodyGetPosition(chassis)[2]);
    return sim_close(s);
}
