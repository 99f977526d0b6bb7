#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

#include "support/vec3.h"

#include <limits.h>
#include <string.h>

/* Bytes that an archive has at least for one of each. */
enum { GEOM_BYTES = 29, MATERIAL_BYTES = 4, PAIR_BYTES = 40, SURFACE_BYTES = 100, POSE_BYTES = 8 };

/* ---- geoms and materials ---- */

static void archive_geom_record(pinch_archive *a, pinch_geom_record *g, const pinch_contact_store *store)
{
    int materials = store->materials.count;
    bool world = g->key == 1;
    pinch_archive_flag(a, &world);
    pinch_archive_old_geom(a, &g->geom);
    pinch_archive_old_body(a, &g->body);
    PINCH_ARCHIVE(a, g->number);
    PINCH_ARCHIVE(a, g->size);
    pinch_archive_place(a, &g->material, materials, true);
    if (!a->reading) return;
    g->key = g->geom ? (uintptr_t)g->geom : (uintptr_t)g->body | 1;
    if (world != (g->key == 1) || g->number < 0 || g->number > store->last_number)
        pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

/* A place that is free has no material. */
static void archive_material(pinch_archive *a, pinch_kept_material *kept)
{
    pinch_material *m = &kept->material;
    PINCH_ARCHIVE(a, kept->users);
    if (kept->users == 0) return;
    PINCH_ARCHIVE(a, m->model);
    PINCH_ARCHIVE(a, m->stiffness);
    PINCH_ARCHIVE(a, m->damping);
    PINCH_ARCHIVE(a, m->friction);
    PINCH_ARCHIVE(a, m->friction_kinetic);
    PINCH_ARCHIVE(a, m->torsional_friction);
    PINCH_ARCHIVE(a, m->max_force);
    PINCH_ARCHIVE(a, m->hertz_modulus);
    PINCH_ARCHIVE(a, m->facet_axis);
}

static void archive_geoms(pinch_archive *a, pinch_contact_store *store)
{
    PINCH_ARCHIVE(a, store->last_number);
    if (store->last_number < 0 || store->last_number > LONG_MAX / 2) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    PINCH_ARCHIVE_LIST(a, store->materials, MATERIAL_BYTES);
    for (int i = 0; i < store->materials.count; i++) archive_material(a, &store->materials.items[i]);
    pinch_archive_count(a, &store->free_material, 1, store->materials.count);
    PINCH_ARCHIVE_LIST(a, store->geoms, GEOM_BYTES);
    for (int i = 0; i < store->geoms.count; i++) archive_geom_record(a, &store->geoms.items[i], store);
    pinch_archive_index(a, &store->geom_index, PINCH_ITEM_KEYS(store->geoms, pinch_geom_record, key),
                        store->geoms.count);
    PINCH_ARCHIVE_LIST(a, store->seen_poses, POSE_BYTES);
    for (int i = 0; i < store->seen_poses.count; i++) {
        pinch_seen_pose *seen = &store->seen_poses.items[i];
        PINCH_ARCHIVE(a, seen->step);
        if (seen->step < 0) continue; /* not seen yet */
        PINCH_ARCHIVE(a, seen->pose);
        pinch_archive_flag(a, &seen->stays);
    }
    if (store->seen_poses.count > store->geoms.count) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

/* ---- surfaces ---- */

static void archive_surface(pinch_archive *a, pinch_kept_surface *kept)
{
    pinch_surface *s = &kept->surface;
    PINCH_ARCHIVE(a, kept->key);
    PINCH_ARCHIVE(a, s->friction);
    for (int i = 0; i < 5; i++) pinch_archive_flag(a, &s->coefficient[i]);
    pinch_archive_flag(a, &s->rolls);
    PINCH_ARCHIVE(a, s->erp);
    PINCH_ARCHIVE(a, s->cfm);
    PINCH_ARCHIVE(a, s->bounce);
    PINCH_ARCHIVE(a, s->bounce_velocity);
    PINCH_ARCHIVE(a, s->motion);
    PINCH_ARCHIVE(a, s->slip);
}

static void archive_surfaces(pinch_archive *a, pinch_contact_store *store)
{
    PINCH_ARCHIVE_LIST(a, store->surfaces, SURFACE_BYTES);
    for (int i = 0; i < store->surfaces.count; i++) {
        archive_surface(a, &store->surfaces.items[i]);
        store->any_bounces = store->any_bounces || store->surfaces.items[i].surface.bounce != 0;
    }
    pinch_archive_index(a, &store->surface_index, PINCH_ITEM_KEYS(store->surfaces, pinch_kept_surface, key),
                        store->surfaces.count);
    PINCH_ARCHIVE(a, store->surfaces_swept);
    pinch_archive_place(a, &store->last_surface, store->surfaces.count, true);
    store->last_given.surface = -1;
}

/* ---- pairs ---- */

static void archive_own_law(pinch_archive *a, const pinch_contact_store *store, pinch_manifold_point *point)
{
    pinch_own_law *own = point->own;
    PINCH_ARCHIVE(a, own->tangent1);
    PINCH_ARCHIVE(a, own->compliance);
    PINCH_ARCHIVE(a, own->step);
    PINCH_ARCHIVE(a, own->floor);
    PINCH_ARCHIVE(a, own->stands_for);
    PINCH_ARCHIVE(a, own->part);
    PINCH_ARCHIVE(a, own->carried_at);
    PINCH_ARCHIVE(a, own->closed_at);
    PINCH_ARCHIVE(a, own->yielded);
    PINCH_ARCHIVE(a, own->locked);
    PINCH_ARCHIVE(a, own->locked_from);
    PINCH_ARCHIVE(a, own->hold);
    PINCH_ARCHIVE(a, own->hold_span);
    pinch_archive_place(a, &own->surface, store->surfaces.count, false);
    point->locks = own->locked_from > 0;
    if (!point->rolls) return;
    PINCH_ARCHIVE(a, pinch_rolling_of(point)->rolled);
    PINCH_ARCHIVE(a, pinch_rolling_of(point)->moment);
}

/* Takes the room for the law of a point that is being read. */
static bool take_own_law(pinch_archive *a, pinch_contact_store *store, pinch_manifold_point *point)
{
    int room;
    point->own = pinch_block_take(&store->own_laws, point->rolls ? 2 : 1, &room);
    if (point->own) memset(point->own, 0, (size_t)room * sizeof *point->own);
    if (!point->own) pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    return point->own;
}

static void archive_point(pinch_archive *a, pinch_contact_store *store, pinch_manifold_point *p)
{
    bool own = p->own != NULL;
    PINCH_ARCHIVE(a, p->anchor);
    PINCH_ARCHIVE(a, p->seen_normal);
    PINCH_ARCHIVE(a, p->position);
    PINCH_ARCHIVE(a, p->normal);
    PINCH_ARCHIVE(a, p->depth);
    PINCH_ARCHIVE(a, p->elastic);
    PINCH_ARCHIVE(a, p->twist);
    PINCH_ARCHIVE(a, p->friction);
    PINCH_ARCHIVE(a, p->normal_force);
    PINCH_ARCHIVE(a, p->torsion);
    PINCH_ARCHIVE(a, p->weight);
    PINCH_ARCHIVE(a, p->grown);
    pinch_archive_flag(a, &p->slipping);
    pinch_archive_flag(a, &p->rolls);
    pinch_archive_flag(a, &own);
    if (!(p->weight > 0 && p->weight <= 1 && p->grown >= 0 && p->grown <= 1))
        pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (p->rolls && !own) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (own && (!a->reading || take_own_law(a, store, p))) archive_own_law(a, store, p);
}

static void archive_manifold(pinch_archive *a, pinch_contact_store *store, pinch_pair *pair)
{
    pinch_manifold *manifold = &pair->manifold;
    int count = manifold->count;
    pinch_archive_count(a, &count, sizeof *manifold->point / 2, PINCH_MANIFOLD_POINTS);
    if (a->reading && count > 0) {
        manifold->point = pinch_block_take(&store->points, count, &pair->room);
        if (!manifold->point) pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
        if (!manifold->point) return;
        memset(manifold->point, 0, (size_t)pair->room * sizeof *manifold->point);
        manifold->count = count;
    }
    for (int k = 0; k < count; k++) archive_point(a, store, &manifold->point[k]);
}

/* The sides of a pair that was read have to be those of its records. A pair that seemed to belong to the next step
 * already would keep what it counts in this one. */
static void check_pair(pinch_archive *a, const pinch_contact_store *store, const pinch_pair *pair, long number)
{
    const pinch_pose_motion *posed = &pair->posed;
    bool past =
        posed->seen_step >= 0 && posed->seen_step <= number && posed->way_step >= 0 && posed->way_step <= number;
    const long side_number[2] = {store->geoms.items[pair->geom[0]].number, store->geoms.items[pair->geom[1]].number};
    bool same = side_number[0] > 0 && side_number[0] < side_number[1] && pair->last_step < number && past;
    for (int side = 0; side < 2 && same; side++) {
        const pinch_geom_record *record = &store->geoms.items[pair->geom[side]];
        same = pair->id[side] == record->geom && (record->geom || pair->body[side] == record->body);
    }
    if (!same) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

/* A pair whose geoms are not in the parts cannot be restored: writing tells. */
static void archive_pair(pinch_archive *a, pinch_contact_store *store, pinch_pair *pair)
{
    for (int side = 0; side < 2; side++) {
        pinch_archive_place(a, &pair->geom[side], store->geoms.count, false);
        pinch_archive_geom(a, &pair->id[side], true);
        pinch_archive_body(a, &pair->body[side], true);
    }
    PINCH_ARCHIVE(a, pair->last_step);
    pinch_archive_flag(a, &pair->has_material);
    pinch_archive_flag(a, &pair->is_prescribed);
    PINCH_ARCHIVE(a, pair->approach_depth);
    PINCH_ARCHIVE(a, pair->recent_approach);
    PINCH_ARCHIVE(a, pair->paced_step);
    PINCH_ARCHIVE(a, pair->posed.seen_step);
    PINCH_ARCHIVE(a, pair->posed.seen_depth);
    PINCH_ARCHIVE(a, pair->posed.seen_normal);
    PINCH_ARCHIVE(a, pair->posed.apart);
    PINCH_ARCHIVE(a, pair->posed.way);
    PINCH_ARCHIVE(a, pair->posed.way_step);
    PINCH_ARCHIVE(a, pair->posed.steps);
    PINCH_ARCHIVE(a, pair->posed.speed);
    PINCH_ARCHIVE(a, pair->turned);
    PINCH_ARCHIVE(a, pair->slip_total);
    PINCH_ARCHIVE(a, pair->twist_total);
    archive_manifold(a, store, pair);
}

static void archive_pairs(pinch_archive *a, pinch_contact_store *store, long number)
{
    PINCH_ARCHIVE_LIST(a, store->pairs, PAIR_BYTES);
    for (int i = 0; i < store->pairs.count; i++) {
        archive_pair(a, store, &store->pairs.items[i]);
        if (a->reading && a->status == PINCH_OK) check_pair(a, store, &store->pairs.items[i], number);
    }
    pinch_archive_index(a, &store->pair_index, PINCH_ITEM_KEYS(store->pairs, pinch_pair, geom), store->pairs.count);
}

void pinch_archive_contacts(pinch_archive *a, pinch_contact_store *store, long number)
{
    archive_geoms(a, store);
    archive_surfaces(a, store);
    archive_pairs(a, store, number);
    if (a->reading) pinch_invalidate_step_cache(store);
}
