/*
 * pinch bench collide: contacts of two geoms by fingertip geometry and by ODE, where it has a collider, beside ODE's
 * own box-box. Shallow ones, inside a face and at its border, and some that are deep.
 */
#include "bench.h"

#include "clock.h"
#include "json_output.h"

#include <jansson.h>
#include <math.h>
#include <ode/ode.h>
#include <pinch/fingertip.h>
#include <stdlib.h>

enum { PAIRS = 17, POSES = 500, ROUNDS = 41, CONTACTS = 8 };

typedef struct pair {
    const char *name;
    dGeomID upper, lower;
    double overlap; /* m, of the bounding boxes */
    double aside;   /* m, of the upper geom along x from the lower one's middle */
    bool odes_too;
    dQuaternion turn[POSES];
    double height[POSES];
    double ours[ROUNDS], odes[ROUNDS]; /* s per pair */
} pair;

static const double SHALLOW = 1e-3, DEEP = 0.15; /* m, of geoms about 1 m large */

/* The upper geom at random angles, half of them nearly upright, its lowest point p->overlap below the lower's top. */
static void draw_poses(pair *p)
{
    dReal upper[6], lower[6];
    dGeomGetAABB(p->lower, lower);
    dGeomSetPosition(p->upper, 0, 0, 0);
    for (int k = 0; k < POSES; k++) {
        double length = 0, spread = k % 2 ? 1 : 1e-3;
        for (int i = 0; i < 4; i++) p->turn[k][i] = (i == 0 ? 1 : spread) * (dRandReal() - (i ? 0.5 : 0));
        for (int i = 0; i < 4; i++) length = hypot(length, p->turn[k][i]);
        for (int i = 0; i < 4; i++) p->turn[k][i] /= length;
        dGeomSetQuaternion(p->upper, p->turn[k]);
        dGeomGetAABB(p->upper, upper);
        p->height[k] = lower[5] - upper[4] - p->overlap;
    }
}

static double round_of(const pair *p, bool ours)
{
    dContactGeom c[CONTACTS];
    double spent = 0;
    for (int k = 0; k < POSES; k++) {
        dGeomSetQuaternion(p->upper, p->turn[k]);
        dGeomSetPosition(p->upper, p->aside, 0.05, p->height[k]);
        double start = clock_seconds();
        for (int again = 0; again < 4; again++) {
            if (ours)
                (void)pinch_tip_collide(p->upper, p->lower, CONTACTS, c, sizeof c[0]);
            else
                (void)dCollide(p->upper, p->lower, CONTACTS, c, sizeof c[0]);
        }
        spent += clock_seconds() - start;
    }
    return spent / (4 * POSES);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, by_value);
    return values[ROUNDS / 2];
}

static dGeomID ellipsoid(double a, double b, double c)
{
    dGeomID geom;
    pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
    tip.size[0] = a;
    tip.size[1] = b;
    tip.size[2] = c;
    return pinch_create_tip(NULL, &tip, &geom) == PINCH_OK ? geom : NULL;
}

/* b: box, s: sphere, c: capsule, y: cylinder, e: ellipsoid */
static dGeomID make_geom(char shape, bool lower)
{
    switch (shape) {
    case 'b':
        return lower ? dCreateBox(NULL, 1, 0.8, 0.6) : dCreateBox(NULL, 0.5, 0.4, 0.3);
    case 's':
        return dCreateSphere(NULL, 0.3);
    case 'S':
        return dCreateSphere(NULL, 0.15);
    case 'c':
        return lower ? dCreateCapsule(NULL, 0.3, 0.6) : dCreateCapsule(NULL, 0.15, 0.4);
    case 'y':
        return lower ? dCreateCylinder(NULL, 0.3, 0.6) : dCreateCylinder(NULL, 0.15, 0.5);
    default:
        return lower ? ellipsoid(0.5, 0.4, 0.3) : ellipsoid(0.2, 0.15, 0.25);
    }
}

