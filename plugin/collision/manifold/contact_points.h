/* Contact points of two cores along a known normal: from single points to clipped faces. */
#ifndef PINCH_FINGERTIP_MANIFOLD_POINTS_H
#define PINCH_FINGERTIP_MANIFOLD_POINTS_H

#include "collision/shape/contact_normal.h"
#include "collision/penetration/hull_face_test.h"
#include "touch.h"

/* At least one point, at most PINCH_TOUCHES; the deepest has the whole overlap. In A's axes. `faces`: as
 * pinch_find_normal has left them. */
int pinch_touch_points(const pinch_core_pair *pair, const pinch_contact_normal *normal, const pinch_least_face faces[2],
                       pinch_touch *touches);

/* The points of a core that lie deeper than the plane n.x = offset (n unit, in the core's axes, out of the solid). */
int pinch_touch_plane(const pinch_core *core, const double n[3], double offset, pinch_touch *touches);

#endif
