/*
 * A stack of --boxes boxes that begin --depth deep in the ground, and --between deep in each other. --hinged 1: beside
 * each is another one on a hinge, as deep. Prints when the highest had come 95 % of the way to where it belongs, s; 0:
 * never.
 */
#include "sim.h"

static const double SIZE = 0.2;
static double begins, belongs, out_after;
static dBodyID highest;

static void look(sim *s)
{
    double z = dBodyGetPosition(highest)[2];
    if (out_after == 0 && z >= begins + 0.95 * (belongs - begins)) out_after = (double)s->step * s->h;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 600);
    int boxes = (int)sim_value(s, "boxes", 1);
    double depth = sim_value(s, "depth", 0.05), between = sim_value(s, "between", 0);
    bool hinged = sim_value(s, "hinged", 0) != 0;
    sim_ground(s);
    for (int i = 0; i < boxes; i++) {
        begins = 0.5 * SIZE - depth + i * (SIZE - between);
        belongs = (i + 0.5) * SIZE;
        highest = sim_box(s, 1, SIZE, SIZE, SIZE, 0, 0, begins);
        if (!hinged) continue;
        dBodyID beside = sim_box(s, 1, SIZE, SIZE, SIZE, 1.5 * SIZE, 0, begins);
        dJointID hinge = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinge, highest, beside);
        dJointSetHingeAnchor(hinge, 0.75 * SIZE, 0, begins);
        dJointSetHingeAxis(hinge, 0, 1, 0);
    }
    s->each_step = look;
    sim_run(s);
    sim_print(s, "sunk");
    sim_number("out_after", out_after);
    return sim_close(s);
}
