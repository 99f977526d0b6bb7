/* pinch bench collide: shallow contacts of two geoms by fingertip geometry and by ODE, beside ODE's own box-box. */
#include "bench.h"

#include "clock.h"
#include "json_output.h"

#include <jansson.h>
#include <math.h>
#include <ode/ode.h>
#include <pinch/fingertip.h>
#include <stdlib.h>

enum { PAIRS = 8, POSES = 500, ROUNDS = 41, CONTACTS = 8 };

typedef struct pair {
    const char *name;
    dGeomID upper, lower;
    dQuaternion turn[POSES];
    double height[POSES];
    double ours[ROUNDS], odes[ROUNDS]; /* s per pair */
} pair;

static const double OVERLAP = 1e-3; /* of geoms about 1 m large */

/* The upper geom at random angles, half of them nearly upright, its lowest point OVERLAP below the lower's top. */
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
        p->height[k] = lower[5] - upper[4] - OVERLAP;
    }
}

static double round_of(const pair *p, bool ours)
{
    dContactGeom c[CONTACTS];
    double spent = 0;
    for (int k = 0; k < POSES; k++) {
        dGeomSetQuaternion(p->upper, p->turn[k]);
        dGeomSetPosition(p->upper, 0.1, 0.05, p->height[k]);
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

static void make_pairs(pair *p)
{
    const char *names[PAIRS] = {"box-box",          "sphere-box",      "capsule-box",       "cylinder-box",
                                "capsule-cylinder", "sphere-cylinder", "cylinder-cylinder", "capsule-capsule"};
    for (int i = 0; i < PAIRS; i++) {
        p[i].name = names[i];
        p[i].lower = i < 4   ? dCreateBox(NULL, 1, 0.8, 0.6)
                     : i < 7 ? dCreateCylinder(NULL, 0.3, 0.6)
                             : dCreateCapsule(NULL, 0.3, 0.6);
    }
    p[0].upper = dCreateBox(NULL, 0.5, 0.4, 0.3);
    p[1].upper = dCreateSphere(NULL, 0.3);
    p[2].upper = dCreateCapsule(NULL, 0.15, 0.4);
    p[3].upper = dCreateCylinder(NULL, 0.15, 0.5);
    p[4].upper = dCreateCapsule(NULL, 0.15, 0.4);
    p[5].upper = dCreateSphere(NULL, 0.15);
    p[6].upper = dCreateCylinder(NULL, 0.15, 0.5);
    p[7].upper = dCreateCapsule(NULL, 0.15, 0.4);
}

static bool report(const options *o, pair *pairs)
{
    double box_box = median(pairs[0].odes);
    json_t *rows = json_array();
    if (!o->json && !o->quiet) printf("%-20s %10s %10s %22s\n", "pair", "Pinch ns", "ODE ns", "Pinch/ODE's box-box");
    for (int i = 0; i < PAIRS; i++) {
        double ours = median(pairs[i].ours), odes = median(pairs[i].odes);
        if (!o->json && !o->quiet)
            printf("%-20s %10.0f %10.0f %22.2f\n", pairs[i].name, 1e9 * ours, 1e9 * odes, ours / box_box);
        json_array_append_new(rows, json_pack("{s:s, s:f, s:f, s:f}", "pair", pairs[i].name, "time_s", ours,
                                              "ode_time_s", odes, "of_ode_box_box", ours / box_box));
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
    make_pairs(pairs);
    for (int i = 0; i < PAIRS; i++) draw_poses(&pairs[i]);
    for (int r = 0; r < ROUNDS; r++) /* taking turns: what slows the machine slows all */
        for (int i = 0; i < PAIRS; i++) {
            pairs[i].ours[r] = round_of(&pairs[i], true);
            pairs[i].odes[r] = round_of(&pairs[i], false);
        }
    bool good = report(o, pairs);
    for (int i = 0; i < PAIRS; i++) {
        dGeomDestroy(pairs[i].upper);
        dGeomDestroy(pairs[i].lower);
    }
    dCloseODE();
    free(pairs);
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}
