/* What the contacts of one geom exert together. */
#ifndef PINCH_CONTACTS_LOAD_H
#define PINCH_CONTACTS_LOAD_H

#include "contacts/contact_store.h"

/* Sums up the results of the last step for a geom, with all partners where `partner` is NULL; see pinch_ode_load.
 * about: NULL for the centre of mass of the geom's body. PINCH_INVALID_ARGUMENT where it is not finite. */
pinch_status pinch_sum_load(const pinch_contact_store *store, dGeomID geom, dGeomID partner, const double *about,
                            pinch_ode_load *load);

#endif
