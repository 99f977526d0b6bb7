#ifndef TEST_BOX_GRASP_H
#define TEST_BOX_GRASP_H

#include "scenes/scene.h"

#include <stdint.h>

enum { BOX_GRASP_MOST_FINGERS = 6 };
#define BOX_GRASP_SIZE 0.05 /* m, the box's edge */

/*
 * A box held by 3 to 6 round tips, hard or soft, that close in `slow` seconds and then, until 3 `slow`, get the wrench
 * of the schedule's last entry; 1.5 s of rest follow. The same draws for every kn: only stiffness, and closing with it,
 * scale. A motion's slip is wrong by the part of the ramp that a step takes, which must stay below 1/kn.
 */
scene *box_grasp(uint64_t seed, double kn, double slow);

#endif
