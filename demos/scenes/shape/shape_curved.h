#ifndef PINCH_SCENE_SHAPE_CURVED_H
#define PINCH_SCENE_SHAPE_CURVED_H

#include "scenes/scene.h"

/* Flat capsules and superellipsoids, in their own axes about their centres of mass, as shape.h has it for all. */

/* Height (m) of the middle of a flat capsule's cylinder. */
double scene_flat_capsule_middle(const scene_shape *shape);
double scene_flat_capsule_radius(const scene_shape *shape); /* bounding radius, m */
double scene_flat_capsule_distance(const scene_shape *shape, const double point[3]);
bool scene_flat_capsule_points_in(const scene_shape *shape, const double point[3], const double direction[3],
                                  double tolerance);
void scene_flat_capsule_support(const scene_shape *shape, const double direction[3], double middle[3]);

double scene_superellipsoid_radius(const scene_shape *shape);
double scene_superellipsoid_distance(const scene_shape *shape, const double point[3]);
/* An outward normal, of any length, of the level surface through the point. */
void scene_superellipsoid_normal(const scene_shape *shape, const double point[3], double normal[3]);
void scene_superellipsoid_support(const scene_shape *shape, const double direction[3], double middle[3]);

#endif
