#ifndef PINCH_TEST_TIPS_H
#define PINCH_TEST_TIPS_H

#include "support/draw.h"

#include <pinch/fingertip.h>

/* Random fingertips with support functions of their own, and the least overlap of two tips by search. This reference
 * shares nothing with the plugin. */
typedef struct test_tip {
    pinch_tip tip;
    dGeomID geom;
    pinch_convex convex;
    double points[64 * 3], planes[64 * 4];
    unsigned polygons[512];
    double position[3], R[9]; /* of the geom, world */
    double size;              /* radius of a bounding ball, roughly */
} test_tip;

/* Makes a random tip and its geom; convexes are sheared prisms and bipyramids. */
void test_tip_make(pinch_random *random, pinch_tip_type type, test_tip *tip);
/* Makes the geom of a tip whose tip->tip is filled in. */
void test_tip_make_geom(test_tip *tip);
/* Makes a tip of this size, in the order of pinch_tip.size, and its geom. */
test_tip test_tip_of(pinch_tip_type type, double a, double b, double c, double skin);
void test_tip_free(test_tip *tip);
/* Puts the geom there and remembers the pose. R is a row-major 3 x 3 matrix. */
void test_tip_place(test_tip *tip, const double position[3], const double R[9]);
extern const double TEST_TIP_UPRIGHT[9];

/* Puts both in random poses. b lies in a random direction from a, at a part between `low` and `high` of the distance at
 * which the two would just touch along it. */
void test_tips_touch(pinch_random *random, test_tip *a, test_tip *b, double low, double high);
enum { TEST_TIP_CONTACTS = 16 };
int test_tips_collide(const test_tip *a, const test_tip *b, dContactGeom c[TEST_TIP_CONTACTS]);

/* The support function: how far the tip reaches along the unit vector d, from the world's origin. */
double test_tip_reach(const test_tip *tip, const double d[3]);
/* How far the tips overlap along n: the sum of a's support along -n and b's along n. */
double test_overlap(const test_tip *a, const test_tip *b, const double n[3]);
/* Looks for an overlap less than `target`: it samples `samples` directions and searches on from the best `starts`.
 * Returns the least overlap found, and its direction in n. It goes on only until it knows on which side of the target
 * the least overlap lies. */
double test_least_overlap(const test_tip *a, const test_tip *b, int samples, int starts, double target, double n[3]);

/* Searches on from n by random steps, which a crease does not stop; this is slow. Returns the least overlap found, and
 * its direction in n. */
double test_lower_overlap(const test_tip *a, const test_tip *b, double n[3]);

#endif
