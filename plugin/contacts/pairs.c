/* The pairs of geoms in contact: who they are, and their manifolds brought up to date. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static uint64_t key_of(const int geom[2])
{
    uint64_t key;
    _Static_assert(sizeof key == 2 * sizeof *geom, "two records make a key");
    memcpy(&key, geom, sizeof key);
    return key;
}

static pinch_item_keys keys_of(const pinch_ode *p)
{
    return PINCH_ITEM_KEYS(p->pairs, pinch_pair, geom);
}

_Static_assert(sizeof(pinch_rolling) <= sizeof(pinch_own_law), "what a point rolls with fits behind its law");

/* The law of a point and what it rolls with have a block of one or two. */
static void give_own_law(pinch_ode *p, const pinch_manifold_point *point)
{
    pinch_block_give(&p->own_laws, point->own, point->rolls ? 2 : 1);
}

void pinch_pair_clear(pinch_ode *p, pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count; k++) give_own_law(p, &pair->manifold.point[k]);
    pinch_block_give(&p->points, pair->manifold.point, pair->room);
    memset(&pair->manifold, 0, sizeof pair->manifold);
    pair->room = 0;
}

int pinch_pair_between(pinch_ode *p, int geom0, int geom1)
{
    const int geom[2] = {geom0, geom1};
    int index = pinch_item_index_get(&p->pair_index, keys_of(p), key_of(geom));
    if (index >= 0) return index;
    if (!PINCH_RESERVE(p->pairs, p->pairs.count + 1) ||
        !pinch_item_index_add(&p->pair_index, keys_of(p), key_of(geom), p->pairs.count))
        return -1;
    pinch_pair *pair = &p->pairs.items[p->pairs.count];
    memset(pair, 0, sizeof *pair);
    memcpy(pair->geom, geom, sizeof geom);
    for (int side = 0; side < 2; side++) pair->id[side] = p->geoms.items[pair->geom[side]].geom;
    pair->handed_over = -1;
    return p->pairs.count++;
}

void pinch_pairs_prune(pinch_ode *p, int geom)
{
    int kept = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        bool goes = geom >= 0 ? pair->geom[0] == geom || pair->geom[1] == geom : pair->handed_over != p->step;
        if (goes) {
            pinch_pair_clear(p, pair);
            continue;
        }
        if (kept != i) p->pairs.items[kept] = *pair;
        kept++;
    }
    if (kept == p->pairs.count) return;
    pinch_expect_nothing(p);
    p->pairs.count = kept;
    pinch_item_index_clear(&p->pair_index);
    for (int i = 0; i < kept; i++) /* cannot fail: it has been larger */
        (void)pinch_item_index_add(&p->pair_index, keys_of(p), key_of(p->pairs.items[i].geom), i);
}

pinch_status pinch_ode_forget_geom(pinch_ode *p, dGeomID geom)
{
    if (!p || !geom) return PINCH_INVALID_ARGUMENT;
    int index = pinch_item_index_get(&p->geom_index, pinch_geom_keys(p), pinch_key_of_pointer(geom));
    if (index < 0) return PINCH_OK;
    pinch_pairs_prune(p, index);
    p->geoms.items[index].size = -1; /* what comes back may have another shape */
    return PINCH_OK;
}

/* The points into a block of their own size; false: no memory. */
static bool store_points(pinch_ode *p, pinch_pair *pair, const pinch_manifold *updated)
{
    if (updated->count > pair->room) {
        pinch_block_give(&p->points, pair->manifold.point, pair->room);
        pair->manifold.count = pair->room = 0;
        pair->manifold.point = pinch_block_take(&p->points, updated->count, &pair->room);
        if (!pair->manifold.point) return false;
    }
    pair->manifold.count = updated->count;
    size_t bytes = (size_t)updated->count * sizeof *updated->point;
    if (bytes > 0) memcpy(pair->manifold.point, updated->point, bytes);
    return true;
}

/* A law of its own for a point that has none, and one that it can roll with, or need not; false: no memory. */
static bool make_own_law(pinch_ode *p, pinch_manifold_point *point, bool rolls)
{
    int room;
    if (point->own && point->rolls == rolls) return true;
    pinch_own_law *own = pinch_block_take(&p->own_laws, rolls ? 2 : 1, &room);
    if (!own) return false;
    memset(own, 0, (size_t)room * sizeof *own);
    if (point->own) *own = *point->own;
    give_own_law(p, point);
    point->own = own;
    point->rolls = rolls;
    return true;
}

/* Every point gets the surface parameters that it was handed over with last. */
static bool store_own_laws(pinch_ode *p, pinch_pair *pair, const pinch_fresh_point *fresh, int count)
{
    for (int i = 0; i < count; i++) {
        if (fresh[i].point < 0) continue;
        const pinch_taken_contact *taken = &p->taken.items[fresh[i].taken];
        pinch_manifold_point *point = &pair->manifold.point[fresh[i].point];
        if (!make_own_law(p, point, p->surfaces.items[taken->surface].rolls)) return false;
        point->own->surface = taken->surface;
        if (taken->direction >= 0)
            pinch_v3_copy(point->own->tangent1, p->directions.items[taken->direction].tangent);
        else
            pinch_surface_tangent(taken->found + 3, point->own->tangent1);
    }
    return true;
}

