/*
 * --links plates on hinges, a ring that stands on the ground, or with --open 1 one that is cut at its side. It
 * collapses, and its plates come to lie on each other and jam. Prints the largest error of a hinge's position at the
 * end, m.
 */
#include "sim.h"

#include <math.h>

enum { MOST_LINKS = 100 };

int main(int argc, char **argv)
{
    static dBodyID plate[MOST_LINKS];
    static dJointID hinge[MOST_LINKS];
    static const double LENGTH = 0.1, WIDTH = 0.25, THICKNESS = 0.03, APART = 0.11, MASS = 0.3;
    sim *s = sim_open(argc, argv, 0.01, 400);
    int links = (int)sim_value(s, "links", 30);
    if (links < 3 || links > MOST_LINKS) return 2;
    int hinges = links - (sim_value(s, "open", 0) > 0);
    double radius = links * APART / (2 * M_PI), height = radius + THICKNESS;
    s->surface.mu = 1;
    sim_ground(s);
    for (int i = 0; i < links; i++) {
        double angle = 2 * M_PI * (i + 0.5) / links;
        dMatrix3 turned;
        dRFromAxisAndAngle(turned, 0, 1, 0, -(angle + M_PI / 2));
        plate[i] = sim_box(s, MASS, LENGTH, WIDTH, THICKNESS, radius * cos(angle), 0, height + radius * sin(angle));
        dBodySetRotation(plate[i], turned);
    }
    for (int i = 0; i < hinges; i++) {
        double angle = 2 * M_PI * (i + 1) / links;
        hinge[i] = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinge[i], plate[i], plate[(i + 1) % links]);
        dJointSetHingeAnchor(hinge[i], radius * cos(angle), 0, height + radius * sin(angle));
        dJointSetHingeAxis(hinge[i], 0, 1, 0);
    }
    sim_run(s);
    double gap = 0;
    for (int i = 0; i < hinges; i++) {
        dVector3 a, b;
        dJointGetHingeAnchor(hinge[i], a);
        dJointGetHingeAnchor2(hinge[i], b);
        gap = fmax(gap, dCalcPointsDistance3(a, b));
    }
    sim_print(s, "plates");
    sim_number("gap", gap);
    return sim_close(s);
}
