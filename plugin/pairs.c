/* The pairs of geoms in contact: who they are, and their manifolds brought up to date. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static uint64_t pair_key(int geom0, int geom1)
{
    return ((uint64_t)(geom0 + 1) << 32) | (uint64_t)(geom1 + 1);
}

void pinch_pair_clear(pinch_ode *p, pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count; k++) pinch_block_give(&p->own_laws, pair->manifold.point[k].own, 1);
    pinch_block_give(&p->points, pair->manifold.point, pair->room);
    memset(&pair->manifold, 0, sizeof pair->manifold);
    pair->room = 0;
}

int pinch_pair_between(pinch_ode *p, int geom0, int geom1)
{
    uint64_t key = pair_key(geom0, geom1);
    int index = pinch_key_map_get(&p->pair_index, key);
    if (index >= 0) return index;
    if (!PINCH_RESERVE(p->pairs, p->pairs.count + 1) || !pinch_key_map_add(&p->pair_index, key, p->pairs.count))
        return -1;
    pinch_pair *pair = &p->pairs.items[p->pairs.count];
    memset(pair, 0, sizeof *pair);
    pair->geom[0] = geom0;
    pair->geom[1] = geom1;
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
    pinch_key_map_clear(&p->pair_index);
    for (int i = 0; i < kept; i++) /* cannot fail: it has been larger */
        (void)pinch_key_map_add(&p->pair_index, pair_key(p->pairs.items[i].geom[0], p->pairs.items[i].geom[1]), i);
}

pinch_status pinch_ode_forget_geom(pinch_ode *p, dGeomID geom)
{
    if (!p || !geom) return PINCH_INVALID_ARGUMENT;
    int index = pinch_key_map_get(&p->geom_index, (uint64_t)(uintptr_t)geom);
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
    memcpy(pair->manifold.point, updated->point, (size_t)updated->count * sizeof *updated->point);
    return true;
}

/* Every point gets the surface parameters that it was handed over with last, and a law of its own to keep them in. */
static bool store_own_laws(pinch_ode *p, pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count; k++) {
        pinch_manifold_point *point = &pair->manifold.point[k];
        int room;
        if (point->own) continue;
        point->own = pinch_block_take(&p->own_laws, 1, &room);
        if (!point->own) return false;
        memset(point->own, 0, sizeof *point->own);
    }
    for (int f = pair->first_fresh; f >= 0; f = p->pool.items[f].next) {
        const pinch_fresh_point *fresh = &p->pool.items[f];
        if (fresh->point >= 0) pair->manifold.point[fresh->point].own->surface = p->surfaces.items[fresh->surface];
    }
    return true;
}

/* Points that are no more have no law. */
static void give_back_own_laws(pinch_ode *p, const pinch_manifold *before, const pinch_manifold *after)
{
    for (int k = 0; k < before->count; k++) {
        bool stays = !before->point[k].own;
        for (int j = 0; j < after->count && !stays; j++) stays = after->point[j].own == before->point[k].own;
        if (!stays) pinch_block_give(&p->own_laws, before->point[k].own, 1);
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

/* The manifold is brought up to date where there is room for all that may come. */
static bool update_pair(pinch_ode *p, pinch_pair *pair)
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    const pinch_pose pose[2] = {pinch_geom_pose(a->geom), pinch_geom_pose(b->geom)};
    double size = a->size < b->size ? a->size : b->size;
    pinch_manifold_point point[PINCH_MANIFOLD_POINTS];
    pinch_manifold updated = {pair->manifold.count, point};
    if (updated.count > 0) memcpy(point, pair->manifold.point, (size_t)updated.count * sizeof *point);
    pinch_manifold_update(&updated, pose, p->pool.items, pair->first_fresh, p->settings.merge_distance * size,
                          steady_distance(p, pair, size), p->settings.stale_tilt, pair->has_material,
                          p->settings.manifold_points);
    if (updated.count <= pair->room && pair->has_material) return store_points(p, pair, &updated);
    if (p->workers) mtx_lock(&p->blocks); /* seldom: a pair that grows, or has laws of its own */
    if (!pair->has_material) give_back_own_laws(p, &pair->manifold, &updated);
    bool fine = store_points(p, pair, &updated) && (pair->has_material || store_own_laws(p, pair));
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

/* The point as its pair's first geom sees it. */
static void interpret(pinch_fresh_point *fresh)
{
    const double *normal = fresh->found + 3;
    double scale = (fresh->swapped ? -1 : 1) / sqrt(pinch_v3_dot(normal, normal));
    pinch_v3_copy(fresh->position, fresh->found);
    for (int i = 0; i < 3; i++) fresh->normal[i] = scale * normal[i];
    fresh->depth = fresh->found[6];
}

/* The pair's fresh points, before they meet its manifold; false: no memory. One thread at a time: the list of points
 * may grow. */
static bool prepare_pair(pinch_ode *p, pinch_pair *pair)
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    bool place = pair->has_material && !pinch_place_as_found(a, b);
    for (int f = pair->first_fresh; f >= 0; f = p->pool.items[f].next) {
        interpret(&p->pool.items[f]);
        if (place) pinch_place_half_way(a, b, &p->pool.items[f]);
    }
    return pinch_complete_points(p, pair);
}

/* Where the same contacts came from the same poses, the manifold is what it was. */
bool pinch_pairs_update(pinch_ode *p)
{
    enum { PAIRS_AT_A_TIME = 32 };
    int taken = p->pool.count;
    p->unchanged = p->unchanged && taken == p->taken_before;
    if (p->unchanged) return true;
    pinch_pairs_prune(p, -1);
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        pair->same = pair->same && pair->fresh_count == pair->fresh_before;
        if (pair->same) continue;
        if (!prepare_pair(p, pair)) return false;
        if (!p->workers && !update_pair(p, pair)) return false; /* as long as it is at hand */
    }
    p->taken_before = p->places ? taken : -1;
    p->surfaces_before = p->places ? p->surfaces.count : -1;
    if (!p->workers) return true;
    pinch_workers_run(p->workers, update_pairs, p, p->pairs.count, PAIRS_AT_A_TIME);
    for (int i = 0; i < p->pairs.count; i++)
        if (!p->pairs.items[i].updated) return false;
    return true;
}
