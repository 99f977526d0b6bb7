#ifndef PINCH_SCENE_SHAPE_H
#define PINCH_SCENE_SHAPE_H

#include "scenes/scene.h"

#include <pinch/fingertip.h>

/* Geometry of a scene_shape. Points and directions are in the shape's own axes, about its centre of mass. */

typedef enum scene_shape_fault {
    SCENE_SHAPE_FINE = 0,
    SCENE_SHAPE_FLAT,         /* the vertices span no volume */
    SCENE_SHAPE_NOT_CONVEX,   /* a prism's corners are not strictly convex */
    SCENE_SHAPE_CLOCKWISE,    /* a prism's corners run clockwise */
    SCENE_SHAPE_BAD_FILE,     /* a mesh that cannot be read, or whose pieces overlap */
    SCENE_SHAPE_OUT_OF_RANGE, /* volume or inertia is no positive finite double */
    SCENE_SHAPE_OUT_OF_MEMORY
} scene_shape_fault;

/* Fills in what follows from type and dimensions: hull, shift, bounding radius, volume, unit inertia. Recentres the
 * vertices of convex and prism. Call it once; for meshes call scene_shape_load_mesh. */
scene_shape_fault scene_shape_complete(scene_shape *shape);
/* mesh.c: the same for a mesh, from u.mesh.file. `error` (256 bytes) says what is wrong with the file. */
scene_shape_fault scene_shape_load_mesh(scene_shape *shape, char *error);
void scene_shape_free(scene_shape *shape);

/* A direction closer than this (rad) to the normal of a face or edge has that face or edge as its support. */
static const double SCENE_SUPPORT_TIE = 1e-9;

/* Signed distance (m) to the surface: positive outside. */
double scene_shape_distance(const scene_shape *shape, const double point[3]);

/* Finds the surface point nearest to `point`. Returns false where none is found to be within `tolerance` (m) of the
 * surface, as for the centre of a ball, from which all ways are the same. */
bool scene_shape_nearest(const scene_shape *shape, const double point[3], double tolerance, double nearest[3]);

/* Does `direction` point into the shape at a surface point? At an edge or corner it is enough to point into one of the
 * faces that meet there. Faces within `tolerance` (m) count as meeting there. */
bool scene_shape_points_in(const scene_shape *shape, const double point[3], const double direction[3],
                           double tolerance);

/* The middle of the feature (corner, edge, face) that lies farthest along the unit vector `direction`. */
void scene_shape_support(const scene_shape *shape, const double direction[3], double middle[3]);

/* hull.c: the same for a hull. `radius` (m) is its size. */
double scene_hull_distance(const scene_hull *hull, const double point[3]);
bool scene_hull_points_in(const scene_hull *hull, const double point[3], const double direction[3], double tolerance);
void scene_hull_support(const scene_hull *hull, double radius, const double direction[3], double middle[3]);

/* hull.c: the convex hull of `count` points, as a fault of shapes. */
scene_shape_fault scene_hull_of_points(const double *points, size_t count, scene_hull *hull);
/* The hull of a prism. Corners that are not strictly convex and counter-clockwise are refused. */
scene_shape_fault scene_hull_of_prism(const double *corners, size_t count, double height, scene_hull *hull);

/* shape.c: the shape as a fingertip of Pinch's collision detection. Returns false for shapes with vertices. */
bool scene_shape_tip(const scene_shape *shape, pinch_tip *tip);

/* curved.c: flat capsules and superellipsoids, in their own axes about their centres of mass. */

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
