#ifndef PINCH_VIEW_TRIANGLES_H
#define PINCH_VIEW_TRIANGLES_H

#include "scenes/scene.h"

#include <stdint.h>

/* Surfaces as triangles, for pictures. Curved surfaces are as fine as a picture needs, with exact normals at their
 * vertices; hulls and boxes have a vertex for each corner of each face, so that their edges stay sharp. Triangles are
 * counter-clockwise seen from outside. */
typedef struct triangles {
    size_t vertex_count, vertex_room;
    float *positions, *normals; /* 3 per vertex: m, unit */
    size_t index_count, index_room;
    uint32_t *indices; /* 3 per triangle */
} triangles;

/* Adds the surface of a shape, placed by `pose` (m; quaternion). Returns false when memory runs out. */
bool triangles_add_shape(triangles *t, const scene_shape *shape, const double pose[7]);
/* An arrow from the origin along +y with length 1, of which `head` is the head's. */
bool triangles_add_arrow(triangles *t, double radius, double head, double head_radius);
/* A cone with its tip at the origin, its axis along +y, height 1 and base radius 1; without a base. */
bool triangles_add_cone(triangles *t);
void triangles_free(triangles *t);

#endif
