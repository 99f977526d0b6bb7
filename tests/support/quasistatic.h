#ifndef PINCH_TEST_QUASISTATIC_H
#define PINCH_TEST_QUASISTATIC_H

#include "scenes/scene.h"

#include <stdbool.h>

/*
 * The quasi-static, infinitely slow motion of a box that fixed spherical tips hold. It is computed on the geometry as
 * it deforms: where the tips touch, which way the faces look and how the contacts roll follow the object's pose. The
 * equilibria are found increment by increment from the scene's own numbers; nothing is shared with the statics or with
 * the steps. The object starts at the origin and is not turned.
 */

enum { QUASISTATIC_FINGERS = 8 };

/* Where a tip touches the object that has moved by u (m) and turned by the quaternion q. */
typedef struct tip_contact {
    double depth;     /* m, overlap of the undeformed shapes; <= 0: apart */
    double normal[3]; /* unit, into the object */
    double arm[3];    /* m, from the object's centre of mass to the point on its face */
} tip_contact;

/* `closed` is the part of its closing that the finger has made. */
tip_contact tip_contact_at(const scene_finger *finger, double closed, const double u[3], const double q[4]);

/*
 * Closes all fingers together, then applies the wrench of the schedule's last entry, both in `increments` parts that
 * are halved where an increment finds no equilibrium. force[finger] is the force on the object in N, in world axes.
 * Returns false where the path comes to an end because no equilibrium continues it.
 */
bool quasistatic_motion(const scene *s, int increments, double force[QUASISTATIC_FINGERS][3]);

#endif
