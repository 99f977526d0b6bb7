#ifndef PINCH_MESHES_HULL_H
#define PINCH_MESHES_HULL_H

#include <stdbool.h>
#include <stddef.h>

/* A convex polyhedron, laid out as ODE's dCreateConvex takes it. */
typedef struct mesh_hull {
    size_t vertex_count; /* >= 4; corners only: points inside the hull are not kept here */
    double *vertices;    /* 3 per vertex (m) */
    size_t face_count;   /* >= 4; coplanar triangles are merged into one face */
    double *planes;     /* 4 per face: unit outward normal, offset (m): n.x = offset on the face, n.x < offset inside */
    unsigned *polygons; /* per face: number of corners, then their indices, counter-clockwise seen from outside */
    size_t polygons_length;
} mesh_hull;

typedef enum mesh_hull_fault {
    MESH_HULL_FINE = 0,
    MESH_HULL_FLAT, /* the points span no volume */
    MESH_HULL_NO_MEMORY
} mesh_hull_fault;

/* The convex hull of `count` points. Corners keep the order of the points. Coplanar triangles become one face. */
mesh_hull_fault mesh_hull_of_points(const double *points, size_t count, mesh_hull *hull);
void mesh_hull_free(mesh_hull *hull);
/* Exact volume, centre of mass, and second moments (integral of x x^T, row-major) about the origin at density 1. */
void mesh_hull_moments(const mesh_hull *hull, double *volume, double centre[3], double second[9]);
/* Moves the hull by -shift. */
void mesh_hull_recentre(mesh_hull *hull, const double shift[3]);

/* Do two hulls share more than a layer of this thickness (m)? Hulls that only touch do not. */
bool mesh_hulls_overlap(const mesh_hull *a, const mesh_hull *b, double layer);

/* For hulls that are built face by face: room for them (false: out of memory), and the plane of a face from its
 * corners, whose vertices have been set. */
bool mesh_hull_allocate(mesh_hull *hull, size_t vertices, size_t faces, size_t polygons);
void mesh_hull_set_plane(mesh_hull *hull, size_t face, const unsigned *corners, unsigned count);

#endif
