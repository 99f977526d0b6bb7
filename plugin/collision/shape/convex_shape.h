/* Convex cores by their support functions, in their own axes. */
#ifndef PINCH_FINGERTIP_CORE_H
#define PINCH_FINGERTIP_CORE_H

#include <pinch/fingertip.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum pinch_core_kind {
    PINCH_CORE_POINT = 0,
    PINCH_CORE_SEGMENT,
    PINCH_CORE_TRIANGLE,
    PINCH_CORE_BOX,
    PINCH_CORE_HULL, /* up to here polytopes */
    PINCH_CORE_CYLINDER,
    PINCH_CORE_FLAT_CAPSULE,
    PINCH_CORE_ELLIPSOID,
    PINCH_CORE_SUPERELLIPSOID
} pinch_core_kind;

typedef struct pinch_core_edge {
    unsigned corner[2];
    unsigned face[2];
} pinch_core_edge;

/* A straight edge: a point on it, its direction (unit), and one arc of its outward normals, less than a half turn. */
typedef struct pinch_edge_arc {
    double v[3], u[3], n1[3], n2[3];
} pinch_edge_arc;

typedef struct pinch_core_face {
    const unsigned *polygon;  /* number of corners, their indices */
    const double *sides;      /* 4 per corner: unit vector across the border, outward; how far the face reaches */
    double offset;            /* how far the hull reaches along the face's normal */
    double centre[3], radius; /* of a ball around the face */
    double across2;           /* squared distance of two corners opposite */
} pinch_core_face;

/* What is found once of a hull; the arrays of `convex` belong to someone else. */
typedef struct pinch_core_hull {
    pinch_convex convex;
    void *memory; /* of all that follows */
    int edge_count;
    const pinch_core_edge *edges;
    const pinch_edge_arc *arcs; /* of the edges */
    const pinch_core_face *faces;
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
} pinch_core_hull;

typedef struct pinch_core {
    pinch_core_kind kind;
    double half[3];   /* box: half edges; segment, cylinder: [2] half the length; ellipsoids: semi-axes */
    double radius;    /* cylinder, flat capsule */
    double middle;    /* flat capsule: z of the cylinder's middle */
    double power[2];  /* superellipsoid: exponents of the dual norm, along z and around it */
    double skin;      /* m */
    double erosion;   /* radius of a ball that fits everywhere inside the core's surface: its least radius of
                       * curvature */
    double bound;     /* radius of a ball about the origin that holds core and skin */
    double corner[9]; /* triangle */
    const pinch_core_hull *hull;
} pinch_core;

static inline bool pinch_core_is_polytope(const pinch_core *core)
{
    return core->kind <= PINCH_CORE_HULL;
}

/* With a side at a radius around its axis. */
static inline bool pinch_core_is_round(const pinch_core *core)
{
    return core->kind == PINCH_CORE_CYLINDER || core->kind == PINCH_CORE_FLAT_CAPSULE;
}

/* Whether the end at that side along the axis (its sign) is a cap with a rim: both of a cylinder, a flat capsule's low
 * one. */
static inline bool pinch_core_has_rim(const pinch_core *core, double end)
{
    return core->kind == PINCH_CORE_CYLINDER || (core->kind == PINCH_CORE_FLAT_CAPSULE && end < 0);
}

/* How deep x is behind the hull's faces from `first` on (m; negative: in front of them). */
static inline void pinch_hull_depths(const pinch_core_hull *hull, const double x[3], int first, int count,
                                     double *restrict depth)
{
    const size_t faces = hull->convex.plane_count;
    const double *nx = hull->columns + first, *ny = nx + faces, *nz = ny + faces, *offset = nz + faces;
    const double px = x[0], py = x[1], pz = x[2];
    for (int f = 0; f < count; f++) depth[f] = offset[f] - (nx[f] * px + ny[f] * py + nz[f] * pz);
}

/* How far x, seen along the face's normal, is inside its border. */
double pinch_hull_face_room(const pinch_core_hull *hull, int face, const double x[3]);

/* A corner of the hull that is farthest along d. */
unsigned pinch_hull_farthest(const pinch_core_hull *hull, const double d[3]);

/* A point of the core farthest along d (not zero), and how far that is: h(d). */
void pinch_core_support(const pinch_core *core, const double d[3], double point[3]);
double pinch_core_reach(const pinch_core *core, const double d[3]);
/* The second derivative of h at the unit vector d, symmetric, row-major; on flat parts one-sided. */
void pinch_core_bend(const pinch_core *core, const double d[3], double H[9]);
/* Up to three unit directions that matter: faces' normals, axes. Count. */
int pinch_core_axes(const pinch_core *core, double axes[3][3]);

/* Face k of a box or hull. */
int pinch_core_face_count(const pinch_core *core);
void pinch_core_face_normal(const pinch_core *core, int face, double normal[3]);

/* A ball inside the core, about `centre`; 0 where none is known: the centre alone. */
double pinch_core_inner_ball(const pinch_core *core, double centre[3]);
/* Moves its centre towards x as far as a ball of that radius fits. */
void pinch_core_slide_ball(const pinch_core *core, const double x[3], double radius, double centre[3]);

/* Corner k of a polytope; count. */
int pinch_core_corner_count(const pinch_core *core);
void pinch_core_corner(const pinch_core *core, int k, double corner[3]);

#endif
