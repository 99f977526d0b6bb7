#ifndef PINCH_TEST_GRASPS_H
#define PINCH_TEST_GRASPS_H

#include "support/random.h"

#include <pinch/statics.h>

/* Static grasps: the paper's examples with the unit stiffness of the reference, and random grasps. */

enum { GRASP_MAX_FINGERS = 12 };

typedef struct test_grasp {
    pinch_grasp grasp;
    pinch_finger fingers[GRASP_MAX_FINGERS];
} test_grasp;

/* Makes Example 1, 2, 3 or 4; number 0 is Example 1b. */
void grasp_paper(int number, test_grasp *g);

/*
 * Puts 3 to 12 fingers of all models on a sphere, a box or a rough ellipsoid. Ranges: mu 0.1 to 1.2, kn 1e2 to 1e6 N/m
 * with ratios of up to 1e4 between fingers, kt/kn 0.1 to 1, sizes 1 cm to 1 m, wrenches 0.01 to 100 N. Some fingers
 * have force control or a force limit, and one grasp in eight is planar.
 */
void grasp_random(pinch_random *random, test_grasp *g);

/* Sets the normal, and tangent1 to the world axis that is least aligned with it, made perpendicular. */
void grasp_set_normal(pinch_finger *finger, double x, double y, double z);

#endif
