#ifndef PINCH_COLLISION_FACE_TEST_H
#define PINCH_COLLISION_FACE_TEST_H

#include "collision/shape/shape_pair.h"

/* Most contacts are of a face that is pressed in well inside its border. These tests find the face of least overlap and
 * prove, where they can, that no other normal has less. */

/* Returns how far x, a point of the other body seen along the normal d of a face of a box or cylinder, lies inside the
 * face's border. All are in the shape's axes. */
double pinch_border_distance(const pinch_shape *shape, const double d[3], const double x[3]);

/* Where the shape `which`, a box or cylinder, has a face or side along n as well, all points of that are equally far.
 * Finds the one nearest to the other shape's origin, in that shape's axes. Returns false where there is none, or where
 * it is only nearly parallel. */
bool pinch_nearest_face_point(const pinch_shape_pair *pair, int which, const double n[3], double x[3]);

/* A point lies `overlap` (m) deep behind a face of a box or cylinder with the normal d, and `inside` its border. Tells
 * whether a ball of radius `overlap` > 0 about that point fits into the shape. */
bool pinch_ball_fits(const pinch_shape *shape, const double d[3], double inside, double overlap);

/*
 * n (unit, into A) is the normal of a face of a box or cylinder, which is A (`which` 0) or B (1), and `overlap` (m) is
 * the overlap along n. Returns true only if no other normal has less. That is far less work than looking at the others.
 */
bool pinch_face_is_least(const pinch_shape_pair *pair, int which, const double n[3], double overlap);

/* Does the same for any flat facet of the Minkowski difference. The facet's point nearest to the origin is `inside` (m)
 * the facet's border. */
bool pinch_facet_is_least(const pinch_shape_pair *pair, double inside, const double n[3], double overlap);

/* Tests the faces of boxes and cylinders in the pair. When it returns true, `best` has the least overlap, or one of
 * less than minus the margins, which means that the bodies are apart. */
bool pinch_face_test(const pinch_shape_pair *pair, pinch_contact_normal *best);

enum { PINCH_FACE_DEPTHS = 64 };

/* The face of one shape along whose normal the overlap is least. */
typedef struct pinch_least_face {
    pinch_contact_normal at;
    int face;        /* number of the face; -1: none is better than the other shape's */
    int edge;        /* number of the edge that gives the normal; -1: none */
    double point[3]; /* the other shape's point that is farthest in, in the axes of the shape that has the face */
    unsigned corner; /* the same point as a vertex of a hull */
    double radius;   /* of a ball inside the other shape */
    /* how deep (m) the ball's centre, and the point if there is a face, lie behind the hull's first faces */
    double centre[PINCH_FACE_DEPTHS], far[PINCH_FACE_DEPTHS];
} pinch_least_face;

/* Tells whether this face gives the normal n. */
static inline bool pinch_face_gives_normal(const pinch_least_face *least, const double n[3])
{
    const double *m = least->at.normal;
    return least->face >= 0 && m[0] == n[0] && m[1] == n[1] && m[2] == n[2];
}

/* Tests the faces of A and B in a pair in which one is a hull. Returns as pinch_face_test does. */
bool pinch_hull_face_test(const pinch_shape_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best);

#endif
