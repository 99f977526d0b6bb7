/* With mu = dInfinity a flat box lies on a steep slope of --angle degrees, with a stack on it. */
#include "sim.h"

#include <math.h>

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 3000);
    double angle = sim_value(s, "angle", 50) * M_PI / 180;
    sim_ground(s);
    dWorldSetGravity(s->world, 9.81 * sin(angle), 0, -9.81 * cos(angle));
    for (int i = 0; i < 3; i++) sim_box(s, 1, 0.8, 0.8, 0.05, 0, 0, 0.025 + 0.05 * i);
    s->surface.mode = sim_value(s, "approx", 0) > 0 ? dContactApprox1 : 0;
    s->surface.mu = dInfinity;
    sim_run(s);
    sim_print(s, "infinite");
    sim_number("moved", dBodyGetPosition(s->bodies[2])[0]);
    return sim_close(s);
}
