/* Flat faces to clip against. */
#ifndef PINCH_FINGERTIP_FACE_CLIP_H
#define PINCH_FINGERTIP_FACE_CLIP_H

#include "flat_face.h"

pinch_flat_face pinch_face_of(const pinch_core_pair *pair, int which, const pinch_core_part *part, const double n[3]);

/* Must the part have all its corners to clip against? One is enough of a cap, and of a box' or hull's face at right
 * angles to n. */
bool pinch_face_needs_corners(const pinch_flat_face *face);

/* Leaves of the polygon (segment, point) x what lies over the face, and returns how many corners that has; *whole: all
 * of it. `around`: the whole of what x is, in A's axes, or NULL. */
int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count,
                       const pinch_core_part *around, bool *whole);

#endif
