/* Boxes come to rest and are disabled; a ball wakes the one it hits. */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 1500);
    enum { BOXES = 6 };
    dWorldSetAutoDisableFlag(s->world, 1);
    dWorldSetAutoDisableSteps(s->world, 20);
    sim_ground(s);
    for (int i = 0; i < BOXES; i++) sim_box(s, 1, 0.4, 0.4, 0.4, i, 0, 0.21);
    long half = s->steps / 2;
    double asleep = 0, woken = 0;
    while (s->step < half) sim_step(s);
    for (int i = 0; i < BOXES; i++) asleep += !dBodyIsEnabled(s->bodies[i]);
    dBodyID ball = sim_sphere(s, 2, 0.2, 0, -1.5, 0.25);
    dBodySetLinearVel(ball, 0, 6, 0);
    while (s->step < s->steps) {
        sim_step(s);
        if (s->step < half + 100 && dBodyIsEnabled(s->bodies[0])) woken = 1;
    }
    sim_print(s, "sleep");
    sim_number("asleep", asleep);
    sim_number("woken", woken);
    sim_number("moved", dBodyGetPosition(s->bodies[0])[1]);
    return sim_close(s);
}
