/* Flat faces to clip against. */
#ifndef PINCH_FINGERTIP_FACE_CLIP_H
#define PINCH_FINGERTIP_FACE_CLIP_H

#include "flat_face.h"

pinch_flat_face pinch_face_of(const pinch_core_pair *pair, int which, const pinch_core_part *part, const double n[3]);

/* Leaves of the polygon (segment, point) x what lies over the face, and returns how many corners that has; *whole: all
 * of it. `around`: the whole of what x is, in A's axes, or NULL. */
int pinch_clip_to_face(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count,
                       const pinch_core_part *around, bool *whole);

#endif
