#ifndef PINCH_SCENE_GRASP_H
#define PINCH_SCENE_GRASP_H

#include "scene.h"

#include <pinch/statics.h>

/*
 * The scene as a static grasp: the loads of the schedule's first entry, every finger at its point with its normal, from
 * the undeformed pose. fingers: finger_count of them, which the grasp then refers to. The environment plays no part.
 */
void scene_static_grasp(const scene *s, pinch_finger *fingers, pinch_grasp *grasp);

#endif
