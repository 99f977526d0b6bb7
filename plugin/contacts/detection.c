#include "contacts/detection.h"

#include <stdlib.h>
#include <string.h>

void pinch_detection_free(pinch_detection *d)
{
    for (int k = 0; k < d->batches.room; k++) free(d->batches.items[k].contacts.items);
    free(d->batches.items);
    pinch_near_pairs_free(&d->near);
    free(d->whole.items);
}

size_t pinch_detection_bytes(const pinch_detection *d)
{
    size_t bytes = pinch_near_pairs_bytes(&d->near) + PINCH_LIST_BYTES(d->whole) + PINCH_LIST_BYTES(d->batches);
    for (int k = 0; k < d->batches.room; k++) bytes += PINCH_LIST_BYTES(d->batches.items[k].contacts);
    return bytes;
}

/* Makes room for batches of this many pairs, new ones without contacts. Returns false when memory runs out. */
static bool reserve_batches(pinch_detection *d, int pairs)
{
    int before = d->batches.room;
    if (!PINCH_RESERVE(d->batches, pairs / PINCH_NEAR_BATCH + 1)) return false;
    for (int k = before; k < d->batches.room; k++) d->batches.items[k] = (pinch_near_batch){.contacts = {NULL, 0, 0}};
    return true;
}

static void note_hit(void *context, dGeomID a, dGeomID b)
{
    (void)a, (void)b;
    *(bool *)context = true;
}

/* Has a pair looked at, whose contacts go to the end of the batch. ODE is asked first: geom classes of a program may
 * tell by a test of their own that a pair is apart (dGeomClass.aabb_test). */
static pinch_status look_at(const pinch_detection_request *r, pinch_near_pair *pair, pinch_near_batch *into)
{
    bool may_touch = false;
    pair->points = (pinch_range){into->contacts.count, 0};
    dSpaceCollide2(pair->geom[0], pair->geom[1], &may_touch, note_hit);
    if (!may_touch) return PINCH_OK;
    if (!PINCH_RESERVE(into->contacts, into->contacts.count + r->most)) return PINCH_OUT_OF_MEMORY;
    dContact *room = into->contacts.items + into->contacts.count;
    int found = r->near(r->context, pair->geom[0], pair->geom[1], r->most, room);
    if (found < 0 || found > r->most) return PINCH_INVALID_ARGUMENT;
    pair->points.count = found;
    into->contacts.count += found;
    return PINCH_OK;
}

static pinch_status hand_on(const pinch_near_pair *pair, const pinch_near_batch *found, pinch_take_contacts *take,
                            void *context)
{
    if (pair->points.count == 0) return PINCH_OK;
    return take(context, pair->geom[0], pair->geom[1], found->contacts.items + pair->points.first, pair->points.count);
}

/* ---- by several threads ---- */

typedef struct shared_detection {
    pinch_detection *detection;
    bool has_data[PINCH_ODE_MOST_THREADS]; /* ODE's, of a thread */
} shared_detection;

static pinch_status look_at_batch(pinch_detection *d, int number)
{
    int first = number * PINCH_NEAR_BATCH, end = first + PINCH_NEAR_BATCH, count = d->near.pairs.count;
    pinch_near_batch *batch = &d->batches.items[number];
    pinch_status status = PINCH_OK;
    batch->contacts.count = 0;
    for (int k = first; k < end && k < count && status == PINCH_OK; k++)
        status = look_at(&d->request, &d->near.pairs.items[k], batch);
    return status;
}

static void look_at_some(void *context, int worker, int first, int end)
{
    shared_detection *s = context;
    pinch_detection *d = s->detection;
    pinch_status status = PINCH_OK;
    if (worker > 0 && !s->has_data[worker]) s->has_data[worker] = dAllocateODEDataForThread(dAllocateMaskAll) != 0;
    if (worker > 0 && !s->has_data[worker]) status = PINCH_OUT_OF_MEMORY;
    for (int b = first; b < end && status == PINCH_OK; b++) status = look_at_batch(d, b);
    if (status != PINCH_OK) atomic_store(&d->status, (int)status);
}

