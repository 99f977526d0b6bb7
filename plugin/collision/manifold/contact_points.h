#ifndef PINCH_COLLISION_CONTACT_POINTS_H
#define PINCH_COLLISION_CONTACT_POINTS_H

#include "collision/penetration/face_test.h"
#include "collision/shape/shape_pair.h"

/* A contact point of two shapes. */

enum { PINCH_MAX_CONTACT_POINTS = 64 };

typedef struct pinch_contact_point {
    double position[3]; /* half way through the overlap */
    double depth;       /* m, margins included */
} pinch_contact_point;

/* Contact points of two shapes along a known normal: from single points to clipped faces. */

/* At least one point, at most PINCH_MAX_CONTACT_POINTS; the deepest has the whole overlap. In A's axes. `faces`: as
 * pinch_find_contact_normal has left them. */
int pinch_contact_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                         const pinch_least_face faces[2], pinch_contact_point *contacts);

/* The points of a shape that lie deeper than the plane n.x = offset (n unit, in the shape's axes, out of the solid). */
int pinch_plane_contact_points(const pinch_shape *shape, const double n[3], double offset,
                               pinch_contact_point *contacts);

/* One contact, world axes. */
typedef struct pinch_body_contact {
    double position[3], normal[3], depth;
    int piece[2];
} pinch_body_contact;

typedef struct pinch_body_contacts {
    int count;
    pinch_body_contact item[PINCH_MAX_CONTACT_POINTS];
} pinch_body_contacts;

/* Drops what pieces of one body have on each other's seams. `which`: the body in pieces. */
void pinch_drop_internal_edges(const pinch_posed_body *body, int which, pinch_body_contacts *contacts);

#endif
