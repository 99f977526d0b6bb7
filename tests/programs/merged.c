/*
 * A body of a sphere, a box and a capsule begins in another one of --kind 0 box or 1 capsule, at places and of sizes
 * that follow the --seed, with friction without a limit. Both come apart as the overlaps push them.
 */
#include "sim.h"

static double between(double low, double high)
{
    return low + (high - low) * dRandReal();
}

static dGeomID random_shape(sim *s, int kind)
{
    double x = between(0.1, 0.6), y = between(0.1, 0.6), z = between(0.1, 0.6);
    if (kind == 0) return dCreateBox(s->space, x, y, z);
    return kind == 1 ? dCreateCapsule(s->space, 0.5 * x, y) : dCreateSphere(s->space, 0.5 * x);
}

static void random_turn(dMatrix3 turn)
{
    double x = between(-0.5, 0.5), y = between(-0.5, 0.5), z = between(-0.5, 0.5);
    dRFromAxisAndAngle(turn, x, y, z, between(0, 6));
}

static dBodyID add_body(sim *s, double x, double y, double z)
{
    dMass mass;
    dBodyID body = dBodyCreate(s->world);
    dMassSetBox(&mass, 5, 0.4, 0.4, 0.4);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, x, y, z);
    s->bodies[s->body_count++] = body;
    return body;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.02, 2000);
    dMatrix3 turn;
    dWorldSetContactMaxCorrectingVel(s->world, 0.1);
    dWorldSetGravity(s->world, 0, 0, -0.5);
    sim_ground(s);
    s->surface.mode = dContactSoftCFM;
    s->surface.mu = dInfinity;
    s->surface.soft_cfm = 0.01;
    dBodyID lower = add_body(s, 0, 0, 0.5);
    dGeomSetBody(random_shape(s, (int)sim_value(s, "kind", 0)), lower);
    random_turn(turn);
    dBodySetRotation(lower, turn);
    dBodyID upper = add_body(s, between(-0.2, 0.2), between(-0.2, 0.2), 0.7);
    for (int kind = 0; kind < 3; kind++) {
        dGeomID geom = random_shape(s, kind);
        double x = between(-0.15, 0.15), y = between(-0.15, 0.15), z = between(-0.15, 0.15);
        dGeomSetBody(geom, upper);
        dGeomSetOffsetPosition(geom, x, y, z);
        random_turn(turn);
        dGeomSetOffsetRotation(geom, turn);
    }
    sim_run(s);
    sim_print(s, "merged");
    return sim_close(s);
}
