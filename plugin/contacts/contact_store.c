#include "contacts/contact_store.h"

#include "collision/ode/collide.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void pinch_contact_store_init(pinch_contact_store *store)
{
    memset(store, 0, sizeof *store);
    mtx_init(&store->workers_lock, mtx_plain);
    store->points.item_size = sizeof(pinch_manifold_point);
    store->own_laws.item_size = sizeof(pinch_own_law);
    store->last_surface = store->last_given.surface = -1;
}

/* All lists and indices of the store. */
/* clang-format off */
#define LISTS(X)                                                                                                       \
    X(geoms); X(seen_poses); X(materials); X(pairs); X(pairs_by_island); X(surfaces); X(surface_places);               \
    X(buffer); X(directions); X(put_aside.contacts); X(put_aside.directions); X(contact_joints); X(results)
#define INDICES(X) X(geom_index); X(pair_index); X(surface_index)
#define FREE_LIST(list)    free(store->list.items)
#define FREE_INDEX(index)  pinch_item_index_free(&store->index)
#define ADD_LIST(list)     bytes += PINCH_LIST_BYTES(store->list)
#define ADD_INDEX(index)   bytes += pinch_item_index_bytes(&store->index)
/* clang-format on */

static void free_contents(pinch_contact_store *store)
{
    LISTS(FREE_LIST);
    for (int i = 0; i < PINCH_ODE_MOST_THREADS; i++) free(store->detected[i].items);
    INDICES(FREE_INDEX);
    pinch_key_map_free(&store->forgotten_bodies);
    pinch_block_pool_free(&store->points);
    pinch_block_pool_free(&store->own_laws);
}

void pinch_contact_store_free(pinch_contact_store *store)
{
    free_contents(store);
    mtx_destroy(&store->workers_lock);
}

void pinch_contact_store_take(pinch_contact_store *store, pinch_contact_store *other)
{
    free_contents(store);
    memcpy(store, other, offsetof(pinch_contact_store, workers_lock));
    mtx_destroy(&other->workers_lock);
}

size_t pinch_contact_store_bytes(const pinch_contact_store *store)
{
    size_t bytes = store->points.bytes + store->own_laws.bytes;
    LISTS(ADD_LIST);
    for (int i = 0; i < PINCH_ODE_MOST_THREADS; i++) bytes += PINCH_LIST_BYTES(store->detected[i]);
    INDICES(ADD_INDEX);
    bytes += PINCH_LIST_BYTES(store->forgotten_bodies.entries) + pinch_item_index_bytes(&store->forgotten_bodies.index);
    return bytes;
}

void pinch_invalidate_step_cache(pinch_contact_store *store)
{
    store->buffered_before = store->directions_before = -1;
    store->same_places = store->same_bodies = store->unchanged = false;
}

/* ---- geoms ---- */

/* Returns the diagonal of the box with a body's mass and inertia. With sides a, b and c the trace of the inertia is
 * m (a^2 + b^2 + c^2)/6. */
static double size_of_body(dBodyID body)
{
    dMass mass;
    if (!body || dBodyIsKinematic(body)) return INFINITY;
    dBodyGetMass(body, &mass);
    return sqrt(6 * (mass.I[0] + mass.I[5] + mass.I[10]) / mass.mass);
}

/* Returns the diagonal of the box around a geom in its own axes. That of its box in the world would depend on how it
 * lies, and with it which contacts are one and the same: a scene that is turned would do something else. */
static double size_of_geom(dGeomID geom)
{
    if (dGeomGetClass(geom) == dPlaneClass) return INFINITY;
    double sides[3], diagonal = 0;
    if (!pinch_own_sides(geom, sides)) {
        dReal box[6];
        dGeomGetAABB(geom, box);
        for (int i = 0; i < 3; i++) sides[i] = box[2 * i + 1] - box[2 * i];
    }
    for (int i = 0; i < 3; i++) diagonal = hypot(diagonal, sides[i]);
    return diagonal;
}

static pinch_item_keys geom_keys(const pinch_contact_store *store)
{
    return PINCH_ITEM_KEYS(store->geoms, pinch_geom_record, key);
}

int pinch_find_geom(const pinch_contact_store *store, dGeomID geom)
{
    uint64_t key = (uintptr_t)geom;
    return pinch_item_index_get(&store->geom_index, geom_keys(store), &key);
}

static uint64_t key_of_side(dGeomID geom, dBodyID body)
{
    return geom ? (uintptr_t)geom : (uintptr_t)body | 1;
}

