/* 1000 kg lie on 1 kg. */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 3000);
    sim_ground(s);
    sim_box(s, 1, 0.5, 0.5, 0.5, 0, 0, 0.25);
    dBodyID top = sim_box(s, sim_value(s, "mass", 1000), 0.5, 0.5, 0.5, 0, 0, 0.75);
    sim_run(s);
    sim_print(s, "heavy");
    sim_number("top", dBodyGetPosition(top)[2]);
    return sim_close(s);
}
