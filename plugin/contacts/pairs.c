#include "contacts/pairs.h"

#include "contacts/collider_points.h"
#include "contacts/kept_points.h"
#include "contacts/manifold.h"
#include "contacts/reduction.h"
#include "contacts/surface.h"
#include "util/block_pool.h"
#include "util/prefetch.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

static pinch_item_keys keys_of(const pinch_contact_store *store)
{
    _Static_assert(sizeof store->pairs.items->geom == sizeof(uint64_t), "two records make a key");
    return PINCH_ITEM_KEYS(store->pairs, pinch_pair, geom);
}

_Static_assert(sizeof(pinch_rolling) <= sizeof(pinch_own_law), "what a point rolls with fits behind its law");

/* The own law of a point takes one item of the pool, or two where it rolls. */
static void give_own_law(pinch_contact_store *store, const pinch_manifold_point *point)
{
    pinch_block_give(&store->own_laws, point->own, point->rolls ? 2 : 1);
}

void pinch_clear_pair(pinch_contact_store *store, pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count; k++) give_own_law(store, &pair->manifold.point[k]);
    pinch_block_give(&store->points, pair->manifold.point, pair->room);
    memset(&pair->manifold, 0, sizeof pair->manifold);
    pair->room = 0;
    pair->slip_total = pair->twist_total = 0;
}

int pinch_pair_between(pinch_contact_store *store, int geom0, int geom1)
{
    const int geom[2] = {geom0, geom1};
    int index = pinch_item_index_get(&store->pair_index, keys_of(store), geom);
    if (index >= 0) return index;
    if (!PINCH_RESERVE(store->pairs, store->pairs.count + 1) ||
        !pinch_item_index_add(&store->pair_index, keys_of(store), geom, store->pairs.count))
        return -1;
    pinch_pair *pair = &store->pairs.items[store->pairs.count];
    memset(pair, 0, sizeof *pair);
    memcpy(pair->geom, geom, sizeof geom);
    for (int side = 0; side < 2; side++) pair->id[side] = store->geoms.items[pair->geom[side]].geom;
    pair->last_step = -1;
    return store->pairs.count++;
}

/* Tells the contacts of a pair in this step that it is in another place. */
static void tell_pair(pinch_contact_store *store, const pinch_pair *pair, int place)
{
    for (int b = pair->first_buffered; b >= 0; b = store->buffer.items[b].next) store->buffer.items[b].pair = place;
}

static bool is_forgotten_body(const pinch_contact_store *store, dBodyID body)
{
    return body && pinch_key_map_get(&store->forgotten_bodies, (uintptr_t)body) >= 0;
}

bool pinch_pair_is_forgotten(const pinch_contact_store *store, const pinch_pair *pair)
{
    return store->forgot_pairs &&
           (store->geoms.items[pair->geom[0]].forgot || store->geoms.items[pair->geom[1]].forgot ||
            is_forgotten_body(store, pair->body[0]) || is_forgotten_body(store, pair->body[1]));
}

/* Drops the pairs that are forgotten, or else those that were not handed over for step `now`. Returns whether there
 * were any. The contacts of this step know where their pairs are afterwards, or that they are gone. */
static bool drop_pairs(pinch_contact_store *store, bool forgotten, long now)
{
    int kept = 0;
    for (int i = 0; i < store->pairs.count; i++) {
        pinch_pair *pair = &store->pairs.items[i];
        bool in_step = pair->last_step == now, leaves = forgotten ? pinch_pair_is_forgotten(store, pair) : !in_step;
        if (in_step && (leaves || kept != i)) tell_pair(store, pair, leaves ? -1 : kept);
        if (leaves) {
            pinch_clear_pair(store, pair);
            continue;
        }
        if (kept != i) store->pairs.items[kept] = *pair;
        kept++;
    }
    if (kept == store->pairs.count) return false;
    store->pairs.count = kept;
    (void)pinch_item_index_rebuild(&store->pair_index, keys_of(store), kept); /* cannot fail: it has been larger */
    return true;
}

void pinch_forget_pairs_of(pinch_contact_store *store, int geom)
{
    store->geoms.items[geom].forgot = store->forgot_pairs = true;
}

bool pinch_forget_pairs_of_body(pinch_contact_store *store, dBodyID body)
{
    if (!pinch_key_map_set(&store->forgotten_bodies, (uintptr_t)body, 1)) return false;
    store->forgot_pairs = true;
    return true;
}