int pinch_add_side(pinch_contact_store *store, dGeomID geom, dBodyID body)
{
    uint64_t key = key_of_side(geom, body);
    int index = pinch_item_index_get(&store->geom_index, geom_keys(store), &key);
    if (index >= 0) {
        /* a body in the same place of memory may be another one now, and its mass may have changed */
        pinch_geom_record *known = &store->geoms.items[index];
        if (known->number == 0) known->number = ++store->last_number;
        if (!geom)
            known->size = size_of_body(body);
        else if (known->size < 0)
            known->size = size_of_geom(geom);
        return index;
    }
    if (!PINCH_RESERVE(store->geoms, store->geoms.count + 1) ||
        !pinch_item_index_add(&store->geom_index, geom_keys(store), &key, store->geoms.count))
        return -1;
    pinch_geom_record *record = &store->geoms.items[store->geoms.count];
    memset(record, 0, sizeof *record);
    record->key = key;
    record->geom = geom;
    record->body = geom ? NULL : body;
    record->size = geom ? size_of_geom(geom) : size_of_body(body);
    record->material = -1;
    record->number = ++store->last_number;
    return store->geoms.count++;
}

void pinch_forget_side(pinch_contact_store *store, dGeomID geom, dBodyID body)
{
    uint64_t key = key_of_side(geom, body);
    int index = pinch_item_index_get(&store->geom_index, geom_keys(store), &key);
    if (index < 0) return;
    store->geoms.items[index].number = 0;
    store->geoms.items[index].size = -1; /* what comes back may have another shape */
    if (index < store->seen_poses.count) store->seen_poses.items[index].step = -1;
}

/*
 * A heightfield may be made without a pose, and ODE does not tell: it ends the program that asks for one. So it is
 * asked with a handler in place that comes back, by one thread at a time.
 */
static pthread_mutex_t asking = PTHREAD_MUTEX_INITIALIZER;
static _Thread_local jmp_buf *no_pose; /* where this thread asks */
static dMessageFunction *handler_before;

static void come_back(int number, const char *message, va_list arguments)
{
    if (no_pose) longjmp(*no_pose, 1);
    if (handler_before) handler_before(number, message, arguments); /* of another thread, and another fault */
}

static bool heightfield_has_pose(dGeomID heightfield)
{
    jmp_buf here;
    volatile bool has = false;
    pthread_mutex_lock(&asking);
    handler_before = dGetDebugHandler();
    dSetDebugHandler(come_back);
    no_pose = &here;
    if (setjmp(here) == 0) has = dGeomGetPosition(heightfield) != NULL; /* without assertions, ODE returns that */
    no_pose = NULL;
    dSetDebugHandler(handler_before);
    pthread_mutex_unlock(&asking);
    return has;
}

bool pinch_geom_has_pose(dGeomID geom)
{
    int class = dGeomGetClass(geom);
    return class != dPlaneClass && (class != dHeightfieldClass || heightfield_has_pose(geom));
}

