#ifndef PINCH_TEST_BOX_GRASP_H
#define PINCH_TEST_BOX_GRASP_H

#include "scenes/scene.h"

#include <stdint.h>

/* A random grasp of a box, as a scene. */

enum { BOX_GRASP_MOST_FINGERS = 6 };
#define BOX_GRASP_SIZE 0.05 /* m, the box's edge */

/*
 * Three to six round tips, hard or soft, close on a box in `slow` seconds. The wrench of the schedule's last entry then
 * grows until 3 `slow`, and 1.5 s of rest follow. A seed draws the same grasp for every kn: only the stiffness changes,
 * and the closing with it. The slip of a motion is wrong by the part of the ramp that one step takes, which must stay
 * below 1/kn.
 */
scene *box_grasp(uint64_t seed, double kn, double slow);

#endif
