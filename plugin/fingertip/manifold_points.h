/* Contact points of two cores along a known normal: from single points to clipped faces. */
#ifndef PINCH_FINGERTIP_MANIFOLD_POINTS_H
#define PINCH_FINGERTIP_MANIFOLD_POINTS_H

#include "normal.h"

enum { PINCH_TOUCHES = 64 };

typedef struct pinch_touch {
    double position[3]; /* half way through the overlap */
    double depth;       /* m, skins included */
} pinch_touch;

/* What a core's surface is at a direction: a point, a straight line, a flat face (its corners in order). */
typedef struct pinch_core_part {
    int count;
    bool face;
    double x[32][3];
} pinch_core_part;

/* feature.c. `exact`: only what is at right angles to d to rounding; otherwise the face or line that comes nearest. */
void pinch_core_part_at(const pinch_core *core, const double d[3], bool exact, pinch_core_part *part);

/* At least one point, at most PINCH_TOUCHES; the deepest has the whole overlap. In A's axes. */
int pinch_touch_points(const pinch_core_pair *pair, const pinch_contact_normal *normal, pinch_touch *touches);

/* The points of a core that lie deeper than the plane n.x = offset (n unit, in the core's axes, out of the solid). */
int pinch_touch_plane(const pinch_core *core, const double n[3], double offset, pinch_touch *touches);

#endif
