/* Grasps and heaps of any size as plain ODE worlds. Fingertips press by 0.5 mm, which is 10 N each. */
#include "world.h"

#include "common/vector.h"

#include <math.h>

static const double CLOSING = 5e-4, TIP = 0.01; /* m */
static const double CFM = 1e-5;                 /* s/kg, as ODE's own examples have it */

/* A carried tip sits on a body that `drive` moves. */
static void add_sphere_tip(bench_world *w, bool carried, double x, double y, double z)
{
    if (carried)
        bench_add_tip(w, dCreateSphere(NULL, TIP), bench_add_driven(w, x, y, z), 0, 0, 0);
    else
        bench_add_tip(w, dCreateSphere(NULL, TIP), NULL, x, y, z);
}

/* Spreads `count` fingertips evenly over the two faces of a cube across x. */
static void hold_cube(bench_world *w, int count, bool carried, double x, double y)
{
    const double half = 0.025, reach = half + TIP - CLOSING;
    bench_add_body(w, dCreateBox(NULL, 2 * half, 2 * half, 2 * half), 0.2, x, y, 0);
    int left = count / 2, right = count - left;
    for (int k = 0; k < count; k++) {
        int on_side = k < left ? left : right, place = k < left ? k : k - left;
        double angle = 2 * SCENE_PI * place / on_side, spread = on_side > 1 ? 0.012 : 0;
        add_sphere_tip(w, carried, x + (k < left ? -reach : reach), y + spread * cos(angle), spread * sin(angle));
    }
}

static void pinch_capsule(bench_world *w)
{
    const double reach = 0.012 + 0.005 - CLOSING;
    dBodyID body = bench_add_body(w, dCreateCapsule(NULL, 0.012, 0.06), 0.045, 0, 0, 0);
    dQuaternion lying;
    dQFromAxisAndAngle(lying, 0, 1, 0, SCENE_PI / 2);
    dBodySetQuaternion(body, lying);
    bench_add_tip(w, dCreateBox(NULL, 0.03, 0.01, 0.03), NULL, 0, reach, 0);
    bench_add_tip(w, dCreateBox(NULL, 0.03, 0.01, 0.03), NULL, 0, -reach, 0);
}

/* Places fingertips all around a ball that is as large as they need, on the spiral of golden angles. */
static void hold_ball(bench_world *w, int count)
{
    const double turn = SCENE_PI * (3 - sqrt(5)), radius = fmax(0.05, 0.8 * TIP * sqrt(count));
    bench_add_body(w, dCreateSphere(NULL, radius), 0.2, 0, 0, 0);
    for (int k = 0; k < count; k++) {
        double z = 1 - (2 * k + 1.0) / count, across = sqrt(1 - z * z), reach = radius + TIP - CLOSING;
        add_sphere_tip(w, false, reach * across * cos(k * turn), reach * across * sin(k * turn), reach * z);
    }
}

void bench_build_object(bench_world *w, int n)
{
    if (n == 2)
        pinch_capsule(w);
    else if (n < 10)
        hold_cube(w, n, false, 0, 0);
    else
        hold_ball(w, n);
}

/* The place of item k on a square grid. */
static void grid(int k, int n, double pitch, double *x, double *y)
{
    int side = (int)ceil(sqrt(n));
    *x = pitch * (k % side);
    *y = pitch * (k / side);
}

void bench_build_hands(bench_world *w, int n)
{
    for (int k = 0; k < n; k++) {
        double x, y;
        grid(k, n, 0.15, &x, &y);
        hold_cube(w, 5, false, x, y);
    }
}

/* Carries up and down by 2 mm, three times a second. */
static void carry(bench_world *w)
{
    const double speed = 0.02, frequency = 3;
    for (int k = 0; k < w->driven_count; k++)
        dBodySetLinearVel(w->driven[k], 0, 0, speed * cos(2 * SCENE_PI * frequency * w->time));
}

void bench_build_carried(bench_world *w, int n)
{
    w->drive = carry;
    for (int k = 0; k < n; k++) {
        double x, y;
        grid(k, n, 0.15, &x, &y);
        hold_cube(w, 5, true, x, y);
    }
}

/* Every hinge has a spring about the posture that it starts from, and the torque that presses. */
static void turn_hinges(bench_world *w)
{
    const double stiffness = 0.5, damping = 2e-3; /* N m/rad, N m s/rad */
    for (int k = 0; k < w->hinge_count; k++) {
        double angle = dJointGetHingeAngle(w->hinges[k]), rate = dJointGetHingeAngleRate(w->hinges[k]);
        dJointAddHingeTorque(w->hinges[k], w->torques[k] - stiffness * angle - damping * rate);
    }
}