void pinch_drop_forgotten_pairs(pinch_contact_store *store, long now)
{
    if (!store->forgot_pairs) return;
    if (drop_pairs(store, true, now)) pinch_invalidate_step_cache(store);
    for (int i = 0; i < store->geoms.count; i++) store->geoms.items[i].forgot = false;
    pinch_key_map_clear(&store->forgotten_bodies);
    store->forgot_pairs = false;
}

/* Stores the points in a block of their own size. Returns false when memory runs out. */
static bool store_points(pinch_contact_store *store, pinch_pair *pair, const pinch_manifold *updated)
{
    if (updated->count > pair->room) {
        pinch_block_give(&store->points, pair->manifold.point, pair->room);
        pair->manifold.count = pair->room = 0;
        pair->manifold.point = pinch_block_take(&store->points, updated->count, &pair->room);
        if (!pair->manifold.point) return false;
    }
    pair->manifold.count = updated->count;
    size_t bytes = (size_t)updated->count * sizeof *updated->point;
    if (bytes > 0) memcpy(pair->manifold.point, updated->point, bytes);
    return true;
}

/* Makes sure that a point has a law of its own, with or without rolling friction. Returns false when memory runs out.
 */
static bool make_own_law(pinch_contact_store *store, pinch_manifold_point *point, bool rolls)
{
    int room;
    if (point->own && point->rolls == rolls) return true;
    pinch_own_law *own = pinch_block_take(&store->own_laws, rolls ? 2 : 1, &room);
    if (!own) return false;
    memset(own, 0, (size_t)room * sizeof *own);
    if (point->own) *own = *point->own;
    give_own_law(store, point);
    point->own = own;
    point->rolls = rolls;
    return true;
}

/*
 * Each contact of ODE's is a spring of its own. Where only some stay, they stand for the others: finds for how many.
 * Redundant ones bear nothing of their own, and no other bears more for them, unless their friction is a force. How
 * stiff ones share a load is open where there are more than the corners of a face: in equal parts, as in ODE.
 */
static void share_out(const pinch_contact_store *store, pinch_detected_point *detected, int count, int most)
{
    int bearing = 0;
    for (int i = 0; i < count; i++) {
        const pinch_surface *surface = &store->surfaces.items[detected[i].surface].surface;
        detected[i].bears = !detected[i].redundant || pinch_surface_has_forces(surface);
        bearing += detected[i].bears;
    }
    if (bearing > most)
        pinch_share_out(detected, count);
    else
        for (int i = 0; i < count && bearing > PINCH_SHARED_POINTS; i++) detected[i].part = 1;
}

/* Gives every point the surface parameters that it was last handed over with. */
static bool store_own_laws(pinch_contact_store *store, pinch_pair *pair, pinch_detected_point *detected, int count,
                           int most)
{
    if (count > PINCH_SHARED_POINTS || count > most) share_out(store, detected, count, most);
    for (int i = 0; i < count; i++) {
        if (detected[i].point < 0) continue;
        const pinch_buffered_contact *contact = &store->buffer.items[detected[i].buffered];
        pinch_manifold_point *point = &pair->manifold.point[detected[i].point];
        if (!make_own_law(store, point, store->surfaces.items[contact->surface].surface.rolls)) return false;
        point->own->surface = contact->surface;
        point->own->stands_for = detected[i].share;
        point->own->part = detected[i].part;
        if (contact->direction >= 0)
            pinch_v3_copy(point->own->tangent1, store->directions.items[contact->direction].tangent);
        else
            pinch_surface_tangent(contact->found + 3, point->own->tangent1);
    }
    return true;
}

/* Gives back the laws of points that are no more. */
static void give_back_own_laws(pinch_contact_store *store, const pinch_manifold *before, const pinch_manifold *after)
{
    for (int k = 0; k < before->count; k++) {
        bool stays = !before->point[k].own;
        for (int j = 0; j < after->count && !stays; j++) stays = after->point[j].own == before->point[k].own;
        if (!stays) give_own_law(store, &before->point[k]);
    }
}

/* Tells whether the points' laws are those of before, and have their blocks. */
static bool keeps_own_laws(const pinch_contact_store *store, const pinch_manifold *before, const pinch_manifold *after,
                           const pinch_detected_point *detected, int count)
{
    for (int k = 0; k < before->count; k++) {
        bool stays = false;
        for (int j = 0; j < after->count && !stays; j++) stays = after->point[j].own == before->point[k].own;
        if (!stays) return false;
    }
    for (int i = 0; i < count; i++) {
        if (detected[i].point < 0) continue;
        const pinch_manifold_point *point = &after->point[detected[i].point];
        const pinch_buffered_contact *contact = &store->buffer.items[detected[i].buffered];
        if (!point->own || point->rolls != store->surfaces.items[contact->surface].surface.rolls) return false;
    }
    return true;
}

