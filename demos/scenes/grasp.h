#ifndef PINCH_SCENE_GRASP_H
#define PINCH_SCENE_GRASP_H

#include "scene.h"

#include <pinch/statics.h>

/* The scene as a static grasp under the loads of the schedule's first entry, with every finger at its point with its
 * normal, before anything gives. `fingers` has room for finger_count of them, and the grasp then refers to it. The
 * environment plays no part. */
void scene_static_grasp(const scene *s, pinch_finger *fingers, pinch_grasp *grasp);

#endif
