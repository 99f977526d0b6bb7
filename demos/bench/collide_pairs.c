#include "collide_pairs.h"

#include <math.h>
#include <pinch/fingertip.h>
#include <string.h>

static const double TOUCHING = 1e-6, SHALLOW = 1e-3, DEEP = 0.15; /* m */

const collide_case collide_cases[COLLIDE_CASES] = {
    {"shallow", COLLIDE_TUMBLED, SHALLOW, false, false},
    {"touching", COLLIDE_TUMBLED, TOUCHING, false, false},
    {"deep", COLLIDE_TUMBLED, DEEP, false, false},
    {"at the border", COLLIDE_TUMBLED, SHALLOW, true, false},
    {"deep at the border", COLLIDE_TUMBLED, DEEP, true, false},
    {"standing", COLLIDE_UPRIGHT, SHALLOW, false, false},
    {"standing over the border", COLLIDE_UPRIGHT, SHALLOW, true, false},
    {"lying", COLLIDE_LYING, SHALLOW, false, false},
    {"both lying", COLLIDE_LYING, SHALLOW, false, true},
};

static dGeomID ellipsoid(double a, double b, double c)
{
    dGeomID geom;
    pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
    tip.size[0] = a;
    tip.size[1] = b;
    tip.size[2] = c;
    return pinch_create_tip(NULL, &tip, &geom) == PINCH_OK ? geom : NULL;
}

/* A prism over a regular hexagon. dCreateConvex keeps the arrays. */
enum { SIDES = 6 };
typedef struct prism {
    double planes[4 * (SIDES + 2)], points[6 * SIDES];
    unsigned polygons[5 * SIDES + 2 * (SIDES + 1)];
} prism;

static prism small_prism, large_prism;

static dGeomID convex(prism *p, double radius, double height)
{
    static const double TURN = 1.0471975511965976; /* rad */
    unsigned *polygon = p->polygons;
    double *plane = p->planes;
    memset(p, 0, sizeof *p);
    for (unsigned k = 0; k < 2 * SIDES; k++) {
        double *x = p->points + 3 * k;
        x[0] = radius * cos(TURN * k);
        x[1] = radius * sin(TURN * k);
        x[2] = k < SIDES ? -0.5 * height : 0.5 * height;
    }
    for (unsigned k = 0; k < SIDES; k++, plane += 4) {
        const unsigned next = (k + 1) % SIDES, corners[5] = {4, k, next, SIDES + next, SIDES + k};
        memcpy(polygon, corners, sizeof corners);
        polygon += 5;
        plane[0] = cos(TURN * (k + 0.5));
        plane[1] = sin(TURN * (k + 0.5));
        plane[3] = radius * cos(0.5 * TURN);
    }
    for (unsigned top = 0; top < 2; top++, plane += 4) {
        *polygon++ = SIDES;
        for (unsigned k = 0; k < SIDES; k++) *polygon++ = top ? SIDES + k : SIDES - 1 - k;
        plane[2] = top ? 1 : -1;
        plane[3] = 0.5 * height;
    }
    const pinch_convex known = {p->planes, SIDES + 2, p->points, p->polygons, 2 * SIDES};
    dGeomID geom = dCreateConvex(NULL, p->planes, SIDES + 2, p->points, 2 * SIDES, p->polygons);
    return pinch_tip_know_convex(geom, &known) == PINCH_OK ? geom : NULL;
}

static dGeomID make_geom(char shape, bool lower)
{
    switch (shape) {
    case 'b':
        return lower ? dCreateBox(NULL, 1, 0.8, 0.6) : dCreateBox(NULL, 0.5, 0.4, 0.3);
    case 's':
        return dCreateSphere(NULL, lower ? 0.3 : 0.15);
    case 'c':
        return lower ? dCreateCapsule(NULL, 0.3, 0.6) : dCreateCapsule(NULL, 0.15, 0.4);
    case 'y':
        return lower ? dCreateCylinder(NULL, 0.3, 0.6) : dCreateCylinder(NULL, 0.15, 0.5);
    case 'v':
        return lower ? convex(&large_prism, 0.5, 0.6) : convex(&small_prism, 0.2, 0.3);
    case 'p':
        return dCreatePlane(NULL, 0, 0, 1, 0);
    default:
        return lower ? ellipsoid(0.5, 0.4, 0.3) : ellipsoid(0.2, 0.15, 0.25);
    }
}

/* How far the border of a lower geom's top is from its axis, along x. */
static double border_of(char shape)
{
    return shape == 'b' ? 0.5 : shape == 'v' ? 0.47 : shape == 'y' ? 0.3 : 0;
}

