#include "contacts/detection.h"

#include <stdlib.h>
#include <string.h>

void pinch_detection_free(pinch_detection *d)
{
    for (int k = 0; k < d->batches.room; k++) {
        free(d->batches.items[k].pairs.items);
        free(d->batches.items[k].contacts.items);
    }
    for (int k = 0; k < PINCH_ODE_MOST_THREADS; k++) free(d->found[k].items);
    free(d->batches.items);
    pinch_near_pairs_free(&d->near);
    free(d->whole.items);
}

size_t pinch_detection_bytes(const pinch_detection *d)
{
    size_t bytes = pinch_near_pairs_bytes(&d->near) + PINCH_LIST_BYTES(d->whole) + PINCH_LIST_BYTES(d->batches);
    for (int k = 0; k < d->batches.room; k++)
        bytes += PINCH_LIST_BYTES(d->batches.items[k].pairs) + PINCH_LIST_BYTES(d->batches.items[k].contacts);
    for (int k = 0; k < PINCH_ODE_MOST_THREADS; k++) bytes += PINCH_LIST_BYTES(d->found[k]);
    return bytes;
}

/* Makes room for so many batches, new ones without contacts. Returns false when memory runs out. */
static bool reserve_batches(pinch_detection *d, int count)
{
    int before = d->batches.room;
    if (!PINCH_RESERVE(d->batches, count)) return false;
    for (int k = before; k < d->batches.room; k++) memset(&d->batches.items[k], 0, sizeof *d->batches.items);
    return true;
}

static void note_hit(void *context, dGeomID a, dGeomID b)
{
    (void)a, (void)b;
    *(bool *)context = true;
}

/* Has a pair looked at, whose contacts are put into `found`. ODE is asked first: geom classes of a program may tell by
 * a test of their own that a pair is apart (dGeomClass.aabb_test). */
static pinch_status look_at(const pinch_detection_request *r, pinch_near_pair *pair, pinch_found_contacts *found)
{
    bool may_touch = false;
    pair->points = (pinch_range){0, 0};
    pair->taken = false;
    found->count = 0;
    dSpaceCollide2(pair->geom[0], pair->geom[1], &may_touch, note_hit);
    if (!may_touch) return PINCH_OK;
    if (!PINCH_RESERVE(*found, r->most)) return PINCH_OUT_OF_MEMORY;
    found->count = r->near(r->context, pair->geom[0], pair->geom[1], r->most, found->items);
    if (found->count < 0 || found->count > r->most) return PINCH_INVALID_ARGUMENT;
    pair->points.count = found->count;
    return PINCH_OK;
}

static pinch_status hand_on(const pinch_near_pair *pair, const pinch_found_contacts *found,
                            const pinch_contact_sink *sink)
{
    const dBodyID body[2] = {dGeomGetBody(pair->geom[0]), dGeomGetBody(pair->geom[1])};
    pinch_status status = PINCH_OK;
    for (int k = 0; k < pair->points.count && status == PINCH_OK; k++)
        status = pinch_buffer_contact(sink, &found->items[pair->points.first + k], body[0], body[1]);
    return status;
}

/* ---- by several threads ---- */

typedef struct shared_detection {
    pinch_detection *detection;
    const pinch_contact_sink *sink;
    const pinch_near_space *space;         /* NULL: the pairs are listed */
    int items;                             /* geoms, or listed pairs */
    bool may_take_again;                   /* the buffer */
    bool has_data[PINCH_ODE_MOST_THREADS]; /* ODE's, of a thread */
} shared_detection;

static int batches_of(const shared_detection *s)
{
    return (s->items + PINCH_NEAR_BATCH - 1) / PINCH_NEAR_BATCH;
}

/* Finds the pairs of a batch. Returns false when memory runs out. */
static bool find_pairs(const shared_detection *s, int number, pinch_near_pair_list *pairs)
{
    int first = number * PINCH_NEAR_BATCH, count = s->items - first;
    if (count > PINCH_NEAR_BATCH) count = PINCH_NEAR_BATCH;
    pairs->count = 0;
    if (s->space) return pinch_near_pairs_from(s->space, first, first + count, pairs);
    if (!PINCH_RESERVE(*pairs, count)) return false;
    memcpy(pairs->items, s->detection->near.pairs.items + first, (size_t)count * sizeof *pairs->items);
    pairs->count = count;
    return true;
}

/* Takes the contacts found between a pair, or puts them among those that were not taken. left: places that the batch
 * had in the last step; place: where the contacts come if all go on as they were. */
