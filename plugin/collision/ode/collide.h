#ifndef PINCH_COLLISION_COLLIDE_H
#define PINCH_COLLISION_COLLIDE_H

#include "collision/manifold/contact_points.h"
#include "collision/shape/shape_pair.h"

#include <ode/ode.h>

/* False where this geometry does not know the geom's class. `body` must not be copied. */
bool pinch_body_of_geom(dGeomID geom, pinch_posed_body *body);

/* The contacts of two bodies as ODE's, `skip` bytes apart, at most `room`; returns how many. */
int pinch_collide_bodies(const pinch_posed_body *a, const pinch_posed_body *b, int room, dContactGeom *contacts,
                         int skip);
/* Those of two of their pieces come on top of the touches. */
void pinch_collide_pieces(const pinch_posed_body *a, int piece_a, const pinch_posed_body *b, int piece_b,
                          pinch_body_contacts *list);

void pinch_collide_plane(const pinch_posed_body *body, dGeomID plane, pinch_body_contacts *list);
void pinch_collide_trimesh(const pinch_posed_body *body, dGeomID mesh, pinch_body_contacts *list);

/* The k-th of contacts that are `skip` bytes apart. */
static inline dContactGeom *pinch_contact_at(dContactGeom *contacts, int k, int skip)
{
    return (dContactGeom *)(void *)((char *)contacts + (size_t)k * (size_t)skip);
}

static inline void pinch_write_contact(const double *position, const double *normal, double depth, dGeomID g1,
                                       dGeomID g2, dContactGeom *c)
{
    for (int i = 0; i < 3; i++) {
        c->pos[i] = position[i];
        c->normal[i] = normal[i];
    }
    c->pos[3] = c->normal[3] = 0;
    c->depth = depth;
    c->g1 = g1;
    c->g2 = g2;
    c->side1 = c->side2 = -1;
}

/* As ODE's contacts, `skip` bytes apart, at most `room`; returns how many. */
int pinch_write_contacts(const pinch_body_contacts *list, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip);

/* Of more contact points than there is room for those that stand for all. */

/* Their places; returns how many: count, or room where that is less. */
int pinch_choose_contact_points(const pinch_contact_point *list, int count, int room,
                                int chosen[PINCH_MAX_CONTACT_POINTS]);

#endif
