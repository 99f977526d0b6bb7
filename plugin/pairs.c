#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static uint64_t pair_key(int geom0, int geom1)
{
    return ((uint64_t)(geom0 + 1) << 32) | (uint64_t)(geom1 + 1);
}

static bool well_formed(const dContactGeom *g)
{
    double n2 = pinch_v3_dot(g->normal, g->normal);
    return g->g1 && g->g2 && g->g1 != g->g2 && isfinite(g->depth) && fabs(n2 - 1) < 1e-3 && isfinite(g->pos[0]) &&
           isfinite(g->pos[1]) && isfinite(g->pos[2]);
}

/* Dynamic, or driven by a force. */
static bool moves(const pinch_ode *p, dBodyID body)
{
    return body && (!dBodyIsKinematic(body) || pinch_drive_of(p, body) >= 0);
}

/* Ends the pair's contact history. */
static void clear(pinch_ode *p, pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count; k++) pinch_block_give(&p->own_laws, pair->manifold.point[k].own, 1);
    pinch_block_give(&p->points, pair->manifold.point, pair->room);
    memset(&pair->manifold, 0, sizeof pair->manifold);
    pair->room = 0;
}

/* The pair's index, new pairs included; -1: no memory. */
static int pair_of(pinch_ode *p, int geom0, int geom1)
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

/* ODE's own contact joint, for this step: the program's where there is one. */
static void leave_to_ode(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2, int joint, long *reason)
{
    if (joint < 0) dJointAttach(dJointCreateContact(p->world, p->left, contact), body1, body2);
    p->stats.contacts_left++;
    (*reason)++;
}

/* Are there laws for surface parameters at all? Not with a polygon, not without Newton's steps, and not where bodies
 * under force control, which have no mass, may belong to the island. */
static bool surfaces_solvable(const pinch_ode *p)
{
    const pinch_solver_settings *s = &p->settings.solver;
    bool newton = s->solver == PINCH_SOLVER_NEWTON || (s->solver == PINCH_SOLVER_NSNMGK && s->newton_finish);
    return newton && p->settings.faces == 0 && p->drives.count == 0;
}

static bool in_scope(const pinch_ode *p, const dContact *contact)
{
    if (p->settings.scope == PINCH_ODE_SOFT_CONTACTS) return contact->surface.mode & dContactSoftCFM;
    return p->settings.scope == PINCH_ODE_ALL_CONTACTS;
}

/* The contact's place in the pool, at the end of its pair's list; false: no memory. */
static bool add_fresh(pinch_ode *p, pinch_pair *pair, const dContactGeom *g, bool swapped, int surface, int joint)
{
    if (!PINCH_RESERVE(p->pool, p->pool.count + 1)) return false;
    pinch_fresh_point *fresh = &p->pool.items[p->pool.count];
    pinch_v3_copy(fresh->position, g->pos);
    double scale = (swapped ? -1 : 1) / sqrt(pinch_v3_dot(g->normal, g->normal));
    for (int i = 0; i < 3; i++) fresh->normal[i] = scale * g->normal[i];
    fresh->depth = g->depth;
    fresh->next = -1;
    fresh->surface = surface;
    fresh->joint = joint;
    if (pair->first_fresh < 0)
        pair->first_fresh = p->pool.count;
    else
        p->pool.items[pair->last_fresh].next = p->pool.count;
    pair->last_fresh = p->pool.count++;
    return true;
}

pinch_status pinch_pairs_add(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2, int joint,
                             bool *taken)
{
    const dContactGeom *g = &contact->geom;
    *taken = false;
    if (!well_formed(g) || (!moves(p, body1) && !moves(p, body2))) {
        p->stats.contacts_malformed++;
        return PINCH_OK;
    }
    int record1 = pinch_geom_record_of(p, g->g1), record2 = pinch_geom_record_of(p, g->g2);
    if (record1 < 0 || record2 < 0) return PINCH_OUT_OF_MEMORY;
    bool swapped = record2 < record1;
    bool material = p->geoms.items[record1].has_material || p->geoms.items[record2].has_material;
    if (!material) {
        if (!in_scope(p, contact)) {
            leave_to_ode(p, contact, body1, body2, joint, &p->stats.contacts_left_by_scope);
            return PINCH_OK;
        }
        if (!PINCH_RESERVE(p->surfaces, p->surfaces.count + 1)) return PINCH_OUT_OF_MEMORY;
        if (!surfaces_solvable(p) || !pinch_surface_of(contact, swapped, &p->surfaces.items[p->surfaces.count])) {
            leave_to_ode(p, contact, body1, body2, joint, &p->stats.contacts_left_unsupported);
            return PINCH_OK;
        }
    }
    int index = swapped ? pair_of(p, record2, record1) : pair_of(p, record1, record2);
    if (index < 0) return PINCH_OUT_OF_MEMORY;
    pinch_pair *pair = &p->pairs.items[index];
    if (pair->handed_over != p->step) {
        pair->handed_over = p->step;
        pair->first_fresh = -1;
    }
    pair->body[0] = swapped ? body2 : body1;
    pair->body[1] = swapped ? body1 : body2;
    if (pair->has_material != material) clear(p, pair); /* by the other geom's material */
    pair->has_material = material;
    if (!add_fresh(p, pair, g, swapped, material ? -1 : p->surfaces.count, joint)) return PINCH_OUT_OF_MEMORY;
    p->surfaces.count += !material;
    *taken = true;
    return PINCH_OK;
}

void pinch_pairs_prune(pinch_ode *p, int geom)
{
    int kept = 0;
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        bool goes = geom >= 0 ? pair->geom[0] == geom || pair->geom[1] == geom : pair->handed_over != p->step;
        if (goes) {
            clear(p, pair);
            continue;
        }
        if (kept != i) p->pairs.items[kept] = *pair;
        kept++;
    }
    if (kept == p->pairs.count) return;
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
    for (int i = first; i < end; i++) p->pairs.items[i].updated = update_pair(p, &p->pairs.items[i]);
}

/* The pair's fresh points, before they meet its manifold; false: no memory. One thread at a time: the list of points
 * may grow, and ODE may have to work out a geom's pose. */
static bool prepare_pair(pinch_ode *p, pinch_pair *pair)
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    (void)pinch_geom_pose(a->geom);
    (void)pinch_geom_pose(b->geom);
    bool place = pair->has_material && !pinch_place_as_found(a, b);
    for (int f = pair->first_fresh; f >= 0 && place; f = p->pool.items[f].next)
        pinch_place_half_way(a, b, &p->pool.items[f]);
    return pinch_complete_points(p, pair);
}

bool pinch_pairs_update(pinch_ode *p)
{
    enum { PAIRS_AT_A_TIME = 32 };
    pinch_pairs_prune(p, -1);
    for (int i = 0; i < p->pairs.count; i++) {
        pinch_pair *pair = &p->pairs.items[i];
        if (!prepare_pair(p, pair)) return false;
        if (!p->workers && !update_pair(p, pair)) return false; /* as long as it is at hand */
    }
    if (!p->workers) return true;
    pinch_workers_run(p->workers, update_pairs, p, p->pairs.count, PAIRS_AT_A_TIME);
    for (int i = 0; i < p->pairs.count; i++)
        if (!p->pairs.items[i].updated) return false;
    return true;
}
