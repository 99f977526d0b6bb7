/*
 * The island builder finds the bodies that take part in a step, what ties them together, and where the data of each
 * island go.
 */
#include "islands/island_graph.h"

#include <stdlib.h>
#include <string.h>

void pinch_island_graph_free(pinch_island_graph *graph)
{
    for (int i = 0; i < graph->memories.count; i++) pinch_step_memory_destroy(graph->memories.items[i]);
    free(graph->memories.items);
    free(graph->items);
    free(graph->roots.items);
    free(graph->before.pairs.items);
    free(graph->before.islands.items);
    free(graph->before.bodies.items);
    free(graph->fallback_contacts.items);
    free(graph->handed.items);
    free(graph->handed_when_built.items);
    pinch_backoff_free(&graph->backoff);
    pinch_accounts_free(&graph->accounts);
    pinch_sleep_free(&graph->sleep);
    pinch_kinematic_bodies_free(&graph->kinematic);
    pinch_step_bodies_free(&graph->bodies);
}

size_t pinch_island_graph_bytes(const pinch_island_graph *graph)
{
    size_t bytes = PINCH_LIST_BYTES(*graph) + PINCH_LIST_BYTES(graph->roots) + PINCH_LIST_BYTES(graph->before.pairs) +
                   PINCH_LIST_BYTES(graph->before.islands) + PINCH_LIST_BYTES(graph->before.bodies) +
                   PINCH_LIST_BYTES(graph->fallback_contacts) + PINCH_LIST_BYTES(graph->handed) +
                   PINCH_LIST_BYTES(graph->handed_when_built) + pinch_step_bodies_bytes(&graph->bodies) +
                   pinch_backoff_bytes(&graph->backoff) + pinch_accounts_bytes(&graph->accounts) +
                   pinch_sleep_bytes(&graph->sleep) + pinch_kinematic_bodies_bytes(&graph->kinematic);
    for (int k = 0; k < graph->memories.count; k++) bytes += pinch_step_memory_size(graph->memories.items[k]);
    return bytes;
}

static void forget_handed(pinch_island_graph *graph, dBodyID body)
{
    int kept = 0;
    for (int k = 0; k < graph->handed.count; k++)
        if (graph->handed.items[k] != body) graph->handed.items[kept++] = graph->handed.items[k];
    graph->handed.count = kept;
}

void pinch_forget_memories(pinch_island_graph *graph, const pinch_key_map *bodies)
{
    static const pinch_step_factors none;
    for (int k = 0; k < graph->memories.count && bodies->entries.count > 0; k++) {
        uint64_t first = pinch_step_memory_read(graph->memories.items[k]).tag; /* of its island's bodies */
        if (pinch_key_map_get(bodies, first) >= 0)
            (void)pinch_step_memory_write(graph->memories.items[k], &none); /* takes no memory */
    }
}

void pinch_island_graph_forget(pinch_island_graph *graph, dBodyID body)
{
    bool driven;
    forget_handed(graph, body);
    pinch_backoff_forget(&graph->backoff, body);
    pinch_accounts_forget(&graph->accounts, body);
    pinch_sleep_forget(&graph->sleep, body);
    (void)pinch_drives_set(&graph->bodies.drives, body, NULL, 0, &driven);
}

/* Collects the bodies of all pairs, and joins those that touch. Pairs that follow each other mostly have a body in
 * common. Returns false when memory runs out. */
static bool collect_bodies(pinch_step_bodies *bodies, pinch_contact_store *contacts)
{
    dBodyID last[2] = {NULL, NULL};
    int place[2] = {PINCH_NOT_A_STEP_BODY, PINCH_NOT_A_STEP_BODY};
    pinch_step_bodies_clear(bodies);
    for (int i = 0; i < contacts->pairs.count; i++) {
        pinch_pair *pair = &contacts->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        for (int side = 0; side < 2; side++) {
            if (pair->body[side] != last[side]) place[side] = pinch_step_bodies_add(bodies, pair->body[side]);
            if (place[side] == PINCH_NO_ROOM_FOR_BODY) return false;
            last[side] = pair->body[side];
            pair->step_body[side] = place[side];
        }
        pinch_step_bodies_join(bodies, place[0], place[1]);
    }
    return true;
}

/* Adds the bodies that were handed over for their joints. A disabled one takes part where another of its island is
 * enabled. Returns false when memory runs out. */
