/* What is found once of a convex polyhedron. */
#ifndef PINCH_COLLISION_HULL_H
#define PINCH_COLLISION_HULL_H

#include <pinch/fingertip.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct pinch_hull_edge {
    unsigned corner[2];
    unsigned face[2];
} pinch_hull_edge;

/* A straight edge: a point on it, its direction (unit), and one arc of its outward normals, less than a half turn. */
typedef struct pinch_edge_arc {
    double v[3], u[3], n1[3], n2[3];
} pinch_edge_arc;

typedef struct pinch_hull_face {
    const unsigned *polygon;  /* number of corners, their indices */
    const double *sides;      /* 4 per corner: unit vector across the border, outward; how far the face reaches */
    double offset;            /* how far the hull reaches along the face's normal */
    double centre[3], radius; /* of a ball around the face */
    double across2;           /* squared distance of two corners opposite */
} pinch_hull_face;

/* What is found once of a hull; the arrays of `convex` belong to someone else. */
typedef struct pinch_hull {
    pinch_convex convex;
    void *memory; /* of all that follows */
    int edge_count;
    const pinch_hull_edge *edges;
    const pinch_edge_arc *arcs; /* of the edges */
    const pinch_hull_face *faces;
    const unsigned *neighbours_at; /* of corner k: neighbours[neighbours_at[k]] up to before [neighbours_at[k + 1]] */
    const unsigned *neighbours;    /* corners at the other ends of its edges */
    const unsigned *faces_at; /* of corner k: corner_faces[faces_at[k]] up to before [faces_at[k + 1]], ascending */
    const unsigned *corner_faces;
    const double *columns;                           /* of all faces: the normals' x, y and z, and the offsets */
    const double *corners;                           /* of all corners: x, y and z */
    const uint64_t *edges_of_face, *corners_of_face; /* a bit for each; NULL: a hull with more than 64 of anything */
    double outer;                                    /* radius of the ball about the origin that holds it */
    double centre[3];                                /* a point inside */
    double inner;                                    /* radius of a ball about it inside the hull */
} pinch_hull;

/* False: out of memory, or faces that do not close. The arrays of `convex` must outlive the hull. */
bool pinch_hull_of_convex(const pinch_convex *convex, pinch_hull *hull);
/* Frees what was found of it. */
void pinch_hull_free(pinch_hull *hull);

/* How deep x is behind the hull's faces from `first` on (m; negative: in front of them). */
static inline void pinch_hull_depths(const pinch_hull *hull, const double x[3], int first, int count,
                                     double *restrict depth)
{
    const size_t faces = hull->convex.plane_count;
    const double *nx = hull->columns + first, *ny = nx + faces, *nz = ny + faces, *offset = nz + faces;
    const double px = x[0], py = x[1], pz = x[2];
    for (int f = 0; f < count; f++) depth[f] = offset[f] - (nx[f] * px + ny[f] * py + nz[f] * pz);
}

/* How far x, seen along the face's normal, is inside its border. */
double pinch_hull_border_distance(const pinch_hull *hull, int face, const double x[3]);

/* A corner of the hull that is farthest along d. */
unsigned pinch_hull_support_vertex(const pinch_hull *hull, const double d[3]);

#endif
