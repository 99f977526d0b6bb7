/*
 * A body of --body kg stands on four wheels of --wheel kg, balls on ball joints, with contacts that are soft by their
 * own --cfm. Prints the depth at which these bear the weight by ODE's law, m.
 */
#include "sim.h"

int main(int argc, char **argv)
{
    static const double RADIUS = 0.02, APART = 0.1;
    sim *s = sim_open(argc, argv, 0.05, 1000);
    double body = sim_value(s, "body", 1), wheel = sim_value(s, "wheel", 0.02);
    sim_ground(s);
    s->surface.mode |= dContactSoftCFM;
    s->surface.soft_cfm = sim_value(s, "cfm", 0.01);
    dBodyID frame = sim_box(s, body, 0.3, 0.3, 0.04, 0, 0, 4 * RADIUS);
    for (int k = 0; k < 4; k++) {
        double x = k & 1 ? APART : -APART, y = k & 2 ? APART : -APART;
        dBodyID ball = sim_sphere(s, wheel, RADIUS, x, y, RADIUS);
        dJointID joint = dJointCreateBall(s->world, 0);
        dJointAttach(joint, frame, ball);
        dJointSetBallAnchor(joint, x, y, RADIUS);
    }
    sim_run(s);
    sim_print(s, "casters");
    sim_number("law", (body / 4 + wheel) * 9.81 * s->surface.soft_cfm * s->h / dWorldGetERP(s->world));
    return sim_close(s);
}
