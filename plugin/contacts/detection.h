/* Contacts of all pairs of geoms of a space, for pinch_ode_collide. What threads find is kept in the order of pairs. */
#ifndef PINCH_CONTACTS_DETECTION_H
#define PINCH_CONTACTS_DETECTION_H

#include "contacts/near_pairs.h"

#include <pinch/ode.h>
#include <stdatomic.h>

/* What a program asks for. */
typedef struct pinch_detection_request {
    dSpaceID space;
    int most; /* contacts of a pair */
    pinch_ode_near near;
    void *context;
} pinch_detection_request;

/* Pairs that one thread looks at. The next batch is in another cache line. */
enum { PINCH_NEAR_BATCH = 16 };
typedef struct pinch_near_batch {
    PINCH_LIST(dContact) contacts;
    char apart[64 - sizeof(void *) - 2 * sizeof(int)];
} pinch_near_batch;

typedef struct pinch_detection {
    pinch_detection_request request;
    pinch_near_pairs near;
    PINCH_LIST(pinch_near_pair) whole; /* the pairs before those with spaces were opened */
    PINCH_LIST(pinch_near_batch) batches;
    atomic_int status; /* pinch_status: what went wrong with a pair */
} pinch_detection;

/* Takes the contacts of a pair, which have at least one. */
typedef pinch_status pinch_take_contacts(void *context, dGeomID geom1, dGeomID geom2, const dContact *contacts,
                                         int count);

void pinch_detection_free(pinch_detection *detection);
size_t pinch_detection_bytes(const pinch_detection *detection);

/* Finds the contacts of all pairs and hands them on, pair by pair, from the calling thread. workers may be NULL. */
pinch_status pinch_detect(pinch_detection *detection, pinch_workers *workers, const pinch_detection_request *request,
                          pinch_take_contacts *take, void *context);

/* Calls `near` for each pair, spaces unopened. */
pinch_status pinch_each_pair(pinch_detection *detection, dSpaceID space, void *context, dNearCallback *near);

#endif
