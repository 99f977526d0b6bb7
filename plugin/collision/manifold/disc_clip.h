/* Round faces to clip against. */
#ifndef PINCH_FINGERTIP_DISC_CLIP_H
#define PINCH_FINGERTIP_DISC_CLIP_H

#include "flat_face.h"

/* As pinch_clip_to_face, for a cap. What is left is in no order: corners over the cap, where
 * edges cross its rim, and the rim's own corners (pinch_core_rim) inside the polygon. Of two discs it is where the rims
 * cross, their corners in each other, and the middles of both arcs between, as far as they are apart. */
int pinch_clip_to_disc(const pinch_flat_face *face, double x[PINCH_TOUCHES][3], int count,
                       const pinch_core_part *around, bool *whole);

#endif
