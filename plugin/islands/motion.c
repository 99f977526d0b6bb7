/*
 * Pinch moves the bodies that ODE would only integrate, each island's by one thread. ODE, which takes a body without
 * joints for an island of its own, does not see them meanwhile.
 *
 * Geoms are told afterwards, by one thread and in an order that depends on the islands alone: those that are told last
 * come first in simple and hash spaces, and are the first to be tested for contacts. ODE tells geoms as well, those of
 * its newest body first. What it moved in this step comes behind what Pinch moved, and so do kinematic bodies that only
 * joints tie to an island: whoever moves them.
 */
#include "islands/island_life.h"

#include "bodies/body_motion.h"
#include "joints/joint_store.h"
#include "util/prefetch.h"

#include "support/loop.h"

#include <stdlib.h>
#include <string.h>

void pinch_kinematic_bodies_free(pinch_kinematic_bodies *kinematic)
{
    free(kinematic->items);
    free(kinematic->by_island.items);
    pinch_item_index_free(&kinematic->index);
}

size_t pinch_kinematic_bodies_bytes(const pinch_kinematic_bodies *kinematic)
{
    return PINCH_LIST_BYTES(*kinematic) + PINCH_LIST_BYTES(kinematic->by_island) +
           pinch_item_index_bytes(&kinematic->index);
}

/* ---- layout ---- */

/* Adds a body of a pair, or that side of the joint `tie`, where it is kinematic and new. Returns false when memory runs
 * out. */
static bool add_kinematic(pinch_island_graph *graph, dBodyID body, int island, dJointID tie, int side)
{
    pinch_kinematic_bodies *all = &graph->kinematic;
    if (!body || !dBodyIsKinematic(body)) return true;
    pinch_item_keys keys = PINCH_ITEM_KEYS(*all, pinch_kinematic_body, body);
    int known = pinch_item_index_get(&all->index, keys, &body);
    if (known >= 0) {
        all->items[known].shared = all->items[known].shared || all->items[known].island != island;
        return true;
    }
    if (!PINCH_RESERVE(*all, all->count + 1)) return false;
    keys = PINCH_ITEM_KEYS(*all, pinch_kinematic_body, body);
    if (!pinch_item_index_add(&all->index, keys, &body, all->count)) return false;
    all->items[all->count++] = (pinch_kinematic_body){.body = body, .island = island, .tie = tie, .side = side};
    graph->items[island].kinematic.count++;
    return true;
}

static bool make_room_for_inverses(pinch_step_bodies *bodies)
{
    if (!PINCH_RESERVE(bodies->inverses, bodies->count)) return false;
    int known = bodies->inverses.count;
    if (known >= bodies->count) return true;
    memset(bodies->inverses.items + known, 0, (size_t)(bodies->count - known) * sizeof *bodies->inverses.items);
    bodies->inverses.count = bodies->count;
    return true;
}

/* Adds the kinematic bodies that an island's joints tie to it, as the base of a hand is. Returns false when memory runs
 * out. */
static bool add_kinematic_of_joints(pinch_island_graph *graph, const pinch_joint_store *joints, int island)
{
    const pinch_island_joints *own = &graph->items[island].joints;
    for (int j = 0; j < own->range.count; j++) {
        const pinch_step_joint *joint = pinch_island_joint(joints, own, j);
        for (int side = 0; side < 2; side++)
            if (joint->body[side] < 0 &&
                !add_kinematic(graph, dJointGetBody(joint->joint, side), island, joint->joint, side))
                return false;
    }
    return true;
}

/* Islands are the same when a joint ties another kinematic body than before, or none, as when that has been destroyed:
 * so bodies are asked for at their joints, which are still there. */
bool pinch_motion_is_laid_out(const pinch_kinematic_bodies *kinematic)
{
    for (int i = 0; i < kinematic->count && kinematic->laid_out; i++) {
        const pinch_kinematic_body *b = &kinematic->items[i];
        if (b->tie && dJointGetBody(b->tie, b->side) != b->body) return false;
    }
    return kinematic->laid_out;
}

bool pinch_lay_out_motion(pinch_island_graph *graph, const pinch_contact_store *contacts,
                          const pinch_joint_store *joints)
{
    pinch_kinematic_bodies *all = &graph->kinematic;
    int end = 0;
    all->count = 0;
    pinch_item_index_clear(&all->index);
    for (int k = 0; k < graph->count; k++) graph->items[k].kinematic.count = 0;
    for (int i = 0; i < contacts->pairs.count; i++) {
        const pinch_pair *pair = &contacts->pairs.items[i];
        for (int side = 0; side < 2 && pair->manifold.count > 0; side++)
            if (pair->step_body[side] < 0 && !add_kinematic(graph, pair->body[side], pair->island, NULL, 0))
                return false;
    }
    for (int k = 0; k < graph->count; k++)
        if (!add_kinematic_of_joints(graph, joints, k)) return false;
    if (!PINCH_RESERVE(all->by_island, all->count) || !make_room_for_inverses(&graph->bodies)) return false;
    for (int k = 0; k < graph->count; k++) {
        pinch_range *range = &graph->items[k].kinematic;
        range->first = end;
        end += range->count;
        range->count = 0;
    }
    for (int i = 0; i < all->count; i++) {
        pinch_range *range = &graph->items[all->items[i].island].kinematic;
        all->by_island.items[range->first + range->count++] = i;
    }
    return all->laid_out = true;
}

/* ---- a step ---- */

/* Looking through the joints of a body takes ODE time with their square. */
static bool has_few_joints(dBodyID body)
{
    enum { FEW = 16 };
    return dBodyGetNumJoints(body) <= FEW;
}

