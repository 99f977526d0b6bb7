#ifndef PINCH_COLLISION_CONTACT_POINTS_H
#define PINCH_COLLISION_CONTACT_POINTS_H

#include "collision/penetration/face_test.h"
#include "collision/shape/shape_pair.h"

/* The contact points of two shapes along a known normal, from single points to clipped faces. */

enum { PINCH_MAX_CONTACT_POINTS = 64 };

typedef struct pinch_contact_point {
    double position[3]; /* half way through the overlap */
    double depth;       /* margins included, m */
} pinch_contact_point;

/* Finds at least one contact point, in A's axes, and returns their number. The deepest has the whole overlap. `faces`
 * are those that pinch_find_contact_normal has left. */
int pinch_contact_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                         const pinch_least_face faces[2], pinch_contact_point *contacts);

/* Finds the points of a shape that lie deeper than the plane n.x = offset. The unit vector n is in the shape's axes and
 * leads out of the solid. */
int pinch_plane_contact_points(const pinch_shape *shape, const double n[3], double offset,
                               pinch_contact_point *contacts);

/* A contact of two bodies, in the world's axes, with the pieces that meet. */
typedef struct pinch_body_contact {
    double position[3], normal[3], depth;
    int piece[2];
} pinch_body_contact;

typedef struct pinch_body_contacts {
    int count;
    pinch_body_contact item[PINCH_MAX_CONTACT_POINTS];
} pinch_body_contacts;

/* Drops contacts with internal edges, which pieces of one body have where they join. `which` is the body in pieces. */
void pinch_drop_internal_edges(const pinch_posed_body *body, int which, pinch_body_contacts *contacts);

#endif
