/* A box with slip1 and slip2 (force-dependent slip) creeps under a push of --push newtons. */
#include "sim.h"

static double push;
static dBodyID box;

static void press(sim *s)
{
    (void)s;
    dBodyAddForce(box, push, 0, 0);
}

static bool aligned(sim *s, dContact *contact)
{
    (void)s;
    contact->fdir1[0] = 1;
    contact->fdir1[1] = contact->fdir1[2] = 0;
    return true;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 2000);
    push = sim_value(s, "push", 2);
    sim_ground(s);
    box = sim_box(s, 1, 0.4, 0.4, 0.1, 0, 0, 0.05);
    s->surface.mode |= dContactSlip1 | dContactSlip2 | dContactFDir1;
    s->surface.slip1 = s->surface.slip2 = sim_value(s, "slip", 0.01);
    s->change = aligned;
    s->each_step = press;
    sim_run(s);
    sim_print(s, "slip");
    sim_number("velocity", dBodyGetLinearVel(box)[0]);
    return sim_close(s);
}
