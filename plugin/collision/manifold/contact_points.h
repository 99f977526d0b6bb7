#ifndef PINCH_COLLISION_CONTACT_POINTS_H
#define PINCH_COLLISION_CONTACT_POINTS_H

#include "collision/penetration/face_test.h"
#include "collision/shape/shape_pair.h"

/* A contact point of two cores. */

enum { PINCH_TOUCHES = 64 };

typedef struct pinch_touch {
    double position[3]; /* half way through the overlap */
    double depth;       /* m, skins included */
} pinch_touch;

/* Contact points of two cores along a known normal: from single points to clipped faces. */

/* At least one point, at most PINCH_TOUCHES; the deepest has the whole overlap. In A's axes. `faces`: as
 * pinch_find_normal has left them. */
int pinch_touch_points(const pinch_core_pair *pair, const pinch_contact_normal *normal, const pinch_least_face faces[2],
                       pinch_touch *touches);

/* The points of a core that lie deeper than the plane n.x = offset (n unit, in the core's axes, out of the solid). */
int pinch_touch_plane(const pinch_core *core, const double n[3], double offset, pinch_touch *touches);

/* One contact, world axes. */
typedef struct pinch_tip_touch {
    double position[3], normal[3], depth;
    int piece[2];
} pinch_tip_touch;

typedef struct pinch_tip_touches {
    int count;
    pinch_tip_touch item[PINCH_TOUCHES];
} pinch_tip_touches;

/* Drops what pieces of one body have on each other's seams. `which`: the body in pieces. */
void pinch_drop_seams(const pinch_tip_body *body, int which, pinch_tip_touches *touches);

#endif
