/* The table of geom pairs in contact. */
#ifndef PINCH_CONTACTS_PAIRS_H
#define PINCH_CONTACTS_PAIRS_H

#include "contacts/contact_store.h"
#include "util/workers.h"

/* Returns the index of the pair of two geom records, the older one first, and adds it where it is new; -1 when memory
 * runs out. */
int pinch_pair_between(pinch_contact_store *store, int geom0, int geom1);
/* Ends the contact history of a pair. */
void pinch_clear_pair(pinch_contact_store *store, pinch_pair *pair);

/*
 * Forgets all pairs of a geom, or of a body, with the contacts that have come between them. They stay in their list,
 * and are to be dropped before the next contact comes, all at once: to look for those of each geom and body that a
 * program destroys would take the square of their number. Until then they are those of what was forgotten, whatever
 * has come at its address. The second returns false when memory runs out, and nothing is forgotten.
 */
void pinch_forget_pairs_of(pinch_contact_store *store, int geom);
bool pinch_forget_pairs_of_body(pinch_contact_store *store, dBodyID body);
bool pinch_pair_is_forgotten(const pinch_contact_store *store, const pinch_pair *pair);
/* Drops them, in step `now`. */
void pinch_drop_forgotten_pairs(pinch_contact_store *store, long now);

/*
 * Drops the pairs that were not handed over for this step, and brings the manifolds of the others up to date. The
 * manifold of a pair whose contacts came from the same poses as before is what it was. workers may be NULL. Returns
 * false when memory runs out.
 */
bool pinch_pairs_update(pinch_contact_store *store, const pinch_step_context *context, pinch_workers *workers);

#endif
