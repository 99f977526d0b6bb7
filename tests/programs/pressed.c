/*
 * A plate that moves whatever it meets presses a row of bodies along the ground against a wall, by --squeeze m more
 * than there is room for: --objects of --size m, capsules, with --spheres 1 spheres. The plate is --height times as
 * high. --lever R: it presses the short end of a plank down instead, which turns about a hinge, the other arm R times
 * as long. Prints the speed of the plank's long end when the plate has gone 5 mm, m/s.
 */
#include "sim.h"

static const double SPEED = 0.5, ARM = 0.05;

static dBodyID make_plate(sim *s, double depth, double width, double height)
{
    dBodyID plate = dBodyCreate(s->world);
    dBodySetKinematic(plate);
    dGeomSetBody(dCreateBox(s->space, depth, width, height), plate);
    return plate;
}

static void press_row(sim *s)
{
    double size = sim_value(s, "size", 0.06), height = sim_value(s, "height", 0.1) * size;
    double squeeze = sim_value(s, "squeeze", 0.02);
    int count = (int)sim_value(s, "objects", 3);
    bool spheres = sim_value(s, "spheres", 0) != 0;
    dCreatePlane(s->space, -1, 0, 0, 0);
    sim_ground(s);
    for (int k = 0; k < count; k++) {
        double place = -0.55 * size - 1.1 * size * k;
        if (spheres)
            sim_sphere(s, 0.02, 0.5 * size, place, 0, 0.5 * size);
        else
            sim_capsule(s, 0.02, 0.5 * size, 0.5 * size, place, 0, 0.5 * size);
    }
    double start = -1.1 * size * count - size, end = squeeze - size * count - 0.5 * size;
    dBodyID plate = make_plate(s, size, 1.2 * size, height);
    dBodySetPosition(plate, start, 0, 0.5 * height + 0.01 * size);
    dBodySetLinearVel(plate, SPEED, 0, 0);
    s->steps = (long)((end - start) / SPEED / s->h);
}

static dBodyID make_lever(sim *s, double ratio)
{
    dBodyID plank = sim_box(s, 0.1, (1 + ratio) * ARM, ARM, 0.01, 0.5 * (ratio - 1) * ARM, 0, 0);
    dJointID hinge = dJointCreateHinge(s->world, 0);
    dJointAttach(hinge, plank, 0);
    dJointSetHingeAnchor(hinge, 0, 0, 0);
    dJointSetHingeAxis(hinge, 0, 1, 0);
    dBodyID plate = make_plate(s, 0.2 * ARM, ARM, 0.02);
    dBodySetPosition(plate, -0.9 * ARM, 0, 0.5 * 0.01 + 0.5 * 0.02);
    dBodySetLinearVel(plate, 0, 0, -SPEED);
    s->steps = (long)(0.005 / SPEED / s->h);
    return plank;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.002, 0);
    double ratio = sim_value(s, "lever", 0);
    dBodyID plank = NULL;
    if (ratio > 0)
        plank = make_lever(s, ratio);
    else
        press_row(s);
    sim_run(s);
    sim_print(s, "pressed");
    if (plank) {
        dVector3 velocity;
        dBodyGetPointVel(plank, ratio * ARM, 0, 0, velocity);
        sim_number("end_speed", velocity[2]);
    }
    return sim_close(s);
}
