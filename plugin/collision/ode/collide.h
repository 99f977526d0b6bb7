#ifndef PINCH_COLLISION_COLLIDE_H
#define PINCH_COLLISION_COLLIDE_H

#include "collision/manifold/contact_points.h"
#include "collision/shape/shape_pair.h"

#include <ode/ode.h>

/* Finds the shapes and the pose of a geom. Returns false for classes that the collision geometry does not know. `body`
 * must not be copied. */
bool pinch_body_of_geom(dGeomID geom, pinch_posed_body *body);

/* Finds the sides (m) of the box around a geom in the geom's own axes, whatever its pose. Returns false where only
 * dGeomGetAABB knows anything: planes and height fields, convexes that are not known, a program's own classes. */
bool pinch_own_sides(dGeomID geom, double sides[3]);

/* Writes the contacts of two bodies as ODE's, at most `room` of them, `skip` bytes apart. Returns their number. */
int pinch_collide_bodies(const pinch_posed_body *a, const pinch_posed_body *b, int room, dContactGeom *contacts,
                         int skip);
/* Appends the contacts of two of their pieces to the list. */
void pinch_collide_pieces(const pinch_posed_body *a, int piece_a, const pinch_posed_body *b, int piece_b,
                          pinch_body_contacts *list);

void pinch_collide_plane(const pinch_posed_body *body, dGeomID plane, pinch_body_contacts *list);
void pinch_collide_trimesh(const pinch_posed_body *body, dGeomID mesh, pinch_body_contacts *list);

#endif
