#ifndef PINCH_COLLISION_CONVEX_SHAPE_H
#define PINCH_COLLISION_CONVEX_SHAPE_H

#include "hull.h"

/* Convex shapes by their support functions, in their own axes. */

typedef enum pinch_shape_kind {
    PINCH_SHAPE_POINT = 0,
    PINCH_SHAPE_SEGMENT,
    PINCH_SHAPE_TRIANGLE,
    PINCH_SHAPE_BOX,
    PINCH_SHAPE_HULL, /* up to here polytopes */
    PINCH_SHAPE_CYLINDER,
    PINCH_SHAPE_FLAT_CAPSULE,
    PINCH_SHAPE_ELLIPSOID,
    PINCH_SHAPE_SUPERELLIPSOID,
    PINCH_SHAPE_KINDS
} pinch_shape_kind;

typedef struct pinch_shape {
    pinch_shape_kind kind;
    double half[3];   /* box: half edges; segment, cylinder: [2] half the length; ellipsoids: semi-axes */
    double radius;    /* cylinder, flat capsule */
    double middle;    /* flat capsule: z of the cylinder's middle */
    double power[2];  /* superellipsoid: exponents of the dual norm, along z and around it */
    double margin;    /* m */
    double erosion;   /* radius of a ball that fits everywhere inside the shape's surface: its least radius of
                       * curvature */
    double bound;     /* radius of a ball about the origin that holds shape and margin */
    double corner[9]; /* triangle */
    const pinch_hull *hull;
} pinch_shape;

static inline bool pinch_is_polytope(const pinch_shape *shape)
{
    return shape->kind <= PINCH_SHAPE_HULL;
}

/* With a side at a radius around its axis. */
static inline bool pinch_is_round(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_CYLINDER || shape->kind == PINCH_SHAPE_FLAT_CAPSULE;
}

/* Whether the end at that side along the axis (its sign) is a cap with a rim: both of a cylinder, a flat capsule's low
 * one. */
static inline bool pinch_has_rim(const pinch_shape *shape, double end)
{
    return shape->kind == PINCH_SHAPE_CYLINDER || (shape->kind == PINCH_SHAPE_FLAT_CAPSULE && end < 0);
}

/* A point of the shape farthest along d (not zero), and how far that is: h(d). */
void pinch_support_point(const pinch_shape *shape, const double d[3], double point[3]);
double pinch_support_value(const pinch_shape *shape, const double d[3]);
/* The second derivative of h at the unit vector d, symmetric, row-major; on flat parts one-sided. */
void pinch_support_hessian(const pinch_shape *shape, const double d[3], double H[9]);
/* Up to three unit directions that matter: faces' normals, axes. Count. */
int pinch_shape_axes(const pinch_shape *shape, double axes[3][3]);

/* Face k of a box or hull. */
int pinch_face_count(const pinch_shape *shape);
void pinch_face_normal(const pinch_shape *shape, int face, double normal[3]);

/* A ball inside the shape, about `centre`; 0 where none is known: the centre alone. */
double pinch_inner_ball(const pinch_shape *shape, double centre[3]);
/* Moves its centre towards x as far as a ball of that radius fits. */
void pinch_slide_inner_ball(const pinch_shape *shape, const double x[3], double radius, double centre[3]);

/* Corner k of a polytope; count. */
int pinch_vertex_count(const pinch_shape *shape);
void pinch_vertex(const pinch_shape *shape, int k, double corner[3]);

/* The shape of a tip (of piece `piece`, whose hull is given). */
pinch_shape pinch_shape_of_tip(const pinch_tip *tip, const pinch_hull *hull);
pinch_shape pinch_shape_of_triangle(const double corners[9]);

#endif
