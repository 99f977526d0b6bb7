#include "contacts/detection.h"

#include "support/await.h"

#include <limits.h>
#include <stdlib.h>

void pinch_detection_free(pinch_detection *d)
{
    for (int k = 0; k < d->batches.room; k++) free(d->batches.items[k].contacts.items);
    free(d->batches.items);
    free(d->pairs.items);
    free(d->late.items);
}

size_t pinch_detection_bytes(const pinch_detection *d)
{
    size_t bytes = PINCH_LIST_BYTES(d->pairs) + PINCH_LIST_BYTES(d->late) + PINCH_LIST_BYTES(d->batches);
    for (int k = 0; k < d->batches.room; k++) bytes += PINCH_LIST_BYTES(d->batches.items[k].contacts);
    return bytes;
}

/* ---- pairs ---- */

typedef struct inner_pairs {
    void *context;
    dNearCallback *pair;
} inner_pairs;

static void look_inside(void *data, dGeomID a, dGeomID b)
{
    const inner_pairs *of = data;
    if (dGeomIsSpace(a) || dGeomIsSpace(b))
        dSpaceCollide2(a, b, data, look_inside);
    else
        of->pair(of->context, a, b);
}

static void for_each_pair(dSpaceID space, void *context, dNearCallback *pair)
{
    inner_pairs of = {context, pair};
    dSpaceCollide(space, &of, look_inside);
}

static void note_pair(void *data, dGeomID a, dGeomID b)
{
    pinch_detection *d = data;
    const pinch_near_pair pair = {.geom = {a, b}};
    if (d->pairs.count < d->pairs.room) { /* which others read */
        d->pairs.items[d->pairs.count++] = pair;
        pinch_say(&d->found, d->pairs.count);
    } else if (PINCH_RESERVE(d->late, d->late.count + 1)) {
        d->late.items[d->late.count++] = pair;
    } else {
        atomic_store(&d->status, PINCH_OUT_OF_MEMORY);
    }
}

/* ---- their contacts ---- */

/* Has a pair looked at, whose contacts go to the end of the list. Returns how many they are. */
static pinch_status find_contacts(const pinch_detection_request *r, const dGeomID geom[2], pinch_near_batch *into,
                                  int *count)
{
    *count = 0;
    if (!PINCH_RESERVE(into->contacts, into->contacts.count + r->most)) return PINCH_OUT_OF_MEMORY;
    int found = r->near(r->context, geom[0], geom[1], r->most, into->contacts.items + into->contacts.count);
    if (found < 0 || found > r->most) return PINCH_INVALID_ARGUMENT;
    *count = found;
    into->contacts.count += found;
    return PINCH_OK;
}

static void look_at(pinch_detection *d, int k)
{
    pinch_near_pair *pair = &d->pairs.items[k];
    pinch_near_batch *batch = &d->batches.items[k / PINCH_NEAR_BATCH];
    pair->first = batch->contacts.count;
    pinch_status status = find_contacts(&d->request, pair->geom, batch, &pair->count);
    if (status != PINCH_OK) atomic_store(&d->status, (int)status);
}

static void look_at_found(pinch_detection *d)
{
    for (;;) {
        int first = atomic_fetch_add(&d->next, PINCH_NEAR_BATCH), end = first + PINCH_NEAR_BATCH;
        pinch_await(&d->found, end);
        if (atomic_load(&d->found) == INT_MAX && end > d->pairs.count) end = d->pairs.count;
        if (first >= end) return;
        for (int k = first; k < end; k++) look_at(d, k);
    }
}

/* There is one call for each thread at least, as none ends before the caller has asked ODE. */
static void detect_part(void *context, int worker, int first, int end)
{
    pinch_detection *d = context;
    (void)first, (void)end;
    if (worker == 0 && !d->asked) {
        d->asked = true;
        for_each_pair(d->request.space, d, note_pair);
        pinch_say(&d->found, INT_MAX);
    }
    if (worker > 0 && !dAllocateODEDataForThread(dAllocateMaskAll))
        pinch_await(&d->found, INT_MAX);
    else
        look_at_found(d);
}

/* Makes room for batches of this many pairs, new ones without contacts. Returns false when memory runs out. */
static bool reserve_batches(pinch_detection *d, int pairs)
{
    int before = d->batches.room;
    if (!PINCH_RESERVE(d->batches, pairs / PINCH_NEAR_BATCH + 1)) return false;
    for (int k = before; k < d->batches.room; k++) d->batches.items[k] = (pinch_near_batch){.contacts = {NULL, 0, 0}};
    return true;
}

bool pinch_detection_is_shared(const pinch_detection *d)
{
    enum { FEW = 256 };
    return d->last > FEW;
}

pinch_status pinch_detect(pinch_detection *d, pinch_workers *workers, const pinch_detection_request *request)
{
    d->request = *request;
    d->pairs.count = d->late.count = 0;
    if (!PINCH_RESERVE(d->pairs, d->last + d->last / 4) || !reserve_batches(d, d->pairs.room))
        return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < d->batches.room; k++) d->batches.items[k].contacts.count = 0;
    d->asked = false;
    atomic_store(&d->found, 0);
    atomic_store(&d->next, 0);
    atomic_store(&d->status, PINCH_OK);
    pinch_workers_run(workers, detect_part, d, PINCH_ODE_MOST_THREADS, 1);
    int count = d->pairs.count;
    d->last = d->pairs.count + d->late.count;
    if (!PINCH_RESERVE(d->pairs, d->last) || !reserve_batches(d, d->last)) return PINCH_OUT_OF_MEMORY;
    d->pairs.count = d->last;
    for (int k = 0; k < d->late.count; k++) {
        d->pairs.items[count + k] = d->late.items[k];
        look_at(d, count + k);
    }
    return (pinch_status)atomic_load(&d->status);
}

const dContact *pinch_detected(const pinch_detection *d, int pair, int *count)
{
    const pinch_near_pair *of = &d->pairs.items[pair];
    *count = of->count;
    return d->batches.items[pair / PINCH_NEAR_BATCH].contacts.items + of->first;
}

/* ---- by one thread ---- */

typedef struct lone_detection {
    pinch_detection *detection;
    pinch_take_contacts *take;
    void *context;
    int pairs;
    pinch_status status;
} lone_detection;

static void look_and_take(void *context, dGeomID a, dGeomID b)
{
    lone_detection *l = context;
    const dGeomID geom[2] = {a, b};
    pinch_near_batch *batch = l->detection->batches.items;
    int count;
    if (l->status != PINCH_OK) return;
    l->pairs++;
    batch->contacts.count = 0;
    l->status = find_contacts(&l->detection->request, geom, batch, &count);
    if (l->status == PINCH_OK && count > 0) l->status = l->take(l->context, a, b, batch->contacts.items, count);
}

pinch_status pinch_detect_alone(pinch_detection *d, const pinch_detection_request *request, pinch_take_contacts *take,
                                void *context)
{
    lone_detection l = {d, take, context, 0, PINCH_OK};
    d->request = *request;
    if (!reserve_batches(d, 0)) return PINCH_OUT_OF_MEMORY;
    for_each_pair(request->space, &l, look_and_take);
    d->last = l.pairs;
    return l.status;
}
