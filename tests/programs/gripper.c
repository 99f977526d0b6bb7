/* Two fingers on velocity motors close on a box; the hand lifts it. */
#include "sim.h"

static dJointID lift, fingers[2];

static dJointID slider(sim *s, dBodyID a, dBodyID b, double x, double z, double force)
{
    dJointID joint = dJointCreateSlider(s->world, NULL);
    dJointAttach(joint, a, b);
    dJointSetSliderAxis(joint, x, 0, z);
    dJointSetSliderParam(joint, dParamFMax, force);
    dJointSetSliderParam(joint, dParamVel, 0);
    return joint;
}

static void drive(sim *s)
{
    double time = (double)s->step * s->h;
    dJointSetSliderParam(fingers[0], dParamVel, 0.05);
    dJointSetSliderParam(fingers[1], dParamVel, -0.05);
    dJointSetSliderParam(lift, dParamVel, time > 2 && time < 5 ? 0.1 : 0);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 3000);
    sim_ground(s);
    dBodyID held = sim_box(s, 0.5, 0.1, 0.1, 0.1, 0, 0, 0.05);
    dBodyID hand = sim_box(s, 2, 0.3, 0.1, 0.05, 0, 0, 0.4);
    dBodySetGravityMode(hand, 0);
    lift = slider(s, hand, NULL, 0, 1, 500);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.08 : -0.08;
        dBodyID finger = sim_box(s, 0.3, 0.02, 0.06, 0.2, x, 0, 0.15);
        dBodySetGravityMode(finger, 0);
        fingers[i] = slider(s, finger, hand, 1, 0, 20);
    }
    s->surface.mu = 0.8;
    s->each_step = drive;
    sim_run(s);
    sim_print(s, "gripper");
    sim_number("held", dBodyGetPosition(held)[2]);
    sim_number("hand", dBodyGetPosition(hand)[2]);
    return sim_close(s);
}