/*
 * The corners of what two flat faces share lie where their edges cross. Of edges that are parallel but for 1e-7 rad, as
 * in every wall, the crossings wander by micrometres with the last bits of the poses, or come and go, and the forces on
 * bodies at rest would follow them. Round bodies have no such points: theirs go where the bodies roll.
 */
static bool points_wander(const pinch_pair *pair)
{
    return !pair->has_material && pinch_both_faceted(pair->id[0], pair->id[1]);
}

/* Returns 1/|v| of a vector that is unit but for rounding, or nearly. All that follows would wait for a root and a
 * division. */
static double over_length(const double *v)
{
    static const double ROUNDING = 1e-8; /* below it the next term of the series is less than the last place */
    double length2 = pinch_v3_dot(v, v), excess = length2 - 1;
    return fabs(excess) < ROUNDING ? 1 - 0.5 * excess : 1 / sqrt(length2);
}

/* Interprets a buffered contact as its pair's first geom sees it. The scratch of the reduction stays as it is. */
static void interpret(const pinch_contact_store *store, int index, pinch_detected_point *detected)
{
    const pinch_buffered_contact *contact = &store->buffer.items[index];
    const double *normal = contact->found + 3;
    double scale = contact->swapped ? -over_length(normal) : over_length(normal);
    pinch_v3_copy(detected->position, contact->found);
    for (int i = 0; i < 3; i++) detected->normal[i] = scale * normal[i];
    detected->depth = contact->found[6];
    detected->on_ball = false;
    detected->buffered = index;
    detected->surface = contact->surface;
    detected->redundant = detected->kept = false;
    detected->share = 1;
    detected->part = 0;
    detected->kind = -1;
    detected->tangent1 = contact->direction < 0 ? NULL : store->directions.items[contact->direction].tangent;
}

/*
 * A gap is one where a material says how stiff the contact is: the bodies may close it. ODE takes a negative depth for
 * 0, and so holds bodies where a program's own collider has seen them, a safety margin apart: its row is
 * w + cfm r = erp max(depth, 0)/h, and that of the gap itself would let them come by the part erp of it in each step,
 * for ever where the program gives the same depth again.
 */
static void close_gaps(pinch_detected_point *detected, int count)
{
    for (int k = 0; k < count; k++) detected[k].depth = pinch_larger(detected[k].depth, 0);
}

/* Turns the pair's contacts into points for its manifold, and returns how many. There must be room for one more. */
static int detected_points(const pinch_contact_store *store, const pinch_pair *pair, const pinch_pose pose[2],
                           pinch_detected_point *detected)
{
    bool known = pair->id[0] && pair->id[1];
    const int class[2] = {known ? dGeomGetClass(pair->id[0]) : -1, known ? dGeomGetClass(pair->id[1]) : -1};
    int count = 0;
    for (int b = pair->first_buffered; b >= 0; b = store->buffer.items[b].next) {
        interpret(store, b, &detected[count]);
        if (known && pair->has_material) pinch_locate_contact(pair->id, class, pose, &detected[count]);
        count++;
    }
    if (known && !pair->has_material) count = pinch_settle_box_faces(pair->id, class, pose, detected, count);
    if (known) count = pinch_add_capsule_end(pair->id, class, detected, count);
    if (!pair->has_material) close_gaps(detected, count);
    return count;
}

/* Tells whether points that bear nothing may be left out. A friction that is a force holds where nothing presses, too.
 */
static bool rims_bear_nothing(const pinch_contact_store *store, const pinch_pair *pair,
                              const pinch_detected_point *detected, int count)
{
    int last = -1;
    for (int i = 0; i < count && !pair->has_material; i++) {
        int surface = store->buffer.items[detected[i].buffered].surface;
        if (surface != last && pinch_surface_has_forces(&store->surfaces.items[surface].surface)) return false;
        last = surface;
    }
    return !pair->has_material;
}

static void tell_places(pinch_contact_store *store, const pinch_pair *pair, const pinch_detected_point *detected,
                        int count)
{
    for (int b = pair->first_buffered; b >= 0; b = store->buffer.items[b].next) store->buffer.items[b].point = -1;
    for (int k = count - 1; k >= 0; k--) store->buffer.items[detected[k].buffered].point = detected[k].point;
}