/* A finger of three links in the plane through the ball's vertical axis. The last link has a round tip that presses
 * horizontally against the ball's equator. */
static void add_finger(bench_world *w, double x, double y, double angle, double ball)
{
    enum { LINKS = 3 };
    const double c = cos(angle), s = sin(angle), length = 0.04, press = 2; /* N */
    const double axis[3] = {s, -c, 0};                                     /* a positive turn closes */
    double reach = ball + TIP, low = -LINKS * length;
    dBodyID below = NULL;
    for (int k = 0; k < LINKS; k++) {
        double z = low + (k + 0.5) * length;
        const double anchor[3] = {x + reach * c, y + reach * s, low + k * length};
        dBodyID link = bench_add_body(w, dCreateCapsule(NULL, 0.006, length), 0.03, x + reach * c, y + reach * s, z);
        dGeomID geom = dBodyGetFirstGeom(link);
        dGeomSetCategoryBits(geom, 0);
        dGeomSetCollideBits(geom, 0);
        bench_add_hinge(w, link, below, anchor, axis, press * (LINKS - k) * length);
        below = link;
    }
    dGeomID tip = dCreateSphere(w->space, TIP);
    bench_add_tip(w, tip, below, 0, 0, 0);
    dGeomSetOffsetPosition(tip, 0, 0, 0.5 * length);
}

void bench_build_articulated(bench_world *w, int n)
{
    const double ball = 0.03;
    w->drive = turn_hinges;
    for (int k = 0; k < n; k++) {
        double x, y;
        grid(k, n, 0.2, &x, &y);
        bench_add_body(w, dCreateSphere(NULL, ball), 0.1, x, y, 0);
        for (int finger = 0; finger < 5; finger++) add_finger(w, x, y, 2 * SCENE_PI * finger / 5, ball);
    }
}

/* Rubs to and fro at 50 mm/s. The four tips of a cube move against each other, so that their forces and moments cancel.
 */
static void rub(bench_world *w)
{
    const double speed = 0.05, way = 0.01, period = 4 * way / speed;
    double phase = fmod(w->time + way / speed, period);
    double direction = phase < 0.5 * period ? 1 : -1;
    for (int k = 0; k < w->driven_count; k++)
        dBodySetLinearVel(w->driven[k], 0, 0, (k % 4 == 0 || k % 4 == 3 ? speed : -speed) * direction);
}

void bench_build_slip(bench_world *w, int n)
{
    const double half = 0.025, reach = half + TIP - CLOSING;
    w->drive = rub;
    dWorldSetGravity(w->ode, 0, 0, 0); /* contacts that always slip hold nothing up */
    for (int k = 0; k < n; k++) {
        double x, y;
        grid(k, n, 0.15, &x, &y);
        bench_add_body(w, dCreateBox(NULL, 2 * half, 2 * half, 2 * half), 0.2, x, y, 0);
        for (int tip = 0; tip < 4; tip++) {
            double at = x + (tip < 2 ? -reach : reach), beside = y + (tip % 2 ? 0.012 : -0.012);
            bench_add_tip(w, dCreateSphere(NULL, TIP), bench_add_driven(w, at, beside, 0), 0, 0, 0);
        }
    }
}

static const double DENSITY = 625; /* density of bricks, kg/m^3: a whole brick of a thin wall weighs 10 kg */

static void lay_brick(bench_world *w, double length, double depth, double height, double x, double z)
{
    bench_add_body(w, dCreateBox(NULL, length, depth, height), DENSITY * length * depth * height, x, 0, z);
}

/* The wall is a running bond: every other course is shifted by half a brick and ends in halves, so that every brick
 * lies on two and none hangs over. These courses are also set back by a hundredth, because edges that lie on each other
 * cross in points that come and go. Bricks touch those above and below, but not those beside them. A tall wall is a
 * tenth of its height thick: if it were as thin as a low one, it would buckle under its own weight on contacts as soft
 * as ODE's defaults. */