bool collide_make_pairs(collide_pair pairs[COLLIDE_PAIRS])
{
    static const struct {
        const char *name, shapes[3]; /* upper, lower: b box, s sphere, c capsule, y cylinder, v convex, p plane,
                                      * e ellipsoid */
    } rows[COLLIDE_PAIRS] = {
        {"box-box", "bb"},
        {"sphere-sphere", "ss"},
        {"sphere-box", "sb"},
        {"sphere-capsule", "sc"},
        {"sphere-cylinder", "sy"},
        {"sphere-convex", "sv"},
        {"sphere-plane", "sp"},
        {"capsule-box", "cb"},
        {"capsule-capsule", "cc"},
        {"capsule-cylinder", "cy"},
        {"capsule-convex", "cv"},
        {"capsule-plane", "cp"},
        {"box-convex", "bv"},
        {"box-plane", "bp"},
        {"cylinder-box", "yb"},
        {"cylinder-cylinder", "yy"},
        {"cylinder-convex", "yv"},
        {"cylinder-plane", "yp"},
        {"convex-convex", "vv"},
        {"convex-plane", "vp"},
        {"ellipsoid-box", "eb"},
        {"ellipsoid-cylinder", "ey"},
        {"ellipsoid-ellipsoid", "ee"},
    };
    for (int i = 0; i < COLLIDE_PAIRS; i++) {
        char upper = rows[i].shapes[0], lower = rows[i].shapes[1];
        pairs[i].name = rows[i].name;
        pairs[i].odes_too = upper != 'e';
        pairs[i].upper = make_geom(upper, false);
        pairs[i].lower = make_geom(lower, true);
        pairs[i].border = border_of(lower);
        pairs[i].has_turns = upper != 's' && upper != 'e';
        pairs[i].lower_turns = lower == 'y' || lower == 'c';
        if (!pairs[i].upper || !pairs[i].lower) return false;
    }
    return true;
}

void collide_free_pairs(collide_pair pairs[COLLIDE_PAIRS])
{
    for (int i = 0; i < COLLIDE_PAIRS; i++) {
        if (pairs[i].upper) dGeomDestroy(pairs[i].upper);
        if (pairs[i].lower) dGeomDestroy(pairs[i].lower);
    }
}

bool collide_has_case(const collide_pair *pair, const collide_case *c)
{
    if (!pair->odes_too && (c->border || c->turn != COLLIDE_TUMBLED)) return false;
    return (c->turn == COLLIDE_TUMBLED || pair->has_turns) && (!c->border || pair->border > 0) &&
           (!c->lower_lying || pair->lower_turns);
}

static void draw_turn(collide_turn turn, bool loose, double *q)
{
    dQuaternion about, level;
    double length = 0, spread = loose ? 1 : 1e-3;
    dQFromAxisAndAngle(about, 0, 0, 1, 2 * M_PI * dRandReal());
    dQFromAxisAndAngle(level, 0, 1, 0, 0.5 * M_PI);
    switch (turn) {
    case COLLIDE_UPRIGHT:
        memcpy(q, about, sizeof about);
        return;
    case COLLIDE_LYING:
        dQMultiply0(q, about, level);
        return;
    default:
        for (int i = 0; i < 4; i++) q[i] = (i == 0 ? 1 : spread) * (dRandReal() - (i ? 0.5 : 0));
        for (int i = 0; i < 4; i++) length = hypot(length, q[i]);
        for (int i = 0; i < 4; i++) q[i] /= length;
    }
}

void collide_set_lower(collide_pair *pair, const collide_case *c)
{
    dMatrix3 R;
    if (dGeomGetClass(pair->lower) == dPlaneClass) return;
    dRFromAxisAndAngle(R, 1, 0, 0, c->lower_lying ? 0.5 * M_PI : 0);
    dGeomSetRotation(pair->lower, R);
}

void collide_draw_poses(collide_pair *pair, const collide_case *c, collide_pose poses[COLLIDE_POSES])
{
    dReal upper[6], lower[6] = {0, 0, 0, 0, 0, 0};
    bool dome = pair->border == 0 && dGeomGetClass(pair->lower) != dPlaneClass;
    if (dGeomGetClass(pair->lower) != dPlaneClass) dGeomGetAABB(pair->lower, lower);
    dGeomSetPosition(pair->upper, 0, 0, 0);
    for (int k = 0; k < COLLIDE_POSES; k++) {
        draw_turn(c->turn, k % 2, poses[k].turn);
        dGeomSetQuaternion(pair->upper, poses[k].turn);
        dGeomGetAABB(pair->upper, upper);
        poses[k].x = c->border ? pair->border : dome || c->lower_lying ? 0 : 0.1;
        poses[k].y = dome && !c->lower_lying ? 0 : 0.05;
        poses[k].z = lower[5] - upper[4] - c->overlap;
    }
}
