#ifndef PINCH_TEST_TIPS_H
#define PINCH_TEST_TIPS_H

#include "support/draw.h"

#include <pinch/fingertip.h>

/* Random fingertips with support functions of their own, and the least overlap of two by search: a reference that
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

/* Makes tip->tip and the geom; convexes are sheared prisms and bipyramids. */
void test_tip_make(pinch_random *random, pinch_tip_type type, test_tip *tip);
/* The geom of given data: tip->tip is filled in. */
void test_tip_make_geom(test_tip *tip);
/* The same at once; size as in pinch_tip. */
test_tip test_tip_of(pinch_tip_type type, double a, double b, double c, double skin);
void test_tip_free(test_tip *tip);
/* Puts the geom there and remembers it. R: row-major 3 x 3. */
void test_tip_place(test_tip *tip, const double position[3], const double R[9]);
extern const double TEST_TIP_UPRIGHT[9];

/* Puts both in random poses, b from where it would just touch by a part of that way between low and high. */
void test_tips_touch(pinch_random *random, test_tip *a, test_tip *b, double low, double high);
enum { TEST_TIP_CONTACTS = 16 };
int test_tips_collide(const test_tip *a, const test_tip *b, dContactGeom c[TEST_TIP_CONTACTS]);

/* Farthest reach of the body along d (unit, world), from the world's origin. */
double test_tip_reach(const test_tip *tip, const double d[3]);
/* h_a(-n) + h_b(n) */
double test_overlap(const test_tip *a, const test_tip *b, const double n[3]);
/* Looks for an overlap less than `target`: samples `samples` directions and searches on from the best `starts`. Returns
 * the least found, which is the least there is only as far as that decides on the target; its direction. */
double test_least_overlap(const test_tip *a, const test_tip *b, int samples, int starts, double target, double n[3]);

/* From n on in random directions, which a crease does not stop; slow. Returns the least overlap found, n its normal. */
double test_lower_overlap(const test_tip *a, const test_tip *b, double n[3]);

#endif
