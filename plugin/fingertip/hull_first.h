/* A hull's face that is pressed in well inside its border. */
#ifndef PINCH_FINGERTIP_HULL_FIRST_H
#define PINCH_FINGERTIP_HULL_FIRST_H

#include "contact_normal.h"

/* The face of one core with the least overlap. */
typedef struct pinch_least_face {
    pinch_contact_normal at;
    int face;        /* of the core; -1: it has none that is better than the other core's */
    double point[3]; /* of the other core, the farthest in, in the axes of the core that has the face */
    unsigned corner; /* the same as a hull's corner */
} pinch_least_face;

/* The faces of A and B in a pair in which one is a hull. True: `best` has the least overlap, or one of less than
 * -skins. */
bool pinch_hull_first(const pinch_core_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best);

#endif
