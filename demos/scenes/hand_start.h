#ifndef PINCH_SCENE_HAND_START_H
#define PINCH_SCENE_HAND_START_H

#include "hands/hand.h"

/* Closing the loops of a hand at the start. */

typedef enum scene_loops { SCENE_LOOPS_CLOSED = 0, SCENE_LOOPS_OPEN, SCENE_LOOPS_NO_MEMORY } scene_loops;

/* Moves the joints that are neither given nor coupled, as little as need be, so that the loops close; coupled joints
 * follow. *gap becomes the largest distance (m) between two anchors that should be one. */
scene_loops scene_close_loops(const hand *h, const bool *given, double *positions, double *gap);

#endif