static bool take_or_keep(const shared_detection *s, pinch_near_batch *batch, pinch_range *left, int place,
                         pinch_near_pair *pair, const pinch_found_contacts *found)
{
    int count = found->count;
    pinch_taken taken = pinch_take_again(s->sink, pair->geom, found->items, count, left);
    pair->taken = taken != PINCH_NOT_TAKEN;
    pair->points.first = pair->taken ? left->first - count : batch->contacts.count;
    batch->changed = batch->changed || taken == PINCH_TAKEN; /* of others it is seen as they are handed on */
    batch->out_of_place = batch->out_of_place || !pair->taken || pair->points.first != place;
    if (pair->taken) return true;
    if (!PINCH_RESERVE(batch->contacts, batch->contacts.count + count)) return false;
    memcpy(batch->contacts.items + batch->contacts.count, found->items, (size_t)count * sizeof *found->items);
    batch->contacts.count += count;
    return true;
}

static pinch_status look_at_batch(const shared_detection *s, int number, pinch_found_contacts *found)
{
    pinch_near_batch *batch = &s->detection->batches.items[number];
    pinch_range left = s->may_take_again ? batch->places : (pinch_range){0, 0};
    int place = batch->places.first;
    batch->contacts.count = 0;
    batch->changed = batch->out_of_place = false;
    if (!find_pairs(s, number, &batch->pairs)) return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < batch->pairs.count; k++) {
        pinch_near_pair *pair = &batch->pairs.items[k];
        pinch_status status = look_at(&s->detection->request, pair, found);
        if (status != PINCH_OK) return status;
        if (found->count > 0 && !take_or_keep(s, batch, &left, place, pair, found)) return PINCH_OUT_OF_MEMORY;
        place += found->count;
    }
    batch->places.count = place - batch->places.first;
    return PINCH_OK;
}

static void look_at_some(void *context, int worker, int first, int end)
{
    shared_detection *s = context;
    pinch_status status = PINCH_OK;
    if (worker > 0 && !s->has_data[worker]) s->has_data[worker] = dAllocateODEDataForThread(dAllocateMaskAll) != 0;
    if (worker > 0 && !s->has_data[worker]) status = PINCH_OUT_OF_MEMORY;
    pinch_found_contacts found = s->detection->found[worker]; /* the threads' own lie side by side */
    for (int b = first; b < end && status == PINCH_OK; b++) status = look_at_batch(s, b, &found);
    s->detection->found[worker] = found;
    if (status != PINCH_OK) atomic_store(&s->detection->status, (int)status);
}

/* Counts pairs and contacts, and gives each batch the places of its contacts. Tells whether all are in their places. */
static bool count_batches(const shared_detection *s, int *contacts)
{
    bool in_place = s->may_take_again;
    *contacts = s->detection->pairs_before = 0;
    for (int b = 0; b < batches_of(s); b++) {
        pinch_near_batch *batch = &s->detection->batches.items[b];
        in_place = in_place && !batch->out_of_place && (batch->places.count == 0 || batch->places.first == *contacts);
        batch->places.first = *contacts;
        *contacts += batch->places.count;
        s->detection->pairs_before += batch->pairs.count;
    }
    s->detection->batches_before = batches_of(s);
    return in_place;
}

/* Are all contacts that were taken those of the last step, to the bit? */
static bool all_unchanged(const shared_detection *s)
{
    bool unchanged = true;
    for (int b = 0; b < batches_of(s); b++) unchanged = unchanged && !s->detection->batches.items[b].changed;
    return unchanged;
}

/* Hands the contacts on that were not taken, in their order. Some may be none of Pinch's. */
static pinch_status hand_rest_on(const shared_detection *s)
{
    const pinch_contact_store *store = s->sink->store;
    for (int b = 0; b < batches_of(s); b++) {
        pinch_near_batch *batch = &s->detection->batches.items[b];
        for (int k = 0; k < batch->pairs.count && batch->contacts.count > 0; k++) {
            pinch_near_pair *pair = &batch->pairs.items[k];
            if (pair->taken || pair->points.count == 0) continue;
            int found = pair->points.count, first = store->buffer.count;
            pinch_status status = hand_on(pair, &batch->contacts, s->sink);
            if (status != PINCH_OK) return status;
            pair->points = (pinch_range){first, store->buffer.count - first};
            batch->places.count += pair->points.count - found;
        }
    }
    return PINCH_OK;
}

