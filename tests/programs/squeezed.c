/*
 * Two fingers of 0.1 kg on sliders squeeze a box of --mass (default 0.001 kg) and 4 cm, each by a motor of at most
 * --force (default 50 N) that closes at --speed (default 0.01 m/s), without gravity. With --links N > 0 each finger is
 * a chain of N links of 7 cm instead that hangs above the box. Its hinges have motors of at most --force times 7 cm,
 * the first of which closes, and the others hold the finger straight. Prints by how much the fingers are nearer to each
 * other than the box is wide, m, and the force (N) that both exert on it together.
 */
#include "sim.h"

#include <math.h>

enum { MOST_LINKS = 8 };
static const double SIZE = 0.04, THICK = 0.015, LINK = 0.07;
static dJointID hinges[2][MOST_LINKS];
static double squeezed_by; /* N, in the last step */

/* Before each step. The contacts are those of the last. */
static void hold_straight(sim *s)
{
    for (int i = 0; i < 2; i++)
        for (int k = 1; k < MOST_LINKS && hinges[i][k]; k++)
            dJointSetHingeParam(hinges[i][k], dParamVel, -20 * dJointGetHingeAngle(hinges[i][k]));
    squeezed_by = 0;
    for (int k = 0; k < s->contact_count; k++) squeezed_by += fabs(s->feedback[k].f1[0]);
}

/* Returns the last link of a chain from above. */
static dBodyID hang_links(sim *s, int i, int links, double x, double speed, double torque)
{
    dBodyID last = NULL;
    for (int k = 0; k < links; k++) {
        double top = LINK * (links - 0.5 - k);
        dBodyID link = sim_box(s, 0.05, THICK, 0.04, LINK - 0.01, x, 0, top - 0.5 * LINK);
        hinges[i][k] = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinges[i][k], link, last);
        dJointSetHingeAnchor(hinges[i][k], x, 0, top);
        dJointSetHingeAxis(hinges[i][k], 0, 1, 0);
        dJointSetHingeParam(hinges[i][k], dParamVel, k == 0 ? speed / LINK : 0);
        dJointSetHingeParam(hinges[i][k], dParamFMax, torque);
        last = link;
    }
    return last;
}

static dBodyID put_on_slider(sim *s, double x, double speed, double force)
{
    dBodyID finger = sim_box(s, 0.1, THICK, 0.04, 0.05, x, 0, 0);
    dJointID slider = dJointCreateSlider(s->world, NULL);
    dJointAttach(slider, finger, NULL);
    dJointSetSliderAxis(slider, 1, 0, 0);
    dJointSetSliderParam(slider, dParamVel, speed);
    dJointSetSliderParam(slider, dParamFMax, force);
    return finger;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 400);
    double mass = sim_value(s, "mass", 0.001), force = sim_value(s, "force", 50), speed = sim_value(s, "speed", 0.01);
    int links = (int)fmin(sim_value(s, "links", 0), MOST_LINKS);
    dBodyID finger[2];
    dWorldSetGravity(s->world, 0, 0, 0);
    sim_box(s, mass, SIZE, SIZE, 0.06, 0, 0, 0);
    for (int i = 0; i < 2; i++) {
        double side = i == 0 ? -1 : 1, x = side * (0.5 * (SIZE + THICK) + 1e-4);
        finger[i] = links > 0 ? hang_links(s, i, links, x, side * speed, LINK * force)
                              : put_on_slider(s, x, -side * speed, force);
    }
    s->want_feedback = true;
    s->each_step = hold_straight;
    sim_run(s);
    sim_print(s, "squeezed");
    sim_number("overlap", SIZE + THICK - (dBodyGetPosition(finger[1])[0] - dBodyGetPosition(finger[0])[0]));
    sim_number("force", squeezed_by);
    return sim_close(s);
}
