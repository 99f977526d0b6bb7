/*
 * The jaw of a vice is moved by both stops of its slider. It closes on a box before a wall, is told to go 5 cm further,
 * and is opened again. Prints where it is at the end, and where it was told to be.
 */
#include "sim.h"

#include <math.h>

static dJointID slider;
static double told;

static void tell(sim *s)
{
    double t = (double)s->step * s->h, far = 0.15;
    told = t < 1 ? far * t : t < 2 ? far : fmax(far * (3 - t), -0.05);
    dJointSetSliderParam(slider, dParamLoStop, told);
    dJointSetSliderParam(slider, dParamHiStop, told);
    dJointSetSliderParam(slider, dParamLoStop, told); /* in whichever order they cross */
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 1000);
    sim_ground(s);
    dBodyID jaw = sim_box(s, 1, 0.2, 0.2, 0.2, -0.3, 0, 0.15);
    sim_box(s, 1, 0.2, 0.2, 0.2, 0, 0, 0.1);
    dGeomSetPosition(dCreateBox(s->space, 0.1, 1, 1), 0.15, 0, 0.6);
    slider = dJointCreateSlider(s->world, NULL);
    dJointAttach(slider, jaw, NULL);
    dJointSetSliderAxis(slider, 1, 0, 0);
    s->each_step = tell;
    sim_run(s);
    sim_print(s, "vice");
    sim_number("error", dJointGetSliderPosition(slider) - told);
    return sim_close(s);
}