pinch_pose pinch_side_pose(dGeomID geom, dBodyID body)
{
    static const double ORIGIN[3] = {0, 0, 0}, IDENTITY[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    pinch_pose pose = {ORIGIN, IDENTITY};
    if (!geom && body) {
        pose.position = dBodyGetPosition(body);
        pose.rotation = dBodyGetRotation(body);
    } else if (geom && pinch_geom_has_pose(geom)) {
        pose.position = dGeomGetPosition(geom);
        pose.rotation = dGeomGetRotation(geom);
    }
    return pose;
}

bool pinch_geom_stays(pinch_contact_store *store, int record, long now)
{
    if (!PINCH_RESERVE(store->seen_poses, store->geoms.count)) return false;
    while (store->seen_poses.count < store->geoms.count) store->seen_poses.items[store->seen_poses.count++].step = -1;
    pinch_seen_pose *seen = &store->seen_poses.items[record];
    if (seen->step == now) return seen->stays;
    pinch_pose pose = pinch_side_pose(store->geoms.items[record].geom, store->geoms.items[record].body);
    double values[12];
    memcpy(values, pose.position, 3 * sizeof *values);
    for (int row = 0; row < 3; row++) memcpy(values + 3 + 3 * row, pose.rotation + 4 * row, 3 * sizeof *values);
    seen->stays = seen->step >= 0 && seen->step == now - 1 && memcmp(values, seen->pose, sizeof values) == 0;
    memcpy(seen->pose, values, sizeof values);
    seen->step = now;
    return seen->stays;
}

/*
 * ---- surface parameters ----
 *
 * Each is kept once: most contacts of a scene share theirs with many others. What no contact uses any more is dropped
 * whenever the list has grown by half.
 */

static uint64_t key_of(const pinch_surface *surface)
{
    uint64_t key = 0, word;
    _Static_assert(sizeof *surface % sizeof word == 0, "a surface is made of words");
    for (size_t at = 0; at < sizeof *surface; at += sizeof word) {
        memcpy(&word, (const unsigned char *)surface + at, sizeof word);
        key = (key ^ word) * 0x9E3779B97F4A7C15u; /* 2^64 over the golden ratio */
        key ^= key >> 32;
    }
    return key;
}

static pinch_item_keys surface_keys(const pinch_contact_store *store)
{
    return PINCH_ITEM_KEYS(store->surfaces, pinch_kept_surface, key);
}

bool pinch_is_kept_surface(const pinch_contact_store *store, int index, const pinch_surface *surface)
{
    return memcmp(&store->surfaces.items[index].surface, surface, sizeof *surface) == 0;
}

/* Returns the index of a surface, -1 where it is not in the list; *key is the one it has, or is to have. */
static int look_up(const pinch_contact_store *store, const pinch_surface *surface, uint64_t *key)
{
    int index;
    for (*key = key_of(surface); (index = pinch_item_index_get(&store->surface_index, surface_keys(store), key)) >= 0;
         (*key)++)
        if (pinch_is_kept_surface(store, index, surface)) return index;
    return -1;
}

/* Calls visit for every place where the index of a surface is kept. */
static void for_each_use(pinch_contact_store *store, void (*visit)(int *index, int *place), int *place)
{
    int buffered = store->buffer.count;
    if (!store->put_aside.any && buffered < store->buffered_before) buffered = store->buffered_before;
    for (int i = 0; i < buffered; i++)
        if (store->buffer.items[i].surface >= 0) visit(&store->buffer.items[i].surface, place);
    for (int i = 0; i < store->put_aside.contacts.count; i++)
        if (store->put_aside.contacts.items[i].surface >= 0) visit(&store->put_aside.contacts.items[i].surface, place);
    for (int i = 0; i < store->pairs.count; i++) {
        const pinch_manifold *manifold = &store->pairs.items[i].manifold;
        for (int k = 0; k < manifold->count; k++)
            if (manifold->point[k].own) visit(&manifold->point[k].own->surface, place);
    }
}

static void mark_used(int *index, int *place)
{
    place[*index] = 1;
}

static void move_to_place(int *index, int *place)
{
    *index = place[*index];
}

/* Drops the surfaces that no contact uses. Returns false when memory runs out. */
static bool sweep(pinch_contact_store *store)
{
    int kept = 0, count = store->surfaces.count;
    if (!PINCH_RESERVE(store->surface_places, count)) return false;
    int *place = store->surface_places.items;
    memset(place, 0, sizeof *place * (size_t)count);
    for_each_use(store, mark_used, place);
    for (int i = 0; i < count; i++) {
        if (!place[i]) continue;
        store->surfaces.items[kept] = store->surfaces.items[i];
        place[i] = kept++;
    }
    for_each_use(store, move_to_place, place);
    store->surfaces.count = 0;
    pinch_item_index_clear(&store->surface_index);
    for (; store->surfaces.count < kept; store->surfaces.count++) { /* cannot fail: the index has been larger */
        pinch_kept_surface *surface = &store->surfaces.items[store->surfaces.count];
        (void)look_up(store, &surface->surface, &surface->key);
        (void)pinch_item_index_add(&store->surface_index, surface_keys(store), &surface->key, store->surfaces.count);
    }
    store->last_surface = store->last_given.surface = -1;
    return true;
}

int pinch_keep_surface(pinch_contact_store *store, const pinch_surface *surface, int guess)
{
    enum { FEWEST = 16 };
    uint64_t key;
    if (guess >= 0 && pinch_is_kept_surface(store, guess, surface)) return guess;
    if (store->last_surface >= 0 && store->last_surface < store->surfaces.count &&
        pinch_is_kept_surface(store, store->last_surface, surface))
        return store->last_surface;
    int index = look_up(store, surface, &key);
    if (index < 0) {
        if (store->surfaces.count >= FEWEST &&
            store->surfaces.count >= store->surfaces_swept + store->surfaces_swept / 2) {
            if (!sweep(store)) return -1;
            store->surfaces_swept = store->surfaces.count > FEWEST ? store->surfaces.count : FEWEST;
            (void)look_up(store, surface, &key); /* the sweep may have freed a key */
        }
        index = store->surfaces.count;
        if (!PINCH_RESERVE(store->surfaces, index + 1) ||
            !pinch_item_index_add(&store->surface_index, surface_keys(store), &key, index))
            return -1;
        pinch_kept_surface *kept = &store->surfaces.items[store->surfaces.count++];
        kept->key = key;
        memcpy(&kept->surface, surface, sizeof *surface);
        store->any_bounces = store->any_bounces || surface->bounce != 0;
    }
    return store->last_surface = index;
}
