/*
 * Contacts found by several threads: the caller asks ODE for the pairs of geoms whose boxes overlap, and the others
 * look at the pairs that it has found so far, and then all at what is left. What they find is kept in the order of
 * pairs.
 */
#ifndef PINCH_CONTACTS_DETECTION_H
#define PINCH_CONTACTS_DETECTION_H

#include "util/list.h"
#include "util/workers.h"

#include <pinch/ode.h>
#include <stdatomic.h>

/* What a program asks for. */
typedef struct pinch_detection_request {
    dSpaceID space;
    int most; /* contacts of a pair */
    pinch_ode_near near;
    void *context;
} pinch_detection_request;

typedef struct pinch_near_pair {
    dGeomID geom[2];
    int first, count; /* its contacts in its batch */
} pinch_near_pair;

/* Pairs that one thread looks at. The next batch is in another cache line. */
enum { PINCH_NEAR_BATCH = 16 };
typedef struct pinch_near_batch {
    PINCH_LIST(dContact) contacts;
    char apart[64 - sizeof(void *) - 2 * sizeof(int)];
} pinch_near_batch;

typedef struct pinch_detection {
    pinch_detection_request request;
    PINCH_LIST(pinch_near_pair) pairs, late; /* late: those for which there was no room while threads looked */
    PINCH_LIST(pinch_near_batch) batches;
    int last;          /* pairs of the last detection */
    bool asked;        /* ODE has been asked */
    atomic_int found;  /* pairs that may be looked at; INT_MAX: all */
    atomic_int next;   /* that nobody has begun to look at */
    atomic_int status; /* pinch_status: what went wrong with a pair */
} pinch_detection;

void pinch_detection_free(pinch_detection *detection);
size_t pinch_detection_bytes(const pinch_detection *detection);

/* Tells whether there were so many pairs the last time that threads should share them. */
bool pinch_detection_is_shared(const pinch_detection *detection);

/* Finds all contacts of the pairs of geoms that ODE finds in the space, those in inner spaces included. */
pinch_status pinch_detect(pinch_detection *detection, pinch_workers *workers, const pinch_detection_request *request);

/* Returns the contacts of a pair, until the next detection. */
const dContact *pinch_detected(const pinch_detection *detection, int pair, int *count);

/* The same for one thread, which hands the contacts of each pair on as soon as they are found. */
typedef pinch_status pinch_take_contacts(void *context, dGeomID geom1, dGeomID geom2, const dContact *contacts,
                                         int count);
pinch_status pinch_detect_alone(pinch_detection *detection, const pinch_detection_request *request,
                                pinch_take_contacts *take, void *context);

#endif
