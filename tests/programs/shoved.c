/*
 * A block that is moved by its pose alone shoves a box along the ground at --speed, or lifts it with --lift 1. It has
 * no velocity, with --kinematic 1 as a body, with --kinematic 2 a small spin; with --dynamic M it is a body of M kg
 * that is put back to its place, at rest, in each step. --plane 1: a plane in the block's place. --weightless 1:
 * without gravity and ground. --every N: the pose is set in every N-th step only. --jump D: it is set once, by D m.
 * Prints how far the box's centre is ahead of where the block would carry it without an overlap, m, and its speed along
 * the way, m/s.
 */
#include "sim.h"

static const double SIZE = 0.1;
static double speed, jump;
static bool lift, plane;
static long every;
static dGeomID block;
static dBodyID carrier;

/* Where the block is at the start of a step: its face touches the box at time 0. */
static double way_at(double time)
{
    return -0.5 * SIZE + (jump > 0 ? jump * (time > 0.1) : speed * time);
}

static void put(double x, double z)
{
    static const dMatrix3 UPRIGHT = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    dBodySetPosition(carrier, x, 0, z);
    if (dBodyIsKinematic(carrier)) return;
    dBodySetRotation(carrier, UPRIGHT);
    dBodySetLinearVel(carrier, 0, 0, 0);
    dBodySetAngularVel(carrier, 0, 0, 0);
}

static void move_block(sim *s)
{
    if (s->step % every != 0) return;
    double way = way_at((double)s->step * s->h), x = lift ? 0 : way - 0.5 * SIZE, z = lift ? way : 0.6 * SIZE;
    if (plane)
        dGeomPlaneSetParams(block, 1, 0, 0, way);
    else if (carrier)
        put(x, z);
    else
        dGeomSetPosition(block, x, 0, z);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 200);
    speed = sim_value(s, "speed", 0.2);
    lift = sim_value(s, "lift", 0) != 0;
    bool weightless = sim_value(s, "weightless", 0) != 0;
    if (weightless) dWorldSetGravity(s->world, 0, 0, 0);
    if (!lift && !weightless) sim_ground(s);
    jump = sim_value(s, "jump", 0);
    plane = sim_value(s, "plane", 0) != 0;
    every = (long)sim_value(s, "every", 1);
    block = plane ? dCreatePlane(s->space, 1, 0, 0, 0) : dCreateBox(s->space, SIZE, 4 * SIZE, SIZE);
    int kind = (int)sim_value(s, "kinematic", 0);
    if (kind != 0) {
        carrier = dBodyCreate(s->world);
        dBodySetKinematic(carrier);
        if (kind == 2) dBodySetAngularVel(carrier, 1e-9, 0, 0);
        dGeomSetBody(block, carrier);
    }
    double mass = sim_value(s, "dynamic", 0);
    if (mass > 0) {
        carrier = dBodyCreate(s->world);
        dMass of_block;
        dMassSetBoxTotal(&of_block, mass, SIZE, 4 * SIZE, SIZE);
        dBodySetMass(carrier, &of_block);
        dBodySetGravityMode(carrier, 0);
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