/* Points that are no more have no law. */
static void give_back_own_laws(pinch_ode *p, const pinch_manifold *before, const pinch_manifold *after)
{
    for (int k = 0; k < before->count; k++) {
        bool stays = !before->point[k].own;
        for (int j = 0; j < after->count && !stays; j++) stays = after->point[j].own == before->point[k].own;
        if (!stays) give_own_law(p, &before->point[k]);
    }
}

/*
 * The corners of what two flat faces share lie where their edges cross. Of edges that are parallel but for 1e-7 rad, as
 * in every wall, the crossings wander by micrometres with the last bits of the poses, and the forces on bodies at rest
 * would follow them. Round bodies have no such points: theirs go where the bodies roll.
 */
static double steady_distance(const pinch_ode *p, const pinch_pair *pair, double size)
{
    static const double STEADY = 5e-12; /* of the smaller geom */
    if (pair->has_material) return 0;
    bool flat = pinch_place_as_found(&p->geoms.items[pair->geom[0]], &p->geoms.items[pair->geom[1]]);
    return flat ? STEADY * size : 0;
}

/* The contact as its pair's first geom sees it. */
static pinch_fresh_point interpret(const pinch_ode *p, int index)
{
    const pinch_taken_contact *taken = &p->taken.items[index];
    pinch_fresh_point fresh = {.depth = taken->found[6], .taken = index};
    const double *normal = taken->found + 3;
    double scale = (taken->swapped ? -1 : 1) / sqrt(pinch_v3_dot(normal, normal));
    pinch_v3_copy(fresh.position, taken->found);
    for (int i = 0; i < 3; i++) fresh.normal[i] = scale * normal[i];
    return fresh;
}

/* The pair's contacts as points for its manifold; returns how many. */
static int fresh_points(const pinch_ode *p, const pinch_pair *pair, pinch_fresh_point fresh[PINCH_MANIFOLD_FRESH])
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    bool place = pair->has_material && !pinch_place_as_found(a, b);
    int count = 0;
    for (int t = pair->first_taken; t >= 0 && count < PINCH_MANIFOLD_FRESH; t = p->taken.items[t].next) {
        fresh[count] = interpret(p, t);
        if (place) pinch_place_half_way(a, b, &fresh[count]);
        count++;
    }
    return pinch_complete_points(pair, fresh, count);
}

static void tell_places(pinch_ode *p, const pinch_pair *pair, const pinch_fresh_point *fresh, int count)
{
    int k = 0;
    for (int t = pair->first_taken; t >= 0; t = p->taken.items[t].next, k++)
        p->taken.items[t].point = k < count ? fresh[k].point : -1;
}

/* The manifold is brought up to date where there is room for all that may come. */
static bool update_pair(pinch_ode *p, pinch_pair *pair)
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    const pinch_pose pose[2] = {pinch_geom_pose(a->geom), pinch_geom_pose(b->geom)};
    double size = a->size < b->size ? a->size : b->size;
    pinch_fresh_point fresh[PINCH_MANIFOLD_FRESH];
    int count = fresh_points(p, pair, fresh);
    pinch_manifold_point point[PINCH_MANIFOLD_POINTS];
    pinch_manifold updated = {pair->manifold.count, point};
    if (updated.count > 0) memcpy(point, pair->manifold.point, (size_t)updated.count * sizeof *point);
    pinch_manifold_update(&updated, pose, fresh, count, p->settings.merge_distance * size,
                          steady_distance(p, pair, size), p->settings.stale_tilt, pair->has_material,
                          p->settings.manifold_points);
    tell_places(p, pair, fresh, count);
    if (updated.count <= pair->room && pair->has_material) return store_points(p, pair, &updated);
    if (p->workers) mtx_lock(&p->blocks); /* seldom: a pair that grows, or has laws of its own */
    if (!pair->has_material) give_back_own_laws(p, &pair->manifold, &updated);
    bool fine = store_points(p, pair, &updated) && (pair->has_material || store_own_laws(p, pair, fresh, count));
    if (p->workers) mtx_unlock(&p->blocks);
    return fine;
}

/* One thread's share of the pairs. */
static void update_pairs(void *context, int worker, int first, int end)
{
    pinch_ode *p = context;
    (void)worker;
    for (int i = first; i < end; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->updated = pair->same || update_pair(p, pair);
    }
}

/* ODE works out the pose of a geom with an offset when it is first asked for: not by several threads. */
static void work_out_poses(const pinch_pair *pair)
{
    for (int side = 0; side < 2; side++) (void)pinch_geom_pose(pair->id[side]);
}

/* Where the same contacts came from the same poses, the manifold is what it was. */
bool pinch_pairs_update(pinch_ode *p)
{
    enum { PAIRS_AT_A_TIME = 32 };
    int taken = p->taken.count;
    p->unchanged = p->unchanged && taken == p->taken_before;
    if (p->unchanged) return true;
    pinch_pairs_prune(p, -1);
    bool fine = true;
    for (int i = 0; i < p->pairs.count && fine; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->same = pair->same && pair->taken_count == pair->taken_before;
        if (pair->same) continue;
        if (p->workers)
            work_out_poses(pair);
        else
            fine = update_pair(p, pair); /* as long as it is at hand */
    }
    p->taken_before = p->places ? taken : -1;
    p->directions_before = p->places ? p->directions.count : -1;
    if (!p->workers || !fine) return fine;
    pinch_workers_run(p->workers, update_pairs, p, p->pairs.count, PAIRS_AT_A_TIME);
    for (int i = 0; i < p->pairs.count; i++) fine = fine && p->pairs.items[i].updated;
    return fine;
}
