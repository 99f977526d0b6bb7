/*
 * A car whose wheels hang on two parallel arms each, a double wishbone: the hinges of such a loop have redundant rows.
 * Spring struts between arms and chassis carry the car, and motors turn the rear wheels from 1 s on at --speed rad/s.
 *
 * What it prints beside the usual: how far it has driven, how high the chassis stands, how far the loops are open, how
 * much the uprights lean, and the widest motion of the chassis in the half second before the motors start.
 */
#include "sim.h"

#include <math.h>

enum { WHEELS = 4, ARMS = 2, HINGES = 2 * ARMS };

typedef struct corner {
    dBodyID arm[ARMS], upright, wheel;
    dJointID hinge[HINGES], strut, axle;
} corner;

static corner corners[WHEELS];
static dBodyID chassis;
static double speed, restless;

/* Turns the motors on, and watches the chassis while it stands. */
static void drive(sim *s)
{
    static double least = INFINITY, most = -INFINITY;
    double time = (double)s->step * s->h, height = dBodyGetPosition(chassis)[2];
    if (time > 0.5 && time <= 1) {
        least = fmin(least, height);
        most = fmax(most, height);
        restless = most - least;
    }
    for (int k = 0; k < WHEELS; k++) {
        dJointSetHingeParam(corners[k].axle, dParamVel, time > 1 ? speed : 0);
        dJointSetHingeParam(corners[k].axle, dParamFMax, time <= 1 ? 50 : k < 2 ? 0 : 30);
    }
}

static dJointID hinge(sim *s, dBodyID a, dBodyID b, double x, double y, double z, bool along)
{
    dJointID joint = dJointCreateHinge(s->world, NULL);
    dJointAttach(joint, a, b);
    dJointSetHingeAnchor(joint, x, y, z);
    dJointSetHingeAxis(joint, along ? 1 : 0, along ? 0 : 1, 0);
    return joint;
}

/* The arms reach from the chassis, at 0.25 m from its middle, to the upright, at 0.55 m. */
static void make_corner(sim *s, corner *c, double x, double side)
{
    static const double INNER = 0.25, OUTER = 0.55, LOW = 0.25, HIGH = 0.37;
    c->upright = sim_box(s, 1, 0.06, 0.06, 0.2, x, side * OUTER, 0.5 * (LOW + HIGH));
    for (int k = 0; k < ARMS; k++) {
        double z = k ? HIGH : LOW;
        c->arm[k] = sim_box(s, 0.5, 0.05, 0.26, 0.02, x, side * 0.5 * (INNER + OUTER), z);
        c->hinge[2 * k] = hinge(s, c->arm[k], chassis, x, side * INNER, z, true);
        c->hinge[2 * k + 1] = hinge(s, c->upright, c->arm[k], x, side * OUTER, z, true);
    }
    /* the lower arm's hinge on the chassis has a spring: both stops at 0 */
    double k = 1500, d = 60;
    c->strut = c->hinge[0];
    dJointSetHingeParam(c->strut, dParamLoStop, 0);
    dJointSetHingeParam(c->strut, dParamHiStop, 0);
    dJointSetHingeParam(c->strut, dParamStopERP, s->h * k / (s->h * k + d));
    dJointSetHingeParam(c->strut, dParamStopCFM, 1 / (s->h * k + d));
    dMatrix3 across;
    dRFromAxisAndAngle(across, 1, 0, 0, M_PI / 2);
    c->wheel = sim_sphere(s, 2, 0.25, x, side * 0.65, 0.249);
    dBodySetRotation(c->wheel, across);
    c->axle = hinge(s, c->wheel, c->upright, x, side * 0.65, 0.249, false);
}

/* How far the hinges of the arms are open, m. */
static double open_by(void)
{
    double most = 0;
    for (int k = 0; k < WHEELS; k++)
        for (int i = 0; i < HINGES; i++) {
            dVector3 a, b;
            dJointGetHingeAnchor(corners[k].hinge[i], a);
            dJointGetHingeAnchor2(corners[k].hinge[i], b);
            most = fmax(most, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
        }
    return most;
}

/* How much the uprights turn against the chassis, rad: parallel arms keep them upright. */
static double lean(void)
{
    double most = 0;
    for (int k = 0; k < WHEELS; k++) {
        dVector3 up, own;
        dBodyVectorToWorld(chassis, 0, 0, 1, up);
        dBodyVectorToWorld(corners[k].upright, 0, 0, 1, own);
        most = fmax(most, acos(fmin(1, dCalcVectorDot3(up, own))));
    }
    return most;
}

/* Parts of a car do not collide with each other. */
static void make_ghosts(void)
{
    for (int k = 0; k < WHEELS; k++) {
        dGeomDisable(dBodyGetFirstGeom(corners[k].upright));
        for (int i = 0; i < ARMS; i++) dGeomDisable(dBodyGetFirstGeom(corners[k].arm[i]));
    }
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 1000);
    speed = sim_value(s, "speed", 8);
    sim_ground(s);
    s->surface.mu = 1;
    chassis = sim_box(s, 30, 1.6, 0.5, 0.15, 0, 0, 0.45);
    for (int k = 0; k < WHEELS; k++) make_corner(s, &corners[k], k < 2 ? 0.6 : -0.6, k % 2 ? 1 : -1);
    make_ghosts();
    s->each_step = drive;
    sim_run(s);
    sim_print(s, "wishbone");
    sim_number("distance", dBodyGetPosition(chassis)[0]);
    sim_number("aside", dBodyGetPosition(chassis)[1]);
    sim_number("height", dBodyGetPosition(chassis)[2]);
    sim_number("open", open_by());
    sim_number("lean", lean());
    sim_number("restless", restless);
    return sim_close(s);
}