/* Of what rests, ODE is to see driven bodies alone. */
static int resting_bodies(const pinch_step_bodies *bodies, const pinch_island *island)
{
    int count = island->bodies.count;
    for (int k = 0; k < island->bodies.count && bodies->drives.count > 0; k++)
        count -= pinch_island_body(bodies, island->bodies, k)->drive >= 0;
    return count;
}

void pinch_set_bodies_aside(const pinch_step_context *context, pinch_island_graph *graph, pinch_island *island)
{
    bool moves = context->settings.move_bodies && !context->settings.ode_solves;
    bool all_forces = moves && pinch_island_is_solved(island) && !island->skipped_by_ode && !island->may_sleep;
    bool alone = island->joints.by_pinch && island->joints.alone;
    island->moved_by_pinch = all_forces;
    island->aside = island->skipped_by_ode ? resting_bodies(&graph->bodies, island) : 0;
    for (int k = 0; k < island->bodies.count && all_forces; k++) {
        pinch_step_body *b = pinch_island_body(&graph->bodies, island->bodies, k);
        b->by_pinch = alone ? pinch_body_stays_awake(b->body) : pinch_body_moves_alone(b->body, pinch_first_joint(b));
        if (b->by_pinch) dBodyDisable(b->body);
        island->aside += b->by_pinch;
    }
    for (int k = 0; k < island->kinematic.count; k++) {
        pinch_kinematic_body *b = pinch_kinematic_body_of(graph, island, k);
        b->by_pinch =
            moves && dBodyIsKinematic(b->body) && has_few_joints(b->body) && pinch_body_moves_alone(b->body, 0);
        if (b->by_pinch) dBodyDisable(b->body);
        island->aside += b->by_pinch;
    }
}

static void move(const pinch_step_context *context, dBodyID body, pinch_inverse_inertia *inverse, bool moves)
{
    dBodyEnable(body);
    if (moves) pinch_move_body(body, context->gravity_now, context->h, inverse);
}

typedef struct move_task {
    const pinch_step_context *context;
    pinch_step_bodies *bodies;
    const pinch_island *island;
    bool moves;
} move_task;

static void move_some(void *argument, int first, int end)
{
    enum { AHEAD = 4 };
    const move_task *task = argument;
    pinch_step_bodies *bodies = task->bodies;
    for (int k = first; k < end; k++) {
        if (k + AHEAD < end)
            pinch_prefetch_to_write(pinch_island_body(bodies, task->island->bodies, k + AHEAD)->body, PINCH_BODY_BYTES);
        int index = bodies->by_island.items[task->island->bodies.first + k];
        if (bodies->items[index].by_pinch)
            move(task->context, bodies->items[index].body, &bodies->inverses.items[index], task->moves);
    }
}

void pinch_move_bodies(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island,
                       const pinch_crew *crew, bool moves)
{
    move_task task = {context, &graph->bodies, island, moves};
    if (island->moved_by_pinch) pinch_each(crew, island->bodies.count, move_some, &task);
    for (int k = 0; k < island->kinematic.count; k++) {
        const pinch_kinematic_body *b = pinch_kinematic_body_of(graph, island, k);
        if (b->by_pinch && !b->shared) move(context, b->body, NULL, moves);
    }
}

void pinch_move_shared_bodies(const pinch_step_context *context, const pinch_island_graph *graph, bool moves)
{
    for (int i = 0; i < graph->kinematic.count; i++) {
        const pinch_kinematic_body *b = &graph->kinematic.items[i];
        if (b->by_pinch && b->shared) move(context, b->body, NULL, moves);
    }
}

/* Does something with each body of an island that Pinch has moved, from the last to the first. */
static void for_each_moved(const pinch_island_graph *graph, const pinch_island *island, void (*work)(dBodyID body))
{
    for (int k = island->kinematic.count - 1; k >= 0; k--) {
        const pinch_kinematic_body *b = pinch_kinematic_body_of(graph, island, k);
        if (b->by_pinch && !b->tie) work(b->body);
    }
    for (int k = island->bodies.count - 1; k >= 0 && island->moved_by_pinch; k--) {
        const pinch_step_body *b = pinch_island_body(&graph->bodies, island->bodies, k);
        if (b->by_pinch) work(b->body);
    }
}

/* Of a body it is needed which geom it has, which ODE keeps in the first two lines. Another thread may have moved the
 * body: what is not needed stays in that one's cache. */
static void prefetch_first_geom(dBodyID body)
{
    pinch_prefetch(body, 2 * PINCH_CACHE_LINE);
}

/* Which geom a body has stands in the body, which therefore is asked for one island earlier. What ODE reads of a geom
 * that has moved lies in the first three lines or so of its memory. */
static void prefetch_geom(dBodyID body)
{
    dGeomID geom = dBodyGetFirstGeom(body);
    if (geom) pinch_prefetch_to_write(geom, 3 * PINCH_CACHE_LINE);
}

void pinch_tell_geoms_of_islands(const pinch_island_graph *graph, bool ahead)
{
    for (int i = graph->kinematic.count - 1; i >= 0; i--) {
        const pinch_kinematic_body *b = &graph->kinematic.items[i];
        if (b->by_pinch && b->tie) pinch_tell_geoms(b->body);
    }
    for (int k = graph->count - 1; k >= 0; k--) {
        if (ahead && k >= 2) for_each_moved(graph, &graph->items[k - 2], prefetch_first_geom);
        if (ahead && k >= 1) for_each_moved(graph, &graph->items[k - 1], prefetch_geom);
        for_each_moved(graph, &graph->items[k], pinch_tell_geoms);
    }
}
