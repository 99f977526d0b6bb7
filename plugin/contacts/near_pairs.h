/*
 * The pairs of geoms of a space whose boxes overlap, as dSpaceCollide finds them, for pinch_ode_collide.
 *
 * Neighbours are kept from step to step. Each geom has a reach, a box around its own that goes beyond it by a part of
 * its size and by what it will move in the next steps. Geoms are neighbours while their reaches overlap, and are looked
 * for anew only when one has left its reach. In each step the boxes of neighbours are compared, no others. So the reach
 * decides what a step costs, and never which pairs there are.
 *
 * Pairs come in the order in which their geoms were first listed: the oldest first in spaces that put new geoms first,
 * as ODE's simple and hash spaces do. ODE's own order changes with each geom that moves.
 */
#ifndef PINCH_CONTACTS_NEAR_PAIRS_H
#define PINCH_CONTACTS_NEAR_PAIRS_H

#include "util/list.h"
#include "util/workers.h"

#include <ode/ode.h>
#include <pinch/problem.h>

typedef struct pinch_near_pair {
    dGeomID geom[2];
    pinch_range points; /* for who looks at the pair: the places of its contacts, */
    bool taken;         /* which are in the contact buffer, or else in a list of those that are not */
} pinch_near_pair;

typedef PINCH_LIST(pinch_near_pair) pinch_near_pair_list;

typedef struct pinch_near_space pinch_near_space;

/* Everything starts as 0. */
typedef struct pinch_near_pairs {
    pinch_near_pair_list pairs;
    PINCH_LIST(pinch_near_space *) spaces; /* those that were asked about, with their neighbours */
    bool with_spaces, with_fields;         /* spaces, height fields among the geoms */
    bool no_memory;                        /* for a pair that was to be noted */
    unsigned long calls;
} pinch_near_pairs;

void pinch_near_pairs_free(pinch_near_pairs *near);
size_t pinch_near_pairs_bytes(const pinch_near_pairs *near);

/* Finds the pairs that dSpaceCollide would call back for. Returns false when memory runs out. */
bool pinch_find_near_pairs(pinch_near_pairs *near, dSpaceID space);

/* The same in two parts, for several threads. The first brings the neighbours of so many *geoms up to date. workers may
 * be NULL. Where *found is NULL, it has found all pairs. Returns false when memory runs out. */
bool pinch_find_neighbours(pinch_near_pairs *near, pinch_workers *workers, dSpaceID space,
                           const pinch_near_space **found, int *geoms);
/* Appends the pairs of geoms first to end - 1 with later ones. Any thread may ask. Returns false when memory runs out.
 */
bool pinch_near_pairs_from(const pinch_near_space *space, int first, int end, pinch_near_pair_list *to);

/* Forgets a geom, or a space: what ODE puts in the same place of memory is a new one, and comes last. */
void pinch_near_forget(pinch_near_pairs *near, dGeomID geom);

/* What a snapshot keeps, of what is not forgotten: the geoms of the k-th space in their order. */
enum { PINCH_NEAR_MOST_SPACES = 8 };
void pinch_near_drop_forgotten(pinch_near_pairs *near); /* to be called before the others */
int pinch_near_count(const pinch_near_pairs *near, int space);
/* It may have been destroyed. */
dGeomID pinch_near_geom(const pinch_near_pairs *near, int space, int place);
/* Remembers a space that is not known yet. Those of the geoms that it has are first in the order given, when pairs are
 * found the next time. PINCH_OUT_OF_MEMORY; PINCH_INVALID_ARGUMENT where one is there twice. */
pinch_status pinch_near_remember(pinch_near_pairs *near, dSpaceID space, const dGeomID *geoms, int count);

/* A near callback of ODE's, whose context is a pinch_near_pairs: appends a pair, or notes that there is no memory. */
void pinch_note_near_pair(void *near, dGeomID geom1, dGeomID geom2);

#endif
