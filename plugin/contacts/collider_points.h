/* What is put right in the points that colliders detect, before a manifold gets them. */
#ifndef PINCH_CONTACTS_COLLIDER_POINTS_H
#define PINCH_CONTACTS_COLLIDER_POINTS_H

#include "contacts/manifold_point.h"

#include <ode/ode.h>

/* contact_location.c: tells whether both geoms are known to have flat faces. Their points stay where the collider puts
 * them. */
bool pinch_both_faceted(dGeomID a, dGeomID b);
/* contact_location.c: moves a point of a pair along its normal to half way through the overlap, wherever its collider
 * put it. Between flat faces, and where that cannot be told, the point stays. class, pose: the geoms', see
 * pinch_side_pose */
void pinch_locate_contact(const dGeomID geom[2], const int class[2], const pinch_pose pose[2],
                          pinch_detected_point *detected);

/* capsule_box.c: adds the second end of a contact line between a capsule and a box where the collider left it out, and
 * returns how many points there are. Depths are as the program handed them over, gaps negative; what it has changed of
 * the collider's holds for both ends. A point that the collider does not return stays as it is. */
int pinch_add_capsule_end(const dGeomID geom[2], const int class[2], pinch_detected_point *detected, int count);

/* box_faces.c: where faces of two boxes lie on each other, gives the points one normal that does not depend on
 * rounding, drops those where edges cross that lie along each other, and returns how many are left. */
int pinch_settle_box_faces(const dGeomID geom[2], const int class[2], const pinch_pose pose[2],
                           pinch_detected_point *detected, int count);

#endif
