/* Convex cores by their support functions, in their own axes; and a pair of them in the axes of the first. */
#ifndef PINCH_FINGERTIP_CORE_H
#define PINCH_FINGERTIP_CORE_H

#include <pinch/fingertip.h>

#include <stdbool.h>

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

/* A hull's edges, found once; the arrays of `convex` belong to someone else. */
typedef struct pinch_core_hull {
    pinch_convex convex;
    int edge_count;
    const pinch_core_edge *edges;
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

/* The core of a tip (of piece `piece`, whose hull is given). */
pinch_core pinch_core_of_tip(const pinch_tip *tip, const pinch_core_hull *hull);
pinch_core pinch_core_of_triangle(const double corners[9]);

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

/* Corner k of a polytope; count. */
int pinch_core_corner_count(const pinch_core *core);
void pinch_core_corner(const pinch_core *core, int k, double corner[3]);

/* B's point x is R x + p in A's axes. Contact normals point into A: a is A's support along -n, b is B's along n. */
typedef struct pinch_core_pair {
    const pinch_core *a, *b;
    double R[9], p[3];
} pinch_core_pair;

static inline void pinch_pair_turn(const pinch_core_pair *pair, const double v[3], double out[3])
{
    const double *R = pair->R;
    for (int i = 0; i < 3; i++) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static inline void pinch_pair_turn_back(const pinch_core_pair *pair, const double v[3], double out[3])
{
    const double *R = pair->R;
    for (int i = 0; i < 3; i++) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

void pinch_pair_support_a(const pinch_core_pair *pair, const double n[3], double a[3]);
void pinch_pair_support_b(const pinch_core_pair *pair, const double n[3], double b[3]);
/* h_A(-n) + h_B(n): the overlap of the cores along the unit vector n, skins left out. */
double pinch_pair_overlap(const pinch_core_pair *pair, const double n[3]);
/* Both cores' second derivatives at n, in A's axes. */
void pinch_pair_bend(const pinch_core_pair *pair, const double n[3], double H[9]);

#endif
