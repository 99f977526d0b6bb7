#ifndef PINCH_COLLISION_WRITE_CONTACTS_H
#define PINCH_COLLISION_WRITE_CONTACTS_H

#include "collision/manifold/contact_points.h"

#include <ode/ode.h>

/* Returns the k-th of contacts that are `skip` bytes apart. */
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

/* Writes the contacts as ODE's, at most `room` of them, `skip` bytes apart. Returns their number. */
int pinch_write_contacts(const pinch_body_contacts *list, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip);

/* Chooses the points that stand for all where there is room for fewer. Returns their number, which is count or room,
 * and their places. */
int pinch_choose_contact_points(const pinch_contact_point *list, int count, int room,
                                int chosen[PINCH_MAX_CONTACT_POINTS]);

#endif