/* false: no memory */
static bool make_pairs(pair *p)
{
    static const struct {
        const char *name, *shapes; /* upper, lower */
        bool deep;
        double aside; /* m; 0: well inside the lower geom's top */
    } rows[PAIRS] = {
        {"box-box", "bb", false, 0},
        {"sphere-box", "sb", false, 0},
        {"capsule-box", "cb", false, 0},
        {"cylinder-box", "yb", false, 0},
        {"capsule-cylinder", "cy", false, 0},
        {"sphere-cylinder", "Sy", false, 0},
        {"cylinder-cylinder", "yy", false, 0},
        {"capsule-capsule", "cc", false, 0},
        {"box-box, at an edge", "bb", false, 0.5},
        {"cylinder-box, at an edge", "yb", false, 0.5},
        {"cylinder-cylinder, rim", "yy", false, 0.3},
        {"ellipsoid-box", "eb", false, 0},
        {"ellipsoid-cylinder", "ey", false, 0},
        {"ellipsoid-ellipsoid", "ee", false, 0},
        {"box-box, deep", "bb", true, 0},
        {"cylinder-box, deep", "yb", true, 0},
        {"ellipsoid-ellipsoid, deep", "ee", true, 0},
    };
    for (int i = 0; i < PAIRS; i++) {
        p[i].name = rows[i].name;
        p[i].overlap = rows[i].deep ? DEEP : SHALLOW;
        p[i].aside = rows[i].aside > 0 ? rows[i].aside : 0.1;
        p[i].odes_too = rows[i].shapes[0] != 'e';
        p[i].upper = make_geom(rows[i].shapes[0], false);
        p[i].lower = make_geom(rows[i].shapes[1], true);
        if (!p[i].upper || !p[i].lower) return false;
    }
    return true;
}

static bool report(const options *o, pair *pairs)
{
    double box_box = median(pairs[0].odes);
    json_t *rows = json_array();
    if (!o->json && !o->quiet) printf("%-26s %10s %10s %22s\n", "pair", "Pinch ns", "ODE ns", "Pinch/ODE's box-box");
    for (int i = 0; i < PAIRS; i++) {
        double ours = median(pairs[i].ours), odes = pairs[i].odes_too ? median(pairs[i].odes) : NAN;
        if (!o->json && !o->quiet) {
            printf("%-26s %10.0f ", pairs[i].name, 1e9 * ours);
            if (pairs[i].odes_too)
                printf("%10.0f %22.2f\n", 1e9 * odes, ours / box_box);
            else
                printf("%10s %22.2f\n", "-", ours / box_box);
        }
        json_array_append_new(rows, json_pack("{s:s, s:f, s:o, s:f}", "pair", pairs[i].name, "time_s", ours,
                                              "ode_time_s", pairs[i].odes_too ? json_real(odes) : json_null(),
                                              "of_ode_box_box", ours / box_box));
    }
    json_t *document = json_pack("{s:s, s:s, s:o}", "command", "bench", "benchmark", "collide", "rows", rows);
    if (document && o->json) json_print(document, stdout);
    json_decref(document);
    return document != NULL;
}

command_status bench_collide(const options *o)
{
    pair *pairs = calloc(PAIRS, sizeof *pairs);
    if (!pairs) return COMMAND_SYSTEM;
    dInitODE2(0);
    dRandSetSeed(1);
    bool good = make_pairs(pairs);
    for (int i = 0; i < PAIRS && good; i++) draw_poses(&pairs[i]);
    for (int r = 0; r < ROUNDS && good; r++) /* taking turns: what slows the machine slows all */
        for (int i = 0; i < PAIRS; i++) {
            pairs[i].ours[r] = round_of(&pairs[i], true);
            if (pairs[i].odes_too) pairs[i].odes[r] = round_of(&pairs[i], false);
        }
    good = good && report(o, pairs);
    for (int i = 0; i < PAIRS; i++) {
        if (pairs[i].upper) dGeomDestroy(pairs[i].upper);
        if (pairs[i].lower) dGeomDestroy(pairs[i].lower);
    }
    dCloseODE();
    pinch_close_tips();
    free(pairs);
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}