/* One loop over the pairs, by one thread or several. */
typedef struct update_task {
    pinch_contact_store *store;
    const pinch_ode_settings *settings;
    bool threaded;
    atomic_bool out_of_memory, other_points; /* a pair has more or fewer points than when islands were built */
    atomic_bool some_wait;                   /* for the other pairs, see moves_geoms */
} update_task;

/* ODE computes the pose of a geom with an offset when it is first asked for, which several threads must not do at once.
 * Each of them asks under the lock before it reads the pose. */
static void compute_poses(const update_task *task, const pinch_pair *pair)
{
    for (int side = 0; side < 2 && task->threaded; side++) {
        if (!pair->id[side] || !dGeomIsOffset(pair->id[side])) continue;
        mtx_lock(&task->store->workers_lock);
        (void)pinch_side_pose(pair->id[side], NULL);
        mtx_unlock(&task->store->workers_lock);
    }
}

/* Points that share a stiffness are as good as their hull. Contacts of ODE's are springs of their own, and each counts.
 */
static int most_points(const pinch_ode_settings *settings, const pinch_pair *pair)
{
    bool few = pair->has_material || settings->manifold_points < PINCH_SHARED_POINTS;
    return few ? settings->manifold_points : PINCH_MANIFOLD_POINTS;
}

/* Updates the manifold on a copy with room for all points that may come, and stores what has come of it. */
static bool update_pair(const update_task *task, int worker, pinch_pair *pair)
{
    pinch_contact_store *store = task->store;
    if (!PINCH_RESERVE(store->detected[worker], pair->buffered_count + 1)) return false;
    compute_poses(task, pair);
    const pinch_pose pose[2] = {pinch_side_pose(pair->id[0], pair->body[0]),
                                pinch_side_pose(pair->id[1], pair->body[1])};
    static const double STEADY = 5e-12, QUIET = 1e-6; /* of the smaller geom */
    double size = pinch_pair_size(store, pair), wandering = points_wander(pair) ? size : 0;
    pinch_kept_points kept;
    pinch_kept_points_init(&kept, store, pair, pose, task->settings->merge_distance * size);
    pinch_manifold_rules rules = {
        .merge_distance = kept.merge_distance,
        .steady_distance = STEADY * wandering,
        .quiet_distance = QUIET * wandering,
        .stale_tilt = task->settings->stale_tilt,
        .shared = pair->has_material,
        .most_points = most_points(task->settings, pair),
        .bears = pinch_geoms_bear,
        .geoms = &kept,
    };
    memcpy(rules.turned, pair->turned, sizeof rules.turned);
    pinch_detected_point *detected = store->detected[worker].items;
    int count = detected_points(store, pair, pose, detected);
    rules.rims_bear_nothing = rims_bear_nothing(store, pair, detected, count);
    pair->watched = 0;
    if (pair->has_material && pinch_manifold_continue(&pair->manifold, pose, detected, count, &rules)) {
        tell_places(store, pair, detected, count);
        return true;
    }
    pinch_manifold_point point[PINCH_MANIFOLD_POINTS];
    pinch_manifold updated = {pair->manifold.count, point};
    if (updated.count > 0) memcpy(point, pair->manifold.point, (size_t)updated.count * sizeof *point);
    pinch_manifold_update(&updated, pose, detected, count, &rules);
    tell_places(store, pair, detected, count);
    pair->watched = pinch_points_to_watch(&kept, &updated, detected, count);
    bool grows = updated.count > pair->room ||
                 !(pair->has_material || keeps_own_laws(store, &pair->manifold, &updated, detected, count));
    if (!grows && pair->has_material) return store_points(store, pair, &updated);
    bool locked = task->threaded && grows; /* seldom: it takes blocks, or gives some back */
    if (locked) mtx_lock(&store->workers_lock);
    if (!pair->has_material && grows) give_back_own_laws(store, &pair->manifold, &updated);
    bool stored = store_points(store, pair, &updated) &&
                  (pair->has_material || store_own_laws(store, pair, detected, count, rules.most_points));
    if (locked) mtx_unlock(&store->workers_lock);
    return stored;
}

static bool is_unchanged(const pinch_pair *pair)
{
    return pair->unchanged && pair->buffered_count == pair->buffered_before;
}

