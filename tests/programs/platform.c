/*
 * A plank is hinged to two carriages on vertical sliders. Both stops of each are moved by --height in 2 s, which lifts
 * it. Prints how far below that it is at the end, m.
 */
#include "sim.h"

#include <math.h>

static dJointID slider[2];
static double height;

static void raise_stops(sim *s)
{
    double t = (double)s->step * s->h, told = height * fmin(0.5 * t, 1);
    for (int i = 0; i < 2; i++) {
        dJointSetSliderParam(slider[i], dParamHiStop, told);
        dJointSetSliderParam(slider[i], dParamLoStop, told);
    }
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 1000);
    height = sim_value(s, "height", 1);
    dBodyID plank = sim_box(s, 1, 1, 0.1, 0.1, 0, 0, 0.5);
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.5 : -0.5;
        dBodyID carriage = dBodyCreate(s->world);
        dMass mass;
        dMassSetBoxTotal(&mass, 1, 0.1, 0.1, 0.1);
        dBodySetMass(carriage, &mass);
        dBodySetPosition(carriage, x, 0, 0.5);
        slider[i] = dJointCreateSlider(s->world, NULL);
        dJointAttach(slider[i], carriage, NULL);
        dJointSetSliderAxis(slider[i], 0, 0, 1);
        dJointID hinge = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinge, carriage, plank);
        dJointSetHingeAnchor(hinge, x, 0, 0.5);
        dJointSetHingeAxis(hinge, 0, 1, 0);
    }
    s->each_step = raise_stops;
    sim_run(s);
    sim_print(s, "platform");
    sim_number("below", 0.5 + height - dBodyGetPosition(plank)[2]);
    return sim_close(s);
}
