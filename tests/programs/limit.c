/* Without dContactApprox1 mu is a force in newtons per contact. A box on four contacts is pushed. */
#include "sim.h"

static double push;
static dBodyID box;

static void press(sim *s)
{
    double rising = (double)s->step * s->h;
    dBodyAddForce(box, push * (rising < 1 ? rising : 1), 0, 0);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 2000);
    push = sim_value(s, "push", 1.9);
    sim_ground(s);
    box = sim_box(s, 1, 0.4, 0.4, 0.05, 0, 0, 0.025);
    s->surface.mode = 0;
    s->each_step = press;
    sim_run(s);
    sim_print(s, "limit");
    sim_number("moved", dBodyGetPosition(box)[0]);
    sim_number("velocity", dBodyGetLinearVel(box)[0]);
    return sim_close(s);
}