static bool collect_handed_bodies(pinch_island_graph *graph)
{
    int count = graph->handed.count;
    if (!PINCH_RESERVE(graph->handed_when_built, count)) return false;
    graph->handed_when_built.count = count;
    for (int k = 0; k < count; k++) {
        dBodyID body = graph->handed_when_built.items[k] = graph->handed.items[k];
        if (!dBodyIsEnabled(body) || dBodyIsKinematic(body)) continue;
        if (pinch_step_bodies_add(&graph->bodies, body) == PINCH_NO_ROOM_FOR_BODY) return false;
    }
    return true;
}

static bool same_handed_bodies(const pinch_island_graph *graph)
{
    const dBodyID *now = graph->handed.items, *then = graph->handed_when_built.items;
    int count = graph->handed.count;
    return count == graph->handed_when_built.count &&
           (count == 0 || memcmp(now, then, (size_t)count * sizeof(dBodyID)) == 0);
}

/* Numbers the islands by their first body. Afterwards a step body's `parent` is its island. Returns false when memory
 * runs out. */
static bool number_islands(pinch_island_graph *graph)
{
    pinch_step_bodies *bodies = &graph->bodies;
    int n = bodies->count, islands = 0;
    if (!PINCH_RESERVE(graph->roots, n + 1) || !PINCH_RESERVE(bodies->by_island, n + 1)) return false;
    for (int i = 0; i < n; i++) {
        graph->roots.items[i] = pinch_step_bodies_root(bodies, i);
        islands += graph->roots.items[i] == i;
    }
    if (!PINCH_RESERVE(*graph, islands + 1)) return false;
    memset(graph->items, 0, (size_t)islands * sizeof *graph->items);
    graph->count = 0;
    for (int i = 0; i < n; i++) {
        int root = graph->roots.items[i]; /* never larger than its members */
        pinch_step_body *b = &bodies->items[i];
        b->parent = root == i ? graph->count++ : bodies->items[root].parent;
        b->local = graph->items[b->parent].bodies.count++;
    }
    return true;
}

/* Makes sure that there is a memory for each island, and a few more, as many as the list has room for: in heaps the
 * number of islands varies. Returns false when memory runs out. */
static bool create_memories(pinch_island_graph *graph)
{
    if (!PINCH_RESERVE(graph->memories, graph->count)) return false;
    while (graph->memories.count < graph->memories.room && graph->memories.items) {
        if (pinch_step_memory_create(&graph->memories.items[graph->memories.count]) != PINCH_OK) break;
        graph->memories.count++;
    }
    return graph->memories.count >= graph->count;
}

/* Begins a range after the one before it, empty; its members are added one by one. */
static void begin_range(pinch_range *range, int *end)
{
    range->first = *end;
    *end += range->count;
    range->count = 0;
}

static void lay_out_bodies(pinch_island_graph *graph)
{
    int end = 0;
    pinch_step_bodies *bodies = &graph->bodies;
    for (int k = 0; k < graph->count; k++) begin_range(&graph->items[k].bodies, &end);
    for (int i = 0; i < bodies->count; i++) {
        pinch_range *range = &graph->items[bodies->items[i].parent].bodies;
        bodies->by_island.items[range->first + range->count++] = i;
    }
}

/* Lays out the contacts, which are read out pair by pair and solved island by island. Returns false when memory runs
 * out. */
static bool lay_out_contacts(pinch_island_graph *graph, pinch_contact_store *contacts)
{
    int points = 0, pairs = 0;
    for (int i = 0; i < contacts->pairs.count; i++) {
        pinch_pair *pair = &contacts->pairs.items[i];
        pair->first_result = points;
        pair->points_when_built = pair->manifold.count;
        if (pair->manifold.count == 0) continue;
        int body = pair->step_body[0] >= 0 ? pair->step_body[0] : pair->step_body[1];
        pair->island = graph->bodies.items[body].parent;
        graph->items[pair->island].contacts.count += pair->manifold.count;
        graph->items[pair->island].pairs.count++;
        points += pair->manifold.count;
        pairs++;
    }
    if (!PINCH_RESERVE(contacts->results, points + 1) || !PINCH_RESERVE(contacts->pairs_by_island, pairs + 1))
        return false;
    contacts->results.count = points;
    points = pairs = 0;
    for (int k = 0; k < graph->count; k++) {
        begin_range(&graph->items[k].contacts, &points);
        begin_range(&graph->items[k].pairs, &pairs);
    }
    for (int i = 0; i < contacts->pairs.count; i++) {
        pinch_pair *pair = &contacts->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        pinch_island *island = &graph->items[pair->island];
        contacts->pairs_by_island.items[island->pairs.first + island->pairs.count++] = i;
        pair->first_in_island = island->contacts.count;
        island->contacts.count += pair->manifold.count;
    }
    return true;
}

