/* A pile of 200 spheres with rolling and spinning friction lies in a pit. */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 5000);
    int count = (int)sim_value(s, "count", 200);
    sim_ground(s);
    sim_pit(s, 0.5);
    s->surface.mode |= dContactRolling;
    s->surface.rho = s->surface.rho2 = 0.01;
    s->surface.rhoN = 0.005;
    for (int i = 0; i < count && i < SIM_MOST_BODIES; i++) {
        double y = -0.32 + 0.21 * (i / 4 % 4) + 0.02 * dRandReal(), x = -0.32 + 0.21 * (i % 4) + 0.02 * dRandReal();
        sim_sphere(s, 0.5, 0.08, x, y, 0.1 + 0.2 * (i / 16));
    }
    sim_run(s);
    sim_print(s, "spheres");
    return sim_close(s);
}