static void move_some(void *context, int worker, int first, int end)
{
    const shared_detection *s = context;
    (void)worker;
    for (int b = first; b < end; b++) {
        const pinch_near_batch *batch = &s->detection->batches.items[b];
        int place = batch->places.first;
        for (int k = 0; k < batch->pairs.count; k++) {
            const pinch_range points = batch->pairs.items[k].points;
            if (points.count > 0) pinch_move_contacts(s->sink->store, points, place);
            place += points.count;
        }
    }
}

/* Brings contacts that were taken and those that were not into the order of pairs. */
static pinch_status bring_together(pinch_workers *workers, shared_detection *s)
{
    pinch_contact_store *store = s->sink->store;
    int contacts;
    if (!pinch_begin_behind(store)) return PINCH_OUT_OF_MEMORY;
    pinch_status status = hand_rest_on(s);
    if (status != PINCH_OK) return status;
    (void)count_batches(s, &contacts);
    if (!pinch_begin_moving(store, contacts)) return PINCH_OUT_OF_MEMORY;
    pinch_workers_run(workers, move_some, s, batches_of(s), 1);
    pinch_end_moving(store, contacts, all_unchanged(s));
    return PINCH_OK;
}

static pinch_status detect_with(pinch_workers *workers, shared_detection *s)
{
    pinch_detection *d = s->detection;
    pinch_contact_store *store = s->sink->store;
    int contacts;
    if (!reserve_batches(d, batches_of(s))) return PINCH_OUT_OF_MEMORY;
    s->may_take_again = d->batches_before == batches_of(s) && pinch_may_take_again(store);
    atomic_store(&d->status, PINCH_OK);
    pinch_workers_run(workers, look_at_some, s, batches_of(s), 1);
    bool in_place = count_batches(s, &contacts);
    pinch_status status = (pinch_status)atomic_load(&d->status);
    if (status == PINCH_OK && !s->may_take_again) {
        status = hand_rest_on(s);
        (void)count_batches(s, &contacts); /* some may be none of Pinch's */
    } else if (status == PINCH_OK && in_place) {
        pinch_taken_again(store, contacts, all_unchanged(s));
    } else if (status == PINCH_OK) {
        status = bring_together(workers, s);
    }
    if (status != PINCH_OK && s->may_take_again) pinch_abandon_taken(store);
    return status;
}

/* ---- by one ---- */

static pinch_status detect_alone(pinch_detection *d, const pinch_contact_sink *sink)
{
    pinch_found_contacts *found = &d->found[0];
    pinch_status status = PINCH_OK;
    d->pairs_before = d->near.pairs.count;
    for (int k = 0; k < d->near.pairs.count && status == PINCH_OK; k++) {
        pinch_near_pair *pair = &d->near.pairs.items[k];
        status = look_at(&d->request, pair, found);
        if (status == PINCH_OK) status = hand_on(pair, found, sink);
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

/* Lists the pairs, with spaces opened. Returns false when memory runs out. */
static bool list_pairs(pinch_detection *d, const pinch_near_space *space, int geoms)
{
    return (!space || pinch_near_pairs_from(space, 0, geoms, &d->near.pairs)) &&
           (!d->near.with_spaces || open_spaces(d));
}

/* Are there height fields among the pairs? ODE moves what they meet to and fro while they collide, so that no other
 * thread may look at it: one does all then. */
static bool meets_fields(const pinch_detection *d)
{
    for (int k = 0; k < d->near.pairs.count; k++)
        for (int side = 0; side < 2; side++)
            if (dGeomGetClass(d->near.pairs.items[k].geom[side]) == dHeightfieldClass) return true;
    return false;
}

pinch_status pinch_detect(pinch_detection *d, pinch_workers *workers, const pinch_detection_request *request,
                          const pinch_contact_sink *sink)
{
    enum { FEW = 256 /* pairs */ };
    shared_detection shared = {.detection = d, .sink = sink};
    d->request = *request;
    if (d->pairs_before <= FEW) workers = NULL;
    pinch_workers_call(workers);
    if (!pinch_find_neighbours(&d->near, workers, request->space, &shared.space, &shared.items))
        return PINCH_OUT_OF_MEMORY;
    if (workers && shared.space && !d->near.with_spaces && !d->near.with_fields) return detect_with(workers, &shared);
    if (!list_pairs(d, shared.space, shared.items)) return PINCH_OUT_OF_MEMORY;
    shared.space = NULL;
    shared.items = d->near.pairs.count;
    return workers && !meets_fields(d) ? detect_with(workers, &shared) : detect_alone(d, sink);
}

pinch_status pinch_each_pair(pinch_detection *d, dSpaceID space, void *context, dNearCallback *near)
{
    if (!pinch_find_near_pairs(&d->near, space)) return PINCH_OUT_OF_MEMORY;
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
