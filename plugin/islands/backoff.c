/*
 * Back-off: islands that ODE or sweeps have to solve, again and again, are left to these for a while without a try.
 *
 * A try in vain costs time, and where joints were solved too coarsely it costs more than that. So an island that goes
 * wrong is left to them for a span of steps, which is twice as long each time that it goes wrong again soon after the
 * last span: what tries cost in vain grows with the logarithm of the number of steps. Other islands go on as before.
 *
 * Islands part and merge from step to step, bodies stay. So spans are kept by body: each body of the island has its
 * span, and an island waits for the longest of its bodies'. A heap that has come apart is tried again, whatever its
 * bodies' spans say.
 */
#include "islands/island_life.h"

#include <stdlib.h>
#include <string.h>

/* Sweeps bring a heap so close to rest that a solve soon has next to nothing to do. */
enum { LONGEST_SPAN = 1 << 24, LONGEST_SWEPT = 32 };

/* The first span, in steps, by what went wrong. A solve that just failed is tried again in the next step, because it
 * often has an answer then. Joints need some steps to settle. */
enum { FIRST_WITHOUT_ANSWER = 0, FIRST_OVER_BUDGET = 1, FIRST_OF_JOINTS = 8 };

void pinch_backoff_free(pinch_backoff *b)
{
    free(b->items);
    pinch_item_index_free(&b->index);
}

size_t pinch_backoff_bytes(const pinch_backoff *b)
{
    return PINCH_LIST_BYTES(*b) + pinch_item_index_bytes(&b->index);
}

static pinch_item_keys keys_of(const pinch_backoff *b)
{
    return PINCH_ITEM_KEYS(*b, pinch_backed_off, body);
}

static pinch_backed_off *find(const pinch_backoff *b, dBodyID body)
{
    int place = pinch_item_index_get(&b->index, keys_of(b), &body);
    return place < 0 ? NULL : &b->items[place];
}

void pinch_backoff_forget(pinch_backoff *b, dBodyID body)
{
    int place = pinch_item_index_get(&b->index, keys_of(b), &body);
    if (place < 0) return;
    pinch_item_index_remove(&b->index, keys_of(b), place, b->count - 1);
    b->items[place] = b->items[--b->count]; /* their order says nothing */
}

static int size_of(const pinch_island *island)
{
    return island->contacts.count + island->joints.range.count;
}

/* Tells whether a body that goes wrong now has gone wrong not long ago. */
static bool recent(const pinch_backed_off *e, long now)
{
    return now - e->until <= (e->span > 1 ? e->span : 1);
}

bool pinch_backoff_holds(const pinch_step_context *context, const pinch_island_graph *graph, const pinch_island *island)
{
    bool may_be_swept = pinch_island_may_be_swept(context, island);
    for (int k = 0; k < island->bodies.count && graph->backoff.count > 0; k++) {
        const pinch_backed_off *e = find(&graph->backoff, pinch_island_body(&graph->bodies, island->bodies, k)->body);
        if (!e || context->number >= e->until || (e->swept && !may_be_swept)) continue;
        bool holds = e->joints ? context->solve_and_advance && island->joints.range.count >= e->size
                               : size_of(island) >= e->size;
        if (holds) return true;
    }
    return false;
}

bool pinch_went_wrong_lately(const pinch_step_context *context, const pinch_island_graph *graph,
                             const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count && graph->backoff.count > 0; k++) {
        const pinch_backed_off *e = find(&graph->backoff, pinch_island_body(&graph->bodies, island->bodies, k)->body);
        if (e && recent(e, context->number)) return true;
    }
    return false;
}

/* Drops bodies that have been well for long. They may be gone, too, and others may have come in their place. */
static void drop_recovered(pinch_backoff *b, long now)
{
    int kept = 0;
    if (b->dropped_step == now) return;
    b->dropped_step = now;
    for (int k = 0; k < b->count; k++)
        if (recent(&b->items[k], now)) b->items[kept++] = b->items[k];
    b->count = kept;
    (void)pinch_item_index_rebuild(&b->index, keys_of(b), kept); /* it has held as many before */
}

static void keep(pinch_backoff *b, const pinch_backed_off *entry)
{
    pinch_backed_off *known = find(b, entry->body);
    if (known) {
        *known = *entry;
        return;
    }
    if (!PINCH_RESERVE(*b, b->count + 1)) return; /* without memory the island is tried again at once */
    if (pinch_item_index_add(&b->index, keys_of(b), &entry->body, b->count)) b->items[b->count++] = *entry;
}

void pinch_judge_fallback(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island,
                          pinch_ode_stats *stats)
{
    bool swept = island->tried && island->phase == PINCH_ISLAND_SOLVED &&
                 (island->result.swept || pinch_solve_was_dear(context, island));
    bool failed = island->tried && (swept || island->phase == PINCH_ISLAND_FALLBACK);
    bool joints = pinch_joints_went_wrong(context, &graph->bodies, island);
    long now = context->number, span = joints                                ? FIRST_OF_JOINTS
                                       : swept || island->result.over_budget ? FIRST_OVER_BUDGET
                                                                             : FIRST_WITHOUT_ANSWER;
    pinch_backoff *b = &graph->backoff;
    if (!failed && !joints) return;
    drop_recovered(b, now);
    for (int k = 0; k < island->bodies.count; k++) {
        const pinch_backed_off *e = find(b, pinch_island_body(&graph->bodies, island->bodies, k)->body);
        long twice = e && e->swept == swept && recent(e, now) ? 2 * e->span + (e->span == 0) : 0;
        if (twice > span) span = twice;
    }
    long longest = swept ? LONGEST_SWEPT : LONGEST_SPAN;
    if (span > longest) span = longest;
    int size = joints ? island->joints.range.count : size_of(island);
    pinch_backed_off entry = {.until = now + 1 + span, .span = span, .joints = joints, .swept = swept};
    entry.size = size > 1 ? size / 2 : 1; /* what it may fall apart into */
    for (int k = 0; k < island->bodies.count; k++) {
        entry.body = pinch_island_body(&graph->bodies, island->bodies, k)->body;
        keep(b, &entry);
    }
    stats->backoffs += span > 0 && !swept;
}
