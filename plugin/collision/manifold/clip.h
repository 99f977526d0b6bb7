#ifndef PINCH_COLLISION_CLIP_H
#define PINCH_COLLISION_CLIP_H

#include "collision/shape/feature.h"
#include "collision/shape/shape_pair.h"
#include "contact_points.h"

/* A flat face of one shape, against which points of the other one are clipped. */

/* Whatever lies outside the face, seen along n, does not meet it. All vectors but d are in A's axes. */
typedef struct pinch_flat_face {
    const pinch_shape_pair *pair;
    int which; /* 0: A's face, 1: B's */
    const pinch_shape *shape;
    const pinch_feature *part;
    double n[3], d[3]; /* d is n in the shape's own axes */
    bool simple;       /* a cap, or a face of a box or hull square to n: its borders are known from one of its points */
    double slack;      /* a corner outside by less (m) is kept */
} pinch_flat_face;

pinch_flat_face pinch_flat_face_of(const pinch_shape_pair *pair, int which, const pinch_feature *part,
                                   const double n[3]);

/* Clips the polygon, segment or point x to what lies over the face. Returns the number of its corners, and tells in
 * `whole` if nothing was cut off. `around` is the feature to which x belongs, in A's axes, or NULL. */
int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole);

/* Does the same for a cap. The points that are left have no order: corners over the cap, points where edges cross its
 * rim, and corners of the rim polygon (pinch_rim_polygon) inside the polygon. Of two discs they are the points where
 * the rims cross, rim corners inside the other disc, and the middles of both arcs between, as far as they are apart. */
int pinch_clip_to_disc(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole);

#endif
