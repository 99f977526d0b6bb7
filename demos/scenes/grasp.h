#ifndef PINCH_SCENE_GRASP_H
#define PINCH_SCENE_GRASP_H

#include "scene.h"

#include <pinch/statics.h>

/* The scene as a static grasp under the loads of the schedule's first entry, with every finger at its point with its
 * normal, before anything gives, and with what the object gives way
 * and its friction. `fingers` has room for finger_count of them, and the grasp then refers to it. The
 * environment plays no part. A slider that gravity acts on presses with its force and its weight. */
void scene_static_grasp(const scene *s, pinch_finger *fingers, pinch_grasp *grasp);

/* The same under what the schedule applies at `time` (s, >= 0): its loads, closings and forces as far as their ramps
 * have come, and the object carried along by the hand. */
void scene_static_grasp_at(const scene *s, double time, pinch_finger *fingers, pinch_grasp *grasp);

/* A finger whose path drive has moved it by then, so that it is not where the statics put it; NULL for none. */
const scene_finger *scene_finger_on_path(const scene *s, double time);

/* Reports each finger whose normal is not the surface's, in a text that begins with `before`, its name and `after`. */
void scene_report_normals(const scene *s, const char *before, const char *after,
                          void (*report)(void *context, const char *text), void *context);
/* Reports what a static grasp does not have of the scene, one text at a time. */
void scene_statics_leave_out(const scene *s, void (*report)(void *context, const char *text), void *context);

#endif
