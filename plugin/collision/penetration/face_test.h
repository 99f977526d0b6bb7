#ifndef PINCH_COLLISION_FACE_TEST_H
#define PINCH_COLLISION_FACE_TEST_H

#include "collision/shape/shape_pair.h"

/* A face that is pressed in well inside its border. */

/* How far x, a point of the other body seen along the normal d of a box' or cylinder's face, is inside the face's
 * border; both in the core's axes. */
double pinch_inside_face(const pinch_core *core, const double d[3], const double x[3]);

/* Where the core `which`, a box or cylinder, has a face along n, too, or a side, all of its points are as far: the one
 * nearest to the other core's origin, in that core's axes. False: none, or parallel only nearly. */
bool pinch_face_point(const pinch_core_pair *pair, int which, const double n[3], double x[3]);

/* A point is `overlap` (m) deep behind a box' or cylinder's face with normal d and `inside` its border: is that
 * positive, and does a ball of that radius about the point fit into the core? */
bool pinch_ball_fits(const pinch_core *core, const double d[3], double inside, double overlap);

/*
 * n (unit, into A) is the normal of a face of a box or cylinder, A (`which` 0) or B (1), and `overlap` (m) the overlap
 * along n. True only if no other normal has less: far less work than to look at the others.
 */
bool pinch_face_is_least(const pinch_core_pair *pair, int which, const double n[3], double overlap);

/* The same of any flat part of the bodies' difference: the point on it nearest to the origin is `inside` (m) its
 * border.
 */
bool pinch_flat_is_least(const pinch_core_pair *pair, double inside, const double n[3], double overlap);

/* The faces of boxes and cylinders in the pair. True: `best` has the least overlap, or one of less than -skins. */
bool pinch_face_first(const pinch_core_pair *pair, pinch_contact_normal *best);

/* A hull's face that is pressed in well inside its border. */

enum { PINCH_LEFT_FACES = 64 };

/* The face of one core with the least overlap. */
typedef struct pinch_least_face {
    pinch_contact_normal at;
    int face;        /* of the core; -1: it has none that is better than the other core's */
    int edge;        /* of the core, where one gives the normal; -1: none */
    double point[3]; /* of the other core, the farthest in, in the axes of the core that has the face */
    unsigned corner; /* the same as a hull's corner */
    double radius;   /* of a ball inside the other core */
    /* m, behind the first faces of a hull: how deep the ball's centre is, and where there is a face the point */
    double centre[PINCH_LEFT_FACES], far[PINCH_LEFT_FACES];
} pinch_least_face;

/* Is that the face that gives the normal? */
static inline bool pinch_gives_normal(const pinch_least_face *least, const double n[3])
{
    const double *m = least->at.normal;
    return least->face >= 0 && m[0] == n[0] && m[1] == n[1] && m[2] == n[2];
}

/* The faces of A and B in a pair in which one is a hull. True: `best` has the least overlap, or one of less than
 * -skins. */
bool pinch_hull_first(const pinch_core_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best);

#endif
