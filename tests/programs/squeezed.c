/*
 * Two fingers of 0.1 kg on sliders squeeze a box of --mass (default 0.001 kg) and 4 cm, each by a motor of at most
 * --force (default 50 N) that closes at --speed (default 0.01 m/s), without gravity. Prints by how much the fingers are
 * nearer to each other than the box is wide, m, and the force (N) that both exert on it together.
 */
#include "sim.h"

#include <math.h>

static const double SIZE = 0.04, THICK = 0.015;
static double squeezed_by; /* N, in the last step */

static void sum_up_forces(sim *s)
{
    squeezed_by = 0;
    for (int k = 0; k < s->contact_count; k++) squeezed_by += fabs(s->feedback[k].f1[0]);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 400);
    double mass = sim_value(s, "mass", 0.001), force = sim_value(s, "force", 50), speed = sim_value(s, "speed", 0.01);
    dBodyID finger[2];
    dWorldSetGravity(s->world, 0, 0, 0);
    sim_box(s, mass, SIZE, SIZE, 0.06, 0, 0, 0);
    for (int i = 0; i < 2; i++) {
        double side = i == 0 ? -1 : 1;
        finger[i] = sim_box(s, 0.1, THICK, 0.04, 0.05, side * (0.5 * (SIZE + THICK) + 1e-4), 0, 0);
        dJointID slider = dJointCreateSlider(s->world, NULL);
        dJointAttach(slider, finger[i], NULL);
        dJointSetSliderAxis(slider, 1, 0, 0);
        dJointSetSliderParam(slider, dParamVel, -side * speed);
        dJointSetSliderParam(slider, dParamFMax, force);
    }
    s->want_feedback = true;
    s->each_step = sum_up_forces;
    sim_run(s);
    sim_print(s, "squeezed");
    sim_number("overlap", SIZE + THICK - (dBodyGetPosition(finger[1])[0] - dBodyGetPosition(finger[0])[0]));
    sim_number("force", squeezed_by);
    return sim_close(s);
}
