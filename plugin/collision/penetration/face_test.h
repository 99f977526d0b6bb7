#ifndef PINCH_COLLISION_FACE_TEST_H
#define PINCH_COLLISION_FACE_TEST_H

#include "collision/shape/shape_pair.h"

/* A face that is pressed in well inside its border. */

/* How far x, a point of the other body seen along the normal d of a box' or cylinder's face, is inside the face's
 * border; both in the shape's axes. */
double pinch_border_distance(const pinch_shape *shape, const double d[3], const double x[3]);

/* Where the shape `which`, a box or cylinder, has a face along n, too, or a side, all of its points are as far: the one
 * nearest to the other shape's origin, in that shape's axes. False: none, or parallel only nearly. */
bool pinch_nearest_face_point(const pinch_shape_pair *pair, int which, const double n[3], double x[3]);

/* A point is `overlap` (m) deep behind a box' or cylinder's face with normal d and `inside` its border: is that
 * positive, and does a ball of that radius about the point fit into the shape? */
bool pinch_ball_fits(const pinch_shape *shape, const double d[3], double inside, double overlap);

/*
 * n (unit, into A) is the normal of a face of a box or cylinder, A (`which` 0) or B (1), and `overlap` (m) the overlap
 * along n. True only if no other normal has less: far less work than to look at the others.
 */
bool pinch_face_is_least(const pinch_shape_pair *pair, int which, const double n[3], double overlap);

/* The same of any flat part of the bodies' difference: the point on it nearest to the origin is `inside` (m) its
 * border.
 */
bool pinch_facet_is_least(const pinch_shape_pair *pair, double inside, const double n[3], double overlap);

/* The faces of boxes and cylinders in the pair. True: `best` has the least overlap, or one of less than -margins. */
bool pinch_face_test(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* A hull's face that is pressed in well inside its border. */

enum { PINCH_FACE_DEPTHS = 64 };

/* The face of one shape with the least overlap. */
typedef struct pinch_least_face {
    pinch_contact_normal at;
    int face;        /* of the shape; -1: it has none that is better than the other shape's */
    int edge;        /* of the shape, where one gives the normal; -1: none */
    double point[3]; /* of the other shape, the farthest in, in the axes of the shape that has the face */
    unsigned corner; /* the same as a hull's corner */
    double radius;   /* of a ball inside the other shape */
    /* m, behind the first faces of a hull: how deep the ball's centre is, and where there is a face the point */
    double centre[PINCH_FACE_DEPTHS], far[PINCH_FACE_DEPTHS];
} pinch_least_face;

/* Is that the face that gives the normal? */
static inline bool pinch_face_gives_normal(const pinch_least_face *least, const double n[3])
{
    const double *m = least->at.normal;
    return least->face >= 0 && m[0] == n[0] && m[1] == n[1] && m[2] == n[2];
}

/* The faces of A and B in a pair in which one is a hull. True: `best` has the least overlap, or one of less than
 * -margins. */
bool pinch_hull_face_test(const pinch_shape_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best);

#endif