/* Returns the joints of the island that a joint belongs to, NULL where it ties nothing that moves by itself. */
static pinch_range *joints_beside(pinch_island_graph *graph, const pinch_step_joint *joint)
{
    int body = joint->body[0] >= 0 ? joint->body[0] : joint->body[1];
    return body < 0 ? NULL : &graph->items[graph->bodies.items[body].parent].joints.range;
}

static bool lay_out_joints(pinch_island_graph *graph, pinch_joint_store *joints)
{
    int end = 0;
    if (!PINCH_RESERVE(joints->by_island, joints->count + 1)) return false;
    for (int j = 0; j < joints->count; j++) {
        pinch_range *range = joints_beside(graph, &joints->items[j]);
        if (range) range->count++;
    }
    for (int k = 0; k < graph->count; k++) begin_range(&graph->items[k].joints.range, &end);
    for (int j = 0; j < joints->count; j++) {
        pinch_range *range = joints_beside(graph, &joints->items[j]);
        if (range) joints->by_island.items[range->first + range->count++] = j;
    }
    return true;
}

/* Lays out the couplings that act, and the rows of all islands: those of couplings stand beside those of joints. */
static void lay_out_couplings(pinch_island_graph *graph, pinch_joint_store *joints)
{
    pinch_couplings *couplings = &joints->couplings;
    int end = 0;
    for (int k = 0; k < couplings->count; k++)
        if (couplings->items[k].acts)
            graph->items[graph->bodies.items[couplings->items[k].body].parent].joints.couplings.count++;
    joints->row_room = 0;
    for (int k = 0; k < graph->count; k++) {
        begin_range(&graph->items[k].joints.couplings, &end);
        graph->items[k].joints.room.count =
            pinch_row_room(&graph->bodies, graph->items[k].joints.range.count, graph->items[k].bodies.count);
    }
    for (int k = 0; k < couplings->count; k++) {
        if (!couplings->items[k].acts) continue;
        pinch_island_joints *own = &graph->items[graph->bodies.items[couplings->items[k].body].parent].joints;
        couplings->by_island.items[own->couplings.first + own->couplings.count++] = k;
        own->room.count += couplings->items[k].count;
    }
    for (int k = 0; k < graph->count; k++) {
        graph->items[k].joints.room.first = joints->row_room;
        joints->row_room += graph->items[k].joints.room.count;
    }
}

/* Keeps what is known of hinges whose islands have rested since these were built: nobody has asked for it. */
static void keep_references_at_rest(const pinch_island_graph *graph, pinch_joint_store *joints, long step)
{
    for (int k = 0; k < graph->count; k++) {
        const pinch_island_joints *own = &graph->items[k].joints;
        for (int j = 0; j < own->range.count && graph->items[k].phase >= PINCH_ISLAND_RESTING; j++)
            pinch_keep_hinge_reference(&joints->references, pinch_island_joint(joints, own, j)->reference, step);
    }
}

/* Tells whether the islands of the last step are those of this one; then they also know what they were. */
static bool island_cache_valid(pinch_island_graph *graph, const pinch_contact_store *contacts,
                               const pinch_joint_store *joints)
{
    if (!contacts->same_bodies || !contacts->same_points || graph->sleepers || !same_handed_bodies(graph)) return false;
    return pinch_same_joints_and_bodies(joints, &graph->bodies, contacts);
}

bool pinch_update_islands(pinch_island_graph *graph, pinch_contact_store *contacts, pinch_joint_store *joints,
                          const pinch_step_context *context, pinch_ode_stats *stats)
{
    if (island_cache_valid(graph, contacts, joints)) {
        pinch_update_kinematic_hinges(joints, context->number);
        return pinch_motion_is_laid_out(&graph->kinematic) ||
               pinch_lay_out_motion(graph, contacts, joints); /* a snapshot does not have it */
    }
    graph->kinematic.laid_out = false;
    keep_references_at_rest(graph, joints, context->number);
    if (!pinch_note_resting(graph, contacts, context) || !collect_bodies(&graph->bodies, contacts) ||
        !collect_handed_bodies(graph) ||
        !pinch_collect_joints(joints, &graph->bodies, contacts, context->number, &stats->joints_unmodelled) ||
        !number_islands(graph) || !create_memories(graph))
        return false;
    pinch_find_sleepers(graph, contacts, joints, context);
    lay_out_bodies(graph);
    if (!lay_out_contacts(graph, contacts) || !lay_out_joints(graph, joints)) return false;
    lay_out_couplings(graph, joints);
    pinch_choose_sleepers(graph);
    pinch_carry_resting(graph, contacts);
    return pinch_lay_out_motion(graph, contacts, joints);
}