void bench_build_wall(bench_world *w, int n)
{
    const double length = 0.4, height = 0.2, gap = 0.004;
    int courses = (int)ceil(sqrt(n / 1.7)), columns = (n + courses - 1) / courses;
    double depth = fmax(0.2, 0.1 * courses * height);
    dWorldSetCFM(w->ode, CFM);
    bench_add_ground(w, dCreatePlane(NULL, 0, 0, 1, 0));
    double stiffness = dWorldGetERP(w->ode) / (w->step * CFM), weight = 9.81 * DENSITY * length * depth * height;
    double top = 0, pitch = length + gap;
    for (int course = 0, laid = 0; laid < n; course++) {
        double pressed = (courses - course) * weight / ((course > 0 ? 8 : 4) * stiffness);
        double z = top - pressed + 0.5 * height;
        top = z + 0.5 * height;
        int bricks = columns + course % 2;
        for (int k = 0; k < bricks && laid < n; k++, laid++) {
            bool half = course % 2 && (k == 0 || k == columns);
            double x = (k - 0.5 * (course % 2)) * pitch, back = course % 2 ? 0.98 : 1;
            if (half)
                lay_brick(w, 0.5 * length - 0.5 * gap, back * depth, height,
                          k == 0 ? x + 0.25 * pitch : x - 0.25 * pitch, z);
            else
                lay_brick(w, length, back * depth, height, x, z);
        }
    }
}

/* Bodies of a pyramid whose courses have one box more than those above them lie on the gaps of the course below,
 * pressed in by what lies on them. Odd courses are set back, as in the wall. */
static void pile_pyramid(bench_world *w, int n, double gap)
{
    const double size = 0.25, mass = 1;
    dWorldSetCFM(w->ode, CFM);
    bench_add_ground(w, dCreatePlane(NULL, 0, 0, 1, 0));
    double stiffness = dWorldGetERP(w->ode) / (w->step * CFM), top = 0;
    int columns = (int)floor((sqrt(8.0 * n + 1) - 1) / 2);
    for (int course = 0, laid = 0; laid < n; course++) {
        int boxes = columns > course ? columns - course : 1;
        double z = top - 9.81 * mass * 0.5 * (boxes + 1) / ((course > 0 ? 8 : 4) * stiffness) + 0.5 * size;
        double depth = course % 2 ? 0.98 * size : size;
        top = z + 0.5 * size;
        for (int k = 0; k < boxes && laid < n; k++, laid++)
            bench_add_body(w, dCreateBox(NULL, size, depth, size), mass, (k - 0.5 * (boxes - 1)) * (size + gap), 0, z);
    }
}

void bench_build_pyramid(bench_world *w, int n)
{
    pile_pyramid(w, n, 0.004);
}

void bench_build_touching(bench_world *w, int n)
{
    pile_pyramid(w, n, 0);
}

/* Digs a pit without a lid, about twice as wide as its content is high. */
static double dig_pit(bench_world *w, int n, double size)
{
    double half = 0.5 * size * (1 + cbrt(4.0 * n));
    dWorldSetCFM(w->ode, CFM);
    bench_add_ground(w, dCreatePlane(NULL, 0, 0, 1, 0));
    bench_add_ground(w, dCreatePlane(NULL, 1, 0, 0, -half));
    bench_add_ground(w, dCreatePlane(NULL, -1, 0, 0, -half));
    bench_add_ground(w, dCreatePlane(NULL, 0, 1, 0, -half));
    bench_add_ground(w, dCreatePlane(NULL, 0, -1, 0, -half));
    return half;
}

/* Lets bodies fall in layers, each a little turned and shifted against the last. */
static void drop(bench_world *w, int n, double size, double half, dGeomID (*make)(int k))
{
    const double pitch = 1.3 * size;
    int side = (int)floor((2 * half - 0.3 * size) / pitch);
    if (side < 1) side = 1;
    for (int k = 0; k < n; k++) {
        int layer = k / (side * side), place = k % (side * side);
        double shift = 0.1 * size * sin(1.7 * layer);
        dBodyID body = bench_add_body(w, make(k), 1, (place % side - 0.5 * (side - 1)) * pitch + shift,
                                      (place / side - 0.5 * (side - 1)) * pitch - shift, (layer + 0.6) * pitch);
        dQuaternion turn;
        dQFromAxisAndAngle(turn, sin(k), cos(2.0 * k), sin(3.0 * k), 0.3);
        dBodySetQuaternion(body, turn);
    }
}

static dGeomID make_box(int k)
{
    return dCreateBox(NULL, 0.2 - 0.01 * (k % 3), 0.2 - 0.01 * (k % 5), 0.2 - 0.01 * (k % 7));
}

static dGeomID make_sphere(int k)
{
    return dCreateSphere(NULL, 0.1 - 0.005 * (k % 3));
}

void bench_build_boxes(bench_world *w, int n)
{
    drop(w, n, 0.2, dig_pit(w, n, 0.2), make_box);
}

void bench_build_spheres(bench_world *w, int n)
{
    drop(w, n, 0.2, dig_pit(w, n, 0.2), make_sphere);
}
