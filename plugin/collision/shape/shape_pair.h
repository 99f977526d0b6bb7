#ifndef PINCH_COLLISION_SHAPE_PAIR_H
#define PINCH_COLLISION_SHAPE_PAIR_H

#include "convex_shape.h"

/* Two shapes in the axes of the first, and the overlap of them along a normal. */

/* A point x of B is R x + p in A's axes. A contact normal points into A: A's support point is taken along -n, B's along
 * n. */
typedef struct pinch_shape_pair {
    const pinch_shape *a, *b;
    double R[9], p[3];
} pinch_shape_pair;

static inline void pinch_pair_rotate(const pinch_shape_pair *pair, const double v[3], double out[3])
{
    const double *R = pair->R;
    for (int i = 0; i < 3; i++) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static inline void pinch_pair_rotate_back(const pinch_shape_pair *pair, const double v[3], double out[3])
{
    const double *R = pair->R;
    for (int i = 0; i < 3; i++) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

/* Converts a point from B's axes to A's, and back. */
static inline void pinch_pair_point_to_a(const pinch_shape_pair *pair, const double x[3], double in_a[3])
{
    double rotated[3];
    pinch_pair_rotate(pair, x, rotated);
    for (int i = 0; i < 3; i++) in_a[i] = rotated[i] + pair->p[i];
}

static inline void pinch_pair_point_to_b(const pinch_shape_pair *pair, const double x[3], double in_b[3])
{
    const double from[3] = {x[0] - pair->p[0], x[1] - pair->p[1], x[2] - pair->p[2]};
    pinch_pair_rotate_back(pair, from, in_b);
}

/* Finds the vector from the middle of A's cylinder to that of B's, whose axis is w. Both shapes are round. */
static inline void pinch_pair_between_middles(const pinch_shape_pair *pair, const double w[3], double m[3])
{
    for (int i = 0; i < 3; i++) m[i] = pair->p[i] + pair->b->middle * w[i];
    m[2] -= pair->a->middle;
}

/* Finds a ball inside the Minkowski difference B - A. Its centre is near the origin if there is a choice. Returns the
 * radius. */
double pinch_pair_inner_ball(const pinch_shape_pair *pair, double centre[3]);

/*
 * Is it certain that all normals at the angle T from n (given by its cosine and sine) and beyond have at least this
 * overlap (m)? The inner ball of the difference, of radius rho about P, bounds the overlap: p(m) >= rho + m.P. At the
 * angle t from n that is at least rho - |P| cos(t - a), where a is the angle between P and -n, and it rises from t = a
 * on.
 */
bool pinch_is_deeper_beyond(const pinch_shape_pair *pair, const double n[3], double overlap, double cosine,
                            double sine);

void pinch_pair_support_a(const pinch_shape_pair *pair, const double n[3], double a[3]);
void pinch_pair_support_b(const pinch_shape_pair *pair, const double n[3], double b[3]);
/* The overlap of the shapes along the unit vector n is h_A(-n) + h_B(n), margins left out. */
double pinch_pair_overlap(const pinch_shape_pair *pair, const double n[3]);
/* Returns false where the overlap along n, as it is computed, is not less than the limit because a vertex of a
 * large hull that is found in no time is far enough along n already. */
bool pinch_pair_may_overlap_less(const pinch_shape_pair *pair, const double n[3], double limit);

/* Tells whether the overlap along n is less than the limit, and finds it then. */
static inline bool pinch_pair_overlaps_less(const pinch_shape_pair *pair, const double n[3], double limit,
                                            double *overlap)
{
    bool large = pinch_is_large_hull(pair->a) || pinch_is_large_hull(pair->b);
    if (large && !pinch_pair_may_overlap_less(pair, n, limit)) return false;
    double found = pinch_pair_overlap(pair, n);
    if (!(found < limit)) return false;
    *overlap = found;
    return true;
}
/* Adds both support Hessians at n, in A's axes. */
void pinch_pair_hessian(const pinch_shape_pair *pair, const double n[3], double H[9]);

/* A geom as the collision geometry sees it: one or more convex shapes with a pose. */

typedef struct pinch_posed_body {
    dGeomID geom; /* the geom that contacts name; a transform that asks for it stands for the geom it holds */
    const pinch_shape *shapes;
    int shape_count;
    pinch_shape own; /* the shape of one of ODE's geoms, made on the spot */
    double position[3], R[9];
} pinch_posed_body;

/* Sets up a pair of shapes with the pose of b in a's axes. */
void pinch_pair_of(const pinch_posed_body *a, const pinch_shape *shape_a, const pinch_posed_body *b,
                   const pinch_shape *shape_b, pinch_shape_pair *pair);

/* The contact normal of two shapes is the unit vector of least overlap. */

typedef struct pinch_contact_normal {
    double normal[3]; /* unit, into A */
    double overlap;   /* of the shapes along the normal, margins left out, m */
} pinch_contact_normal;

/* Takes n if the overlap along it is less. */
static inline void pinch_offer_normal(const pinch_shape_pair *pair, const double n[3], pinch_contact_normal *best)
{
    if (!pinch_pair_overlaps_less(pair, n, best->overlap, &best->overlap)) return;
    for (int i = 0; i < 3; i++) best->normal[i] = n[i];
}

/* Takes an axis if it is better by `preference`. Both bodies are their own mirror images, and `extent` is the sum of
 * their extents along the axis. Of n and -n the normal is the one that leads from B's middle towards A's. */
static inline void pinch_offer_axis(const pinch_shape_pair *pair, const double n[3], double extent, double preference,
                                    pinch_contact_normal *best)
{
    double along = n[0] * pair->p[0] + n[1] * pair->p[1] + n[2] * pair->p[2], overlap = extent - fabs(along);
    if (!(overlap < best->overlap - preference)) return;
    double sign = along > 0 ? -1 : 1;
    best->overlap = overlap;
    for (int i = 0; i < 3; i++) best->normal[i] = sign * n[i];
}

#endif
