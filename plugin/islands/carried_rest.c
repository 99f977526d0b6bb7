/*
 * What rests stays at rest while other islands come, go and change.
 *
 * As soon as one pair comes or goes anywhere, or has another number of points, all islands are built anew. An island of
 * the last step that is found again, of the same bodies and pairs with as many points, takes over what it was; whether
 * anything in it has changed is asked afterwards, as of any island at rest (rest.c). Islands with joints are solved
 * anew: what they rested on is kept by joint and by row, and these are collected anew, too.
 */
#include "islands/island_graph.h"

#include <string.h>

static bool may_be_carried(const pinch_island *island)
{
    return island->phase >= PINCH_ISLAND_RESTING && island->pairs.count > 0 && island->joints.range.count == 0 &&
           island->joints.couplings.count == 0 && island->drive_rows == 0;
}

bool pinch_note_resting(pinch_island_graph *graph, const pinch_contact_store *contacts,
                        const pinch_step_context *context)
{
    pinch_islands_before *before = &graph->before;
    bool any = false;
    before->pairs.count = before->islands.count = before->bodies.count = 0;
    for (int k = 0; k < graph->count && !any; k++) any = may_be_carried(&graph->items[k]);
    if (!any || context->settings.keep_islands) return true; /* problems that are kept lie where islands were */
    if (!PINCH_RESERVE(before->pairs, contacts->pairs.count) || !PINCH_RESERVE(before->islands, graph->count) ||
        !PINCH_RESERVE(before->bodies, graph->bodies.count))
        return false;
    memcpy(before->islands.items, graph->items, (size_t)graph->count * sizeof *graph->items);
    memcpy(before->bodies.items, graph->bodies.items, (size_t)graph->bodies.count * sizeof *graph->bodies.items);
    before->islands.count = graph->count;
    before->bodies.count = graph->bodies.count;
    before->pairs.count = contacts->pairs.count;
    for (int i = 0; i < contacts->pairs.count; i++) {
        const pinch_pair *pair = &contacts->pairs.items[i];
        before->pairs.items[i] = (pinch_pair_before){.island = pair->points_when_built > 0 ? pair->island : -1,
                                                     .points = pair->points_when_built,
                                                     .first_result = pair->first_result,
                                                     .step_body = {pair->step_body[0], pair->step_body[1]}};
    }
    return true;
}

/* Tells whether a pair is between the bodies and has as many points as in the last step. */
static bool same_pair(const pinch_islands_before *before, const pinch_step_bodies *bodies, const pinch_pair *pair,
                      const pinch_pair_before *was)
{
    bool same = was->island >= 0 && was->points == pair->manifold.count;
    for (int side = 0; side < 2 && same; side++) {
        int now = pair->step_body[side], then = was->step_body[side];
        same = now < 0 || then < 0 ? now < 0 && then < 0 : bodies->items[now].body == before->bodies.items[then].body;
    }
    return same;
}

/* Returns the island of the last step that this one is, NULL for none. */
static const pinch_island *same_island(const pinch_island_graph *graph, const pinch_contact_store *contacts,
                                       const pinch_island *island)
{
    const pinch_islands_before *before = &graph->before;
    int was = -1;
    if (island->phase != PINCH_ISLAND_AWAKE || island->may_sleep || island->pairs.count == 0 ||
        island->joints.range.count > 0 || island->joints.couplings.count > 0)
        return NULL;
    for (int i = 0; i < island->pairs.count; i++) {
        int index = contacts->pairs_by_island.items[island->pairs.first + i];
        const pinch_pair_before *pair = &before->pairs.items[index];
        if (!same_pair(before, &graph->bodies, &contacts->pairs.items[index], pair)) return NULL;
        if (was >= 0 && pair->island != was) return NULL;
        was = pair->island;
    }
    const pinch_island *same = &before->islands.items[was];
    return may_be_carried(same) && same->pairs.count == island->pairs.count &&
                   same->bodies.count == island->bodies.count
               ? same
               : NULL;
}

static void carry_island(const pinch_island *from, pinch_island *to)
{
    pinch_island carried = *from;
    carried.bodies = to->bodies;
    carried.pairs = to->pairs;
    carried.contacts = to->contacts;
    carried.kinematic = to->kinematic;
    carried.joints = to->joints;
    *to = carried;
}

/* Has a body rest as it did. */
static void carry_body(const pinch_step_body *from, pinch_step_body *to)
{
    memcpy(to->position, from->position, sizeof to->position);
    memcpy(to->wrench, from->wrench, sizeof to->wrench);
    memcpy(to->velocity, from->velocity, sizeof to->velocity);
    to->rest_bits = from->rest_bits;
}

/* Moves the results of a carried pair to where it has them now. */
static void carry_results(const pinch_islands_before *before, pinch_contact_store *contacts, int index, bool to_front)
{
    const pinch_pair *pair = &contacts->pairs.items[index];
    int from = before->pairs.items[index].first_result, to = pair->first_result;
    if (!before->pairs.items[index].carried || (to < from) != to_front || to == from) return;
    memmove(&contacts->results.items[to], &contacts->results.items[from],
            (size_t)pair->manifold.count * sizeof *contacts->results.items);
}

void pinch_carry_resting(pinch_island_graph *graph, pinch_contact_store *contacts)
{
    pinch_islands_before *before = &graph->before;
    int count = before->pairs.count;
    if (count == 0) return;
    for (int i = 0; i < count; i++) before->pairs.items[i].carried = false;
    for (int k = 0; k < graph->count; k++) {
        pinch_island *island = &graph->items[k];
        const pinch_island *same = same_island(graph, contacts, island);
        if (!same) continue;
        carry_island(same, island);
        for (int i = 0; i < island->pairs.count; i++) {
            int index = contacts->pairs_by_island.items[island->pairs.first + i];
            const pinch_pair *pair = &contacts->pairs.items[index];
            before->pairs.items[index].carried = true;
            for (int side = 0; side < 2; side++)
                if (pair->step_body[side] >= 0)
                    carry_body(&before->bodies.items[before->pairs.items[index].step_body[side]],
                               &graph->bodies.items[pair->step_body[side]]);
        }
    }
    /* Pairs keep their order, and so do their results. Those that go to the front are moved from the first on, the
     * others from the last, so that none is written over before it has been moved. */
    for (int i = 0; i < count; i++) carry_results(before, contacts, i, true);
    for (int i = count - 1; i >= 0; i--) carry_results(before, contacts, i, false);
}
