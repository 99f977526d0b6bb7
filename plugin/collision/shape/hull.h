/* A convex polyhedron with all that is computed from it once. */
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

/* A straight edge is given by a point on it and its unit direction. Its outward normals form an arc on the Gauss
 * sphere, from n1 to n2 by less than a half turn. */
typedef struct pinch_edge_arc {
    double v[3], u[3], n1[3], n2[3];
} pinch_edge_arc;

typedef struct pinch_hull_face {
    const unsigned *polygon;  /* the number of corners, then their indices */
    const double *sides;      /* 4 per side: the unit vector across the border, outward; the face's extent along it */
    double offset;            /* how far the hull extends along the face's normal */
    double centre[3], radius; /* a ball around the face */
    double across2;           /* squared distance of two opposite corners */
} pinch_hull_face;

/* A box that holds the vertices from place `first` to before `last` in the order of the tree. */
typedef struct pinch_hull_node {
    double ends[3][2]; /* low and high */
    unsigned first, last;
    unsigned lowest; /* the least number of these vertices */
} pinch_hull_node;

typedef struct pinch_hull_corner {
    double x[3];
    unsigned index;
} pinch_hull_corner;

/* The vertices in boxes that are halved again and again. Node k holds the nodes 2 k + 1 and 2 k + 2, and the last
 * `leaves` nodes hold vertices. Only large hulls have a tree; in others `leaves` is 0. */
typedef struct pinch_hull_tree {
    void *memory; /* holds all arrays below */
    unsigned leaves;
    const pinch_hull_node *nodes;
    const pinch_hull_corner *corners; /* all vertices in the order of the tree */
    const unsigned *near;             /* the farthest vertex along the middle of each cell of directions */
} pinch_hull_tree;

/* The arrays of `convex` belong to someone else. */
typedef struct pinch_hull {
    pinch_convex convex;
    void *memory; /* holds all arrays below */
    int edge_count;
    const pinch_hull_edge *edges;
    const pinch_edge_arc *arcs; /* one per edge */
    const pinch_hull_face *faces;
    const unsigned *neighbours_at; /* vertex k has the neighbours from [neighbours_at[k]] on */
    const unsigned *neighbours;    /* vertices at the other ends of its edges */
    const unsigned *faces_at;      /* vertex k has the faces from [faces_at[k]] on, ascending */
    const unsigned *corner_faces;
    const double *columns; /* all faces' normals and offsets as four columns: x, y, z, offset */
    const double *corners; /* all vertices as three columns: x, y, z */
    const uint64_t *edges_of_face, *corners_of_face; /* one bit each; NULL in large hulls */
    const uint64_t *loose_faces;                     /* one bit each, see hull.c */
    pinch_hull_tree tree;
    double outer;     /* radius of the ball about the origin that holds the hull */
    double centre[3]; /* a point inside */
    double inner;     /* radius of a ball about `centre` inside the hull */
} pinch_hull;

/* Returns false when memory runs out or the faces do not close. The arrays of `convex` must outlive the hull. */
bool pinch_hull_of_convex(const pinch_convex *convex, pinch_hull *hull);
/* Frees what was computed, but not the arrays of `convex`. */
void pinch_hull_free(pinch_hull *hull);

/* Writes how deep x lies behind `count` faces from `first` on (m; negative in front of them). */
static inline void pinch_hull_depths(const pinch_hull *hull, const double x[3], int first, int count,
                                     double *restrict depth)
{
    const size_t faces = hull->convex.plane_count;
    const double *nx = hull->columns + first, *ny = nx + faces, *nz = ny + faces, *offset = nz + faces;
    const double px = x[0], py = x[1], pz = x[2];
    for (int f = 0; f < count; f++) depth[f] = offset[f] - (nx[f] * px + ny[f] * py + nz[f] * pz);
}

/* Returns how far x, seen along the face's normal, lies inside the face's border. */
double pinch_hull_border_distance(const pinch_hull *hull, int face, const double x[3]);

/* Returns the vertex that is farthest along d, the first of those that are as far, after a look at all of them. */
unsigned pinch_hull_scan_vertices(const pinch_hull *hull, const double d[3]);

/* The tree of a large hull. Building it returns false when memory runs out. It finds the same vertex as a scan does.
 * The near vertex takes far less time to find and is nearly as far along d. */
bool pinch_hull_build_tree(pinch_hull *hull);
void pinch_hull_free_tree(pinch_hull *hull);
unsigned pinch_hull_tree_vertex(const pinch_hull *hull, const double d[3]);
unsigned pinch_hull_near_vertex(const pinch_hull *hull, const double d[3]);

/* Finds the same vertex in the way that is faster. */
static inline unsigned pinch_hull_support_vertex(const pinch_hull *hull, const double d[3])
{
    return hull->tree.leaves ? pinch_hull_tree_vertex(hull, d) : pinch_hull_scan_vertices(hull, d);
}

#endif
