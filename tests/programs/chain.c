/* A chain of --links capsules on ball joints hangs by one end from --height m; the other end lies on the ground. */
#include "sim.h"

#include <math.h>

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 5000);
    enum { MOST_LINKS = SIM_MOST_BODIES };
    static dJointID joints[MOST_LINKS];
    int links = (int)sim_value(s, "links", 12);
    double height = sim_value(s, "height", 1);
    if (links < 1 || links > MOST_LINKS) return 2;
    sim_ground(s);
    dMatrix3 flat;
    dRFromAxisAndAngle(flat, 0, 1, 0, M_PI / 2);
    dBodyID last = NULL;
    for (int i = 0; i < links; i++) {
        dBodyID link = sim_capsule(s, 0.2, 0.03, 0.2, 0.13 + 0.26 * i, 0, height);
        dBodySetRotation(link, flat);
        joints[i] = dJointCreateBall(s->world, NULL);
        dJointAttach(joints[i], link, last);
        dJointSetBallAnchor(joints[i], 0.26 * i, 0, height);
        last = link;
    }
    dWorldSetLinearDamping(s->world, 0.01);
    dWorldSetAngularDamping(s->world, 0.02);
    sim_run(s);
    double gap = 0;
    for (int i = 0; i < links; i++) {
        dVector3 a, b;
        dJointGetBallAnchor(joints[i], a);
        dJointGetBallAnchor2(joints[i], b);
        gap = fmax(gap, sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2)));
    }
    sim_print(s, "chain");
    sim_number("gap", gap);
    sim_number("end", dBodyGetPosition(last)[2]);
    return sim_close(s);
}
