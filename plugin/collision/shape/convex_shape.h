#ifndef PINCH_COLLISION_CONVEX_SHAPE_H
#define PINCH_COLLISION_CONVEX_SHAPE_H

#include "hull.h"

/* Convex cores by their support functions, in their own axes. */

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

/* The core of a tip (of piece `piece`, whose hull is given). */
pinch_core pinch_core_of_tip(const pinch_tip *tip, const pinch_core_hull *hull);
pinch_core pinch_core_of_triangle(const double corners[9]);

#endif
