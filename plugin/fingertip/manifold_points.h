/* Contact points of two cores along a known normal: from single points to clipped faces. */
#ifndef PINCH_FINGERTIP_MANIFOLD_POINTS_H
#define PINCH_FINGERTIP_MANIFOLD_POINTS_H

#include "contact_normal.h"
#include "face_clip.h"
#include "feature.h"

typedef struct pinch_touch {
    double position[3]; /* half way through the overlap */
    double depth;       /* m, skins included */
} pinch_touch;

/* At least one point, at most PINCH_TOUCHES; the deepest has the whole overlap. In A's axes. */
int pinch_touch_points(const pinch_core_pair *pair, const pinch_contact_normal *normal, pinch_touch *touches);

/* What core `which` (0: A, at -n, 1: B, at n) has there, in A's axes. */
void pinch_part_in_a(const pinch_core_pair *pair, int which, const double *n, bool exact, pinch_core_part *part);

/* The contact at the point x of core `which`, `depth` deep along n (skins included). */
void pinch_touch_at(const pinch_core_pair *pair, int which, const double *x, const double *n, double depth,
                    pinch_touch *touch);

/* The points of a core that lie deeper than the plane n.x = offset (n unit, in the core's axes, out of the solid). */
int pinch_touch_plane(const pinch_core *core, const double n[3], double offset, pinch_touch *touches);

#endif