/* Tells whether the points of an unchanged pair are still there that the collider does not return. */
static bool watched_points_stay(const update_task *task, const pinch_pair *pair)
{
    pinch_kept_points kept;
    if (!pair->watched) return true;
    compute_poses(task, pair);
    const pinch_pose pose[2] = {pinch_side_pose(pair->id[0], pair->body[0]),
                                pinch_side_pose(pair->id[1], pair->body[1])};
    pinch_kept_points_init(&kept, task->store, pair, pose,
                           task->settings->merge_distance * pinch_pair_size(task->store, pair));
    return pinch_watched_points_stay(&kept);
}

enum { AHEAD = 6 };

/* Asks ahead for what updating a pair reads, but for the laws of its points. */
static void prefetch_pair(const pinch_contact_store *store, const pinch_pair *pair)
{
    pinch_prefetch_points(pair);
    if (pair->first_buffered >= 0) /* mostly they follow each other */
        pinch_prefetch(&store->buffer.items[pair->first_buffered],
                       (size_t)pair->buffered_count * sizeof *store->buffer.items);
    for (int side = 0; side < 2; side++) {
        if (pair->id[side]) pinch_prefetch(pair->id[side], 4 * PINCH_CACHE_LINE);
        if (pair->body[side]) pinch_prefetch(pair->body[side], 8 * PINCH_CACHE_LINE);
    }
}

/* ODE's height fields move what they are asked about, and then back again: no other thread may look at it meanwhile. */
static bool moves_geoms(const pinch_pair *pair)
{
    for (int side = 0; side < 2; side++)
        if (pair->id[side] && dGeomGetClass(pair->id[side]) == dHeightfieldClass) return true;
    return false;
}

/* Tells whether a pair waits for the one thread that goes on after the others. Of most pairs that rest no geom is read.
 */
static bool waits(const update_task *task, const pinch_pair *pair)
{
    return task->threaded && (pair->watched || !is_unchanged(pair)) && moves_geoms(pair);
}

/* Returns false when memory runs out. *same_points: whether the pair has as many as when islands were built, too. */
static bool update_if_changed(const update_task *task, int worker, pinch_pair *pair, bool *same_points)
{
    pair->unchanged = is_unchanged(pair) && watched_points_stay(task, pair);
    bool done = pair->unchanged || update_pair(task, worker, pair);
    *same_points = *same_points && pair->points_when_built == pair->manifold.count;
    return done;
}

static void update_pairs(void *context, int worker, int first, int end)
{
    update_task *task = context;
    pinch_pair *pairs = task->store->pairs.items;
    bool same_points = true;
    for (int i = first; i < end; i++) {
        if (i + AHEAD < end) {
            const pinch_pair *later = &pairs[i + AHEAD], *next = &pairs[i + AHEAD / 2];
            if (!is_unchanged(later)) prefetch_pair(task->store, later);
            if (!is_unchanged(next)) pinch_prefetch_own_laws(next);
        }
        if (waits(task, &pairs[i]))
            atomic_store(&task->some_wait, true);
        else if (!update_if_changed(task, worker, &pairs[i], &same_points))
            atomic_store(&task->out_of_memory, true);
    }
    if (!same_points) atomic_store(&task->other_points, true);
}

static void update_those_that_wait(update_task *task)
{
    pinch_contact_store *store = task->store;
    bool same_points = true;
    task->threaded = false;
    for (int i = 0; i < store->pairs.count; i++)
        if (moves_geoms(&store->pairs.items[i]) && !update_if_changed(task, 0, &store->pairs.items[i], &same_points))
            atomic_store(&task->out_of_memory, true);
    if (!same_points) atomic_store(&task->other_points, true);
}

bool pinch_pairs_update(pinch_contact_store *store, const pinch_step_context *context, pinch_workers *workers)
{
    enum { PAIRS_AT_A_TIME = 32 };
    store->unchanged = store->unchanged && store->buffer.count == store->buffered_before;
    store->same_points = store->unchanged;
    if (store->unchanged) return true;
    if (!store->all_pairs_came && drop_pairs(store, false, context->number)) store->same_bodies = false;
    store->buffered_before = store->same_places ? store->buffer.count : -1;
    store->directions_before = store->same_places ? store->directions.count : -1;
    update_task task = {store, &context->settings, workers != NULL, false, false, false};
    pinch_workers_run(workers, update_pairs, &task, store->pairs.count, PAIRS_AT_A_TIME);
    if (task.some_wait) update_those_that_wait(&task);
    store->same_points = !task.other_points;
    return !task.out_of_memory;
}
