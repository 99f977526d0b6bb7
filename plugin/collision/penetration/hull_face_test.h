/* A hull's face that is pressed in well inside its border. */
#ifndef PINCH_FINGERTIP_HULL_FIRST_H
#define PINCH_FINGERTIP_HULL_FIRST_H

#include "collision/shape/contact_normal.h"

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
