/* A bridge of planks on hinges hangs between two sliders on springs. Boxes fall onto it, and a joint that carries more
 * than --strength N is destroyed; the forces of all joints are read back in every step. */
#include "sim.h"

#include <math.h>

enum { PLANKS = 10, JOINTS = PLANKS + 1 };

static dJointID joint[JOINTS];
static dJointFeedback feedback[JOINTS];
static int count, broken;
static double strength, largest;

static void add_joint(dJointID made)
{
    dJointSetFeedback(made, &feedback[count]);
    joint[count++] = made;
}

/* A joint that two steps in a row have overloaded goes. */
static void break_joints(sim *s)
{
    static int overloaded[JOINTS];
    (void)s;
    for (int k = 0; k < JOINTS; k++) {
        if (!joint[k]) continue;
        const dJointFeedback *f = &feedback[k];
        double size = sqrt(f->f1[0] * f->f1[0] + f->f1[1] * f->f1[1] + f->f1[2] * f->f1[2]);
        if (!(size <= largest)) largest = size;
        overloaded[k] = size > strength ? overloaded[k] + 1 : 0;
        if (overloaded[k] < 2) continue;
        dJointDestroy(joint[k]);
        joint[k] = NULL;
        broken++;
    }
}

static void hang(sim *s, dBodyID plank, double end)
{
    dJointID slider = dJointCreateSlider(s->world, NULL);
    dJointAttach(slider, plank, NULL);
    dJointSetSliderAxis(slider, end, 0, 0);
    dJointSetSliderParam(slider, dParamLoStop, 0);
    dJointSetSliderParam(slider, dParamHiStop, 0);
    dJointSetSliderParam(slider, dParamStopERP, s->h * 5e4 / (s->h * 5e4 + 1e3));
    dJointSetSliderParam(slider, dParamStopCFM, 1 / (s->h * 5e4 + 1e3));
    add_joint(slider);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 2000);
    dBodyID plank[PLANKS];
    int boxes = (int)sim_value(s, "boxes", 2);
    double mass = sim_value(s, "mass", 30);
    strength = sim_value(s, "strength", 5000);
    sim_ground(s);
    for (int i = 0; i < PLANKS; i++) {
        plank[i] = sim_box(s, 5, 0.38, 1.2, 0.1, 0.4 * (i - 0.5 * (PLANKS - 1)), 0, 1.5);
        if (i == 0) continue;
        dJointID hinge = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinge, plank[i - 1], plank[i]);
        dJointSetHingeAnchor(hinge, 0.4 * (i - 0.5 * PLANKS), 0, 1.5);
        dJointSetHingeAxis(hinge, 0, 1, 0);
        add_joint(hinge);
    }
    hang(s, plank[0], -1);
    hang(s, plank[PLANKS - 1], 1);
    for (int i = 0; i < boxes; i++) sim_box(s, mass, 0.4, 0.4, 0.4, 0.5 * i - 0.2, 0.1 * i, 2 + i);
    s->each_step = break_joints;
    sim_run(s);
    sim_print(s, "bridge");
    sim_number("broken", broken);
    sim_number("largest", largest);
    sim_number("middle", dBodyGetPosition(plank[PLANKS / 2])[2]);
    return sim_close(s);
}
