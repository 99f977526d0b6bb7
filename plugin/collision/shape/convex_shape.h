#ifndef PINCH_COLLISION_CONVEX_SHAPE_H
#define PINCH_COLLISION_CONVEX_SHAPE_H

#include "hull.h"

/* A convex shape is described by its support function in its own axes. It is the Minkowski sum of the convex set below
 * and a ball, its margin. */

typedef enum pinch_shape_kind {
    PINCH_SHAPE_POINT = 0,
    PINCH_SHAPE_SEGMENT,
    PINCH_SHAPE_TRIANGLE,
    PINCH_SHAPE_BOX,
    PINCH_SHAPE_HULL, /* the kinds up to here are polytopes */
    PINCH_SHAPE_CYLINDER,
    PINCH_SHAPE_FLAT_CAPSULE,
    PINCH_SHAPE_ELLIPSOID,
    PINCH_SHAPE_SUPERELLIPSOID,
    PINCH_SHAPE_KINDS
} pinch_shape_kind;

typedef struct pinch_shape {
    pinch_shape_kind kind;
    double half[3];   /* box: half edge lengths; segment, cylinder: [2] is half the length; ellipsoids: semi-axes */
    double radius;    /* of a cylinder or flat capsule */
    double middle;    /* flat capsule: z of its cylinder's middle */
    double power[2];  /* superellipsoid: exponents of the dual norm, along z and around z */
    double margin;    /* radius of the ball that is rolled around the shape, m */
    double erosion;   /* least radius of curvature: a ball of this radius fits everywhere inside the surface */
    double bound;     /* radius of a ball about the origin that holds the shape with its margin */
    double corner[9]; /* vertices of a triangle */
    const pinch_hull *hull;
} pinch_shape;

static inline bool pinch_is_polytope(const pinch_shape *shape)
{
    return shape->kind <= PINCH_SHAPE_HULL;
}

/* A round shape has a side at a constant radius around its axis. */
static inline bool pinch_is_round(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_CYLINDER || shape->kind == PINCH_SHAPE_FLAT_CAPSULE;
}

/* Tells whether the end on that side of the axis (given by its sign) is a cap with a rim. A cylinder has two, a flat
 * capsule has one at its low end. */
static inline bool pinch_has_rim(const pinch_shape *shape, double end)
{
    return shape->kind == PINCH_SHAPE_CYLINDER || (shape->kind == PINCH_SHAPE_FLAT_CAPSULE && end < 0);
}

/* The support point is a point of the shape farthest along d (d is not zero). The support value h(d) is how far that is
 * along d, margin left out. */
void pinch_support_point(const pinch_shape *shape, const double d[3], double point[3]);
double pinch_support_value(const pinch_shape *shape, const double d[3]);
/* Returns a support value of a vertex near the farthest one where the shape is a large hull, which takes far less time,
 * and otherwise the support value. As computed it is never more than the support value is. */
double pinch_support_at_least(const pinch_shape *shape, const double d[3]);
static inline bool pinch_is_large_hull(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_HULL && shape->hull->tree.leaves > 0;
}
/* The support Hessian is the second derivative of h at the unit vector d, symmetric and row-major. On flat parts it is
 * one-sided. */
void pinch_support_hessian(const pinch_shape *shape, const double d[3], double H[9]);
/* Finds up to three unit directions that matter, such as the normals of faces and the axis of a cylinder. Returns their
 * number. */
int pinch_shape_axes(const pinch_shape *shape, double axes[3][3]);

/* The faces of a polytope are numbered from 0. Only triangles, boxes and hulls have any. */
int pinch_face_count(const pinch_shape *shape);
void pinch_face_normal(const pinch_shape *shape, int face, double normal[3]);

/* Finds the centre of a ball inside the shape and returns its radius. The radius is 0 where no ball is known. */
double pinch_inner_ball(const pinch_shape *shape, double centre[3]);
/* Moves the centre of a ball of that radius towards x, as far as the ball stays inside the shape. */
void pinch_slide_inner_ball(const pinch_shape *shape, const double x[3], double radius, double centre[3]);

/* The vertices of a polytope are numbered from 0. */
int pinch_vertex_count(const pinch_shape *shape);
void pinch_vertex(const pinch_shape *shape, int k, double corner[3]);

/* Returns the shape of a tip, or of that piece of a convex tip whose hull is given. */
pinch_shape pinch_shape_of_tip(const pinch_tip *tip, const pinch_hull *hull);
pinch_shape pinch_shape_of_triangle(const double corners[9]);

#endif