static pinch_status detect_with(pinch_workers *workers, pinch_detection *d, pinch_take_contacts *take, void *context)
{
    int count = d->near.pairs.count;
    shared_detection shared = {.detection = d};
    if (!reserve_batches(d, count)) return PINCH_OUT_OF_MEMORY;
    atomic_store(&d->status, PINCH_OK);
    pinch_workers_run(workers, look_at_some, &shared, (count + PINCH_NEAR_BATCH - 1) / PINCH_NEAR_BATCH, 1);
    pinch_status status = (pinch_status)atomic_load(&d->status);
    for (int k = 0; k < count && status == PINCH_OK; k++)
        status = hand_on(&d->near.pairs.items[k], &d->batches.items[k / PINCH_NEAR_BATCH], take, context);
    return status;
}

/* ---- by one ---- */

static pinch_status detect_alone(pinch_detection *d, pinch_take_contacts *take, void *context)
{
    if (!reserve_batches(d, 0)) return PINCH_OUT_OF_MEMORY;
    pinch_near_batch *batch = d->batches.items;
    pinch_status status = PINCH_OK;
    for (int k = 0; k < d->near.pairs.count && status == PINCH_OK; k++) {
        pinch_near_pair *pair = &d->near.pairs.items[k];
        batch->contacts.count = 0;
        status = look_at(&d->request, pair, batch);
        if (status == PINCH_OK) status = hand_on(pair, batch, take, context);
    }
    return status;
}

/* ---- pairs ---- */

static void look_inside(void *near, dGeomID a, dGeomID b)
{
    if (dGeomIsSpace(a) || dGeomIsSpace(b))
        dSpaceCollide2(a, b, near, look_inside);
    else
        pinch_note_near_pair(near, a, b);
}

/* Puts pairs of geoms in the places of pairs with spaces. */
static bool open_spaces(pinch_detection *d)
{
    int count = d->near.pairs.count;
    if (!PINCH_RESERVE(d->whole, count)) return false;
    if (count > 0) memcpy(d->whole.items, d->near.pairs.items, (size_t)count * sizeof *d->whole.items);
    d->near.pairs.count = 0;
    for (int k = 0; k < count; k++) look_inside(&d->near, d->whole.items[k].geom[0], d->whole.items[k].geom[1]);
    return !d->near.no_memory;
}

pinch_status pinch_detect(pinch_detection *d, pinch_workers *workers, const pinch_detection_request *request,
                          pinch_take_contacts *take, void *context)
{
    enum { FEW = 256 /* pairs */ };
    d->request = *request;
    bool shared = workers && d->near.pairs.count > FEW; /* in the last detection */
    if (shared) pinch_workers_call(workers);
    if (!pinch_find_near_pairs(&d->near, shared ? workers : NULL, request->space)) return PINCH_OUT_OF_MEMORY;
    if (d->near.with_spaces && !open_spaces(d)) return PINCH_OUT_OF_MEMORY;
    return shared ? detect_with(workers, d, take, context) : detect_alone(d, take, context);
}

pinch_status pinch_each_pair(pinch_detection *d, dSpaceID space, void *context, dNearCallback *near)
{
    if (!pinch_find_near_pairs(&d->near, NULL, space)) return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < d->near.pairs.count; k++) {
        const pinch_near_pair *pair = &d->near.pairs.items[k];
        if (!dGeomIsEnabled(pair->geom[0]) || !dGeomIsEnabled(pair->geom[1])) continue; /* `near` may disable geoms */
        if (d->near.with_spaces && (dGeomIsSpace(pair->geom[0]) || dGeomIsSpace(pair->geom[1])))
            near(context, pair->geom[0], pair->geom[1]);
        else
            dSpaceCollide2(pair->geom[0], pair->geom[1], context, near);
    }
    return PINCH_OK;
}
