#ifndef PINCH_COLLISION_CLIP_H
#define PINCH_COLLISION_CLIP_H

#include "collision/shape/feature.h"
#include "collision/shape/shape_pair.h"
#include "contact_points.h"

/* A flat face that is clipped against. */

/* What is outside of it, seen along n, does not meet it. In A's axes. */
typedef struct pinch_flat_face {
    const pinch_shape_pair *pair;
    int which; /* 0: A's face, 1: B's */
    const pinch_shape *shape;
    const pinch_feature *part;
    double n[3], d[3]; /* d: n in the shape's own axes */
    bool simple;       /* a cap, or a box' or hull's face square to n: its borders are known from one of its points */
    double slack;      /* m: a corner just outside by rounding is kept */
} pinch_flat_face;

/* Flat faces to clip against. */

pinch_flat_face pinch_flat_face_of(const pinch_shape_pair *pair, int which, const pinch_feature *part,
                                   const double n[3]);

/* Leaves of the polygon (segment, point) x what lies over the face, and returns how many corners that has; *whole: all
 * of it. `around`: the whole of what x is, in A's axes, or NULL. */
int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole);

/* Round faces to clip against. */

/* As pinch_clip_to_face, for a cap. What is left is in no order: corners over the cap, where
 * edges cross its rim, and the rim's own corners (pinch_rim_polygon) inside the polygon. Of two discs it is where the
 * rims cross, their corners in each other, and the middles of both arcs between, as far as they are apart. */
int pinch_clip_to_disc(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole);

#endif
