/*
 * Two kinematic spheres press a box of 1 kg by 20 N each, with soft contacts of 20 kN/m, and rise at --speed m/s from
 * step 20 on, up to step --until (default: to the end), and then at --after (default: 0). With --hard 1 contacts are as
 * hard as ODE makes them. Prints how far the box has come to hang behind the spheres.
 */
#include "sim.h"

static void rise(sim *s)
{
    double speed = s->step <= 20                                ? 0
                   : s->step <= sim_value(s, "until", s->steps) ? sim_value(s, "speed", 0.05)
                                                                : sim_value(s, "after", 0);
    for (int i = 1; i < 3; i++) dBodySetLinearVel(s->bodies[i], 0, 0, speed);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 400);
    const double stiffness = 20000, damping = 100, radius = 0.02, depth = 0.001;
    dBodyID box = sim_box(s, 1, 0.1, 0.1, 0.1, 0, 0, 0);
    for (int side = -1; side < 2; side += 2)
        dBodySetKinematic(sim_sphere(s, 1, radius, side * (0.05 + radius - depth), 0, 0));
    if (sim_value(s, "hard", 0) == 0) s->surface.mode |= dContactSoftERP | dContactSoftCFM;
    s->surface.mu = 1;
    s->surface.soft_cfm = 1 / (s->h * stiffness + damping);
    s->surface.soft_erp = s->h * stiffness * s->surface.soft_cfm;
    s->each_step = rise;
    sim_run(s);
    sim_print(s, "lifted");
    sim_number("behind", dBodyGetPosition(s->bodies[1])[2] - dBodyGetPosition(box)[2]);
    return sim_close(s);
}
