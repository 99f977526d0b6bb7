/* Static grasps for the tests: the paper's examples with the unit stiffness of the reference, and random ones. */
#ifndef TEST_GRASPS_H
#define TEST_GRASPS_H

#include "support/random.h"

#include <pinch/statics.h>

enum { GRASP_MAX_FINGERS = 12 };

typedef struct test_grasp {
    pinch_grasp grasp;
    pinch_finger fingers[GRASP_MAX_FINGERS];
} test_grasp;

/* number 1, 2, 3, 4, or 0 for Example 1b */
void grasp_paper(int number, test_grasp *g);

/*
 * 3 to 12 fingers of all models on a sphere, a box or a rough ellipsoid, mu 0.1 to 1.2, kn 1e2 to 1e6 N/m
 * with ratios of up to 1e4 between fingers, kt/kn 0.1 to 1, sizes 1 cm to 1 m, wrenches 0.01 to 100 N, some with force
 * control and force limits; one in eight planar.
 */
void grasp_random(pinch_random *random, test_grasp *g);

/* One more frame: tangent1 is the world axis least aligned with the normal, made perpendicular. */
void grasp_set_normal(pinch_finger *finger, double x, double y, double z);

#endif
