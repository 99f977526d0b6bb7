/* Contacts of all pairs of geoms of a space, for pinch_ode_collide. What threads find is kept in the order of pairs. */
#ifndef PINCH_CONTACTS_DETECTION_H
#define PINCH_CONTACTS_DETECTION_H

#include "contacts/contact_buffer.h"
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

/* What one thread looks at: so many listed pairs, or the pairs of so many geoms. The next batch is in another cache
 * line. */
enum { PINCH_NEAR_BATCH = 16 };
typedef PINCH_LIST(dContact) pinch_found_contacts;
typedef struct pinch_near_batch {
    pinch_near_pair_list pairs;
    pinch_found_contacts contacts; /* that were not taken */
    pinch_range places;            /* of its contacts, in the last detection by several threads; then in this one */
    bool changed;                  /* some are not those of the last step, to the bit */
    bool out_of_place;             /* some are not in these places */
    char apart[64 - 2 * sizeof(void *) - 7 * sizeof(int)];
} pinch_near_batch;

typedef struct pinch_detection {
    pinch_detection_request request;
    pinch_near_pairs near;
    pinch_near_pair_list whole; /* the pairs before those with spaces were opened */
    PINCH_LIST(pinch_near_batch) batches;
    int pairs_before;                                   /* in the last detection */
    int batches_before;                                 /* in the last detection by several threads */
    pinch_found_contacts found[PINCH_ODE_MOST_THREADS]; /* scratch of each thread: of one pair */
    atomic_int status;                                  /* pinch_status: what went wrong with a pair */
} pinch_detection;

void pinch_detection_free(pinch_detection *detection);
size_t pinch_detection_bytes(const pinch_detection *detection);

/* Finds the contacts of all pairs and buffers them, in the order of pairs. workers may be NULL. */
pinch_status pinch_detect(pinch_detection *detection, pinch_workers *workers, const pinch_detection_request *request,
                          const pinch_contact_sink *sink);

/* Calls `near` for each pair, spaces unopened. */
pinch_status pinch_each_pair(pinch_detection *detection, dSpaceID space, void *context, dNearCallback *near);

#endif
