/* The materials of fingertips, and the contact law of a pair that has one. */
#ifndef PINCH_CONTACTS_MATERIALS_H
#define PINCH_CONTACTS_MATERIALS_H

#include "contacts/contact_store.h"

/* As pinch_ode_set_material. */
pinch_status pinch_set_material(pinch_contact_store *store, dGeomID geom, const pinch_material *material);

/* Returns NULL for a geom without a material. */
static inline const pinch_material *pinch_geom_material(const pinch_contact_store *store, int record)
{
    int material = store->geoms.items[record].material;
    return material < 0 ? NULL : &store->materials.items[material].material;
}

/* Returns the material of a pair: that of a geom, or `own`, where it is computed; NULL when neither geom has a
 * material. Finds which share of the overlap lies between geom[0]'s surface and the contact. That is the part that
 * geom[0] gives, its part of the compliance: 0 where it has no material and is rigid, half between flat faces (see
 * contact_location.c). */
const pinch_material *pinch_pair_material(const pinch_contact_store *store, const pinch_pair *pair, pinch_material *own,
                                          double *share);

/* Returns the part of the pair's depth that follows Hertz' law, in [0, 1]; the rest is a linear spring's. */
double pinch_pair_hertz_part(const pinch_contact_store *store, const pinch_pair *pair);

#endif
