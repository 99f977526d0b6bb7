/* A box lies on a belt that moves along x with --speed m/s (motion1), uphill by --slope degrees. */
#include "sim.h"

#include <math.h>

/* The direction of the belt; the motion is that of the ground under whichever body comes first. */
static bool along_belt(sim *s, dContact *contact)
{
    (void)s;
    contact->fdir1[0] = 1;
    contact->fdir1[1] = contact->fdir1[2] = 0;
    return true;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 1000);
    double slope = sim_value(s, "slope", 0) * M_PI / 180;
    dWorldSetGravity(s->world, -9.81 * sin(slope), 0, -9.81 * cos(slope));
    sim_ground(s);
    dBodyID box = sim_box(s, 1, 0.4, 0.4, 0.2, 0, 0, 0.1);
    s->surface.mode |= dContactMotion1 | dContactFDir1;
    s->surface.motion1 = sim_value(s, "speed", 0.5);
    s->change = along_belt;
    sim_run(s);
    sim_print(s, "conveyor");
    sim_number("velocity", dBodyGetLinearVel(box)[0]);
    sim_number("distance", dBodyGetPosition(box)[0]);
    return sim_close(s);
}
