/*
 * A block that is moved by its pose alone, and has no velocity, shoves a box along the ground at --speed, or lifts it
 * with --lift 1. With --kinematic 1 it is a kinematic body. Prints how far the box's centre is ahead of where the block
 * would carry it without an overlap, m, and its speed along the way, m/s.
 */
#include "sim.h"

static const double SIZE = 0.1;
static double speed;
static bool lift;
static dGeomID block;
static dBodyID carrier;

/* Where the block is at the start of a step: its face touches the box at time 0. */
static double way_at(double time)
{
    return -0.5 * SIZE + speed * time;
}

static void move_block(sim *s)
{
    double way = way_at((double)s->step * s->h), x = lift ? 0 : way - 0.5 * SIZE, z = lift ? way : 0.6 * SIZE;
    if (carrier)
        dBodySetPosition(carrier, x, 0, z);
    else
        dGeomSetPosition(block, x, 0, z);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 200);
    speed = sim_value(s, "speed", 0.2);
    lift = sim_value(s, "lift", 0) != 0;
    if (!lift) sim_ground(s);
    block = dCreateBox(s->space, SIZE, 4 * SIZE, SIZE);
    if (sim_value(s, "kinematic", 0) != 0) {
        carrier = dBodyCreate(s->world);
        dBodySetKinematic(carrier);
        dGeomSetBody(block, carrier);
    }
    dBodyID box = sim_box(s, 1, SIZE, SIZE, SIZE, 0, 0, 0.5 * SIZE);
    move_block(s);
    s->each_step = move_block;
    sim_run(s);
    sim_print(s, "shoved");
    int axis = lift ? 2 : 0;
    /* the box has been moved by the step that began with the block a step earlier */
    double carried = way_at((double)(s->step - 1) * s->h) + (lift ? SIZE : 0.5 * SIZE);
    sim_number("ahead", dBodyGetPosition(box)[axis] - carried);
    sim_number("speed", dBodyGetLinearVel(box)[axis]);
    return sim_close(s);
}
