#include "support/block_order.h"

#include <stdlib.h>
#include <string.h>

/* The neighbours of a node that are still there, ascending. */
typedef struct neighbours {
    int *node;
    int count, room;
} neighbours;

/* Nodes by degree: doubly linked lists, so that the next one is found without a search of them all. */
typedef struct buckets {
    int *head; /* per degree */
    int *next, *previous;
    int lowest;
    int *awaited; /* per node: how many edges of the graph to early nodes are left; it waits, in no list, until then */
    int *late_start; /* per early node, and one more: where its late neighbours in the graph */
    int *late;       /* begin here */
} buckets;

static void unlink_node(buckets *b, int node, int degree)
{
    if (b->previous[node] >= 0)
        b->next[b->previous[node]] = b->next[node];
    else
        b->head[degree] = b->next[node];
    if (b->next[node] >= 0) b->previous[b->next[node]] = b->previous[node];
}

static void link_node(buckets *b, int node, int degree)
{
    b->next[node] = b->head[degree];
    b->previous[node] = -1;
    if (b->head[degree] >= 0) b->previous[b->head[degree]] = node;
    b->head[degree] = node;
    if (degree < b->lowest) b->lowest = degree;
}

static bool add_neighbour(pinch_arena *arena, neighbours *n, int node)
{
    int at = n->count;
    while (at > 0 && n->node[at - 1] > node) at--;
    if (at > 0 && n->node[at - 1] == node) return true;
    if (n->count == n->room) {
        int room = n->room ? 2 * n->room : 8;
        int *bigger = PINCH_ARENA_ARRAY(arena, int, room);
        if (!bigger) return false;
        if (n->count > 0) memcpy(bigger, n->node, sizeof(int) * (size_t)n->count);
        n->node = bigger;
        n->room = room;
    }
    memmove(n->node + at + 1, n->node + at, sizeof(int) * (size_t)(n->count - at));
    n->node[at] = node;
    n->count++;
    return true;
}

/* into[..] = a without `without`, united with b without `self`; both ascending. Returns the count. */
static int unite(const neighbours *a, int without, const neighbours *b, int self, int *into)
{
    int count = 0, i = 0, j = 0;
    while (i < a->count && j < b->count) { /* no jump in here can be foretold, and so there is none */
        int left = a->node[i], right = b->node[j], node = left < right ? left : right;
        into[count] = node;
        count += (node != without) & (node != self);
        i += left <= right;
        j += right <= left;
    }
    const neighbours *rest = i < a->count ? a : b;
    for (int k = i < a->count ? i : j; k < rest->count; k++) {
        into[count] = rest->node[k];
        count += (rest->node[k] != without) & (rest->node[k] != self);
    }
    return count;
}

/* What is left of `node`'s neighbours become neighbours of each other. */
static bool eliminate(pinch_arena *arena, neighbours *graph, int node, buckets *b, int *scratch)
{
    const neighbours *gone = &graph[node];
    for (int i = 0; i < gone->count; i++) {
        int other = gone->node[i];
        neighbours *n = &graph[other];
        int count = unite(n, node, gone, other, scratch);
        if (b->awaited[other] == 0) unlink_node(b, other, n->count);
        if (count > n->room) {
            int room = 2 * count;
            n->node = PINCH_ARENA_ARRAY(arena, int, room);
            if (!n->node) return false;
            n->room = room;
        }
        memcpy(n->node, scratch, sizeof(int) * (size_t)count);
        n->count = count;
        if (b->awaited[other] == 0) link_node(b, other, count);
    }
    return true;
}

/* Nodes for which this early one was the last to wait for may be eliminated now. */
static void release_late(const neighbours *graph, int node, buckets *b)
{
    for (int i = b->late_start[node]; i < b->late_start[node + 1]; i++)
        if (--b->awaited[b->late[i]] == 0) link_node(b, b->late[i], graph[b->late[i]].count);
}

static void sort_ascending(int *values, int count)
{
    for (int i = 1; i < count; i++) {
        int value = values[i], at = i;
        for (; at > 0 && values[at - 1] > value; at--) values[at] = values[at - 1];
        values[at] = value;
    }
}

/* Finds for each place that of its first later neighbour, its parent in the tree of elimination; `count`: it has none.
 */
static void find_parents(const neighbours *graph, int count, const pinch_block_order *o, int *parent)
{
    for (int k = 0; k < count; k++) {
        const neighbours *n = &graph[o->order[k]];
        parent[k] = count;
        for (int i = 0; i < n->count; i++) {
            int place = o->place[n->node[i]];
            if (place > k && place < parent[k]) parent[k] = place;
        }
    }
}

/*
 * Puts the nodes into an order in which each comes right after those whose elimination leads to it. That leaves the
 * same fill, and nodes with the same later neighbours follow each other. Returns false when memory ran out.
 */
static bool follow_tree(pinch_arena *arena, const neighbours *graph, int count, pinch_block_order *o)
{
    int *parent = PINCH_ARENA_ARRAY(arena, int, count + 1), *child = PINCH_ARENA_ARRAY(arena, int, count + 1);
    int *sibling = PINCH_ARENA_ARRAY(arena, int, count + 1), *order = PINCH_ARENA_ARRAY(arena, int, count + 1);
    if (arena->failed) return false;
    find_parents(graph, count, o, parent);
    for (int k = 0; k <= count; k++) child[k] = -1;
    for (int k = count - 1; k >= 0; k--) {
        sibling[k] = child[parent[k]];
        child[parent[k]] = k;
    }
    for (int k = child[count], at = 0; k >= 0;) {
        while (child[k] >= 0) {
            int first = child[k];
            child[k] = -1; /* the way back up does not lead down again */
            k = first;
        }
        order[at] = o->order[k];
        o->visit[k] = at++;
        k = sibling[k] >= 0 ? sibling[k] : parent[k] < count ? parent[k] : -1;
    }
    memcpy(o->order, order, sizeof *order * (size_t)count);
    for (int k = 0; k < count; k++) o->place[o->order[k]] = k;
    return true;
}

/* Writes the order in the place of everything since the mark, the graph included. */
static bool collect(pinch_arena *arena, const pinch_arena_mark *mark, const neighbours *graph, int count,
                    pinch_block_order *o)
{
    int room = 0, at = 0;
    for (int k = 0; k < count; k++) room += graph[o->order[k]].count;
    o->later = PINCH_ARENA_ARRAY(arena, int, room + 1);
    if (arena->failed) return false;
    for (int k = 0; k < count; k++) {
        const neighbours *n = &graph[o->order[k]];
        o->start[k] = at;
        for (int i = 0; i < n->count; i++)
            if (o->place[n->node[i]] > k) o->later[at++] = o->place[n->node[i]];
        sort_ascending(o->later + o->start[k], at - o->start[k]);
    }
    o->start[count] = o->entries = at;
    o->later = pinch_arena_rewind_but(arena, mark, o->later, sizeof *o->later * (size_t)(at + 1));
    return o->later != NULL;
}

/* Returns NULL when memory runs out. */
static neighbours *read_graph(pinch_arena *arena, const pinch_block_graph *blocks)
{
    int count = blocks->count;
    const int *edge = blocks->edge;
    neighbours *graph = PINCH_ARENA_ARRAY(arena, neighbours, count + 1);
    if (!graph) return NULL;
    memset(graph, 0, sizeof *graph * (size_t)(count + 1));
    for (int i = 0; i < blocks->edge_count; i++)
        if (!add_neighbour(arena, &graph[edge[2 * i]], edge[2 * i + 1]) ||
            !add_neighbour(arena, &graph[edge[2 * i + 1]], edge[2 * i]))
            return NULL;
    return graph;
}

/* Notes what waits for what. Returns false when memory ran out. */
static bool list_late(pinch_arena *arena, const pinch_block_graph *blocks, buckets *b)
{
    int *next = b->late_start = PINCH_ARENA_ARRAY(arena, int, blocks->early + 2);
    b->awaited = PINCH_ARENA_ARRAY(arena, int, blocks->count + 1);
    b->late = PINCH_ARENA_ARRAY(arena, int, blocks->edge_count + 1);
    if (arena->failed) return false;
    memset(next, 0, sizeof *next * (size_t)(blocks->early + 2));
    memset(b->awaited, 0, sizeof *b->awaited * (size_t)(blocks->count + 1));
    for (int pass = 0; pass < 2; pass++) { /* counts, then fills in: late_start[k + 1] goes up to where k + 1 begins */
        for (int i = 0; i < blocks->edge_count; i++) {
            int low = blocks->edge[2 * i], high = blocks->edge[2 * i + 1];
            if (low > high) {
                high = low;
                low = blocks->edge[2 * i + 1];
            }
            if (low >= blocks->early || high < blocks->early) continue;
            if (pass == 0) {
                next[low + 2]++;
                b->awaited[high]++;
            } else {
                b->late[next[low + 1]++] = high;
            }
        }
        for (int k = 0; k < blocks->early && pass == 0; k++) next[k + 2] += next[k + 1];
    }
    return true;
}

/* Returns false when memory ran out; `products` are those of the elimination, which stops above `most`. */
static bool least_degree(pinch_arena *arena, neighbours *graph, const pinch_block_graph *blocks, double most,
                         pinch_block_order *o, double *products)
{
    int count = blocks->count;
    buckets b = {.head = PINCH_ARENA_ARRAY(arena, int, count + 1),
                 .next = PINCH_ARENA_ARRAY(arena, int, count + 1),
                 .previous = PINCH_ARENA_ARRAY(arena, int, count + 1),
                 .lowest = count};
    int *scratch = PINCH_ARENA_ARRAY(arena, int, count + 2); /* what is left out is written first */
    *products = 0;
    if (arena->failed || !list_late(arena, blocks, &b)) return false;
    for (int d = 0; d <= count; d++) b.head[d] = -1;
    for (int node = count - 1; node >= 0; node--)
        if (b.awaited[node] == 0) link_node(&b, node, graph[node].count);
    for (int k = 0; k < count && *products <= most; k++) {
        while (b.head[b.lowest] < 0) b.lowest++;
        int node = b.head[b.lowest];
        *products += (double)b.lowest * (b.lowest + 1);
        unlink_node(&b, node, b.lowest);
        o->order[k] = node;
        o->place[node] = k;
        if (!eliminate(arena, graph, node, &b, scratch)) return false;
        if (node < blocks->early) release_late(graph, node, &b);
    }
    return true;
}

/* Orders by levels, breadth first and back (Cuthill and McKee, "Reducing the bandwidth of sparse symmetric matrices",
 * 1969, less the sorting). */
static void by_levels(const neighbours *graph, int count, pinch_block_order *o)
{
    int reached = 0;
    for (int node = 0; node < count; node++) o->place[node] = -1;
    for (int seed = 0, next = 0; seed < count; seed++) {
        if (o->place[seed] < 0) {
            o->place[seed] = 0;
            o->order[count - 1 - reached++] = seed;
        }
        for (; next < reached; next++) {
            const neighbours *n = &graph[o->order[count - 1 - next]];
            for (int i = 0; i < n->count; i++) {
                if (o->place[n->node[i]] >= 0) continue;
                o->place[n->node[i]] = 0;
                o->order[count - 1 - reached++] = n->node[i];
            }
        }
    }
    for (int k = 0; k < count; k++) o->place[o->order[k]] = k;
}

enum { LARGE = 200 }; /* nodes; what is smaller lies close together in any case, and is soon ordered */

/* ---- memory ---- */

/* Returns where the arrays begin in a room, in ints: place, start, later, visit, behind edges and order. */
static size_t lay_out(const pinch_block_graph *g, int entries, bool visit, size_t first[5])
{
    size_t n = (size_t)g->count;
    first[0] = 2 * (size_t)g->edge_count;
    first[1] = first[0] + n;
    first[2] = first[1] + n;
    first[3] = first[2] + n + 1;
    first[4] = first[3] + (size_t)entries;
    return first[4] + (visit ? n : 0);
}

static void copy(int *to, const int *from, size_t count)
{
    if (count > 0) memcpy(to, from, sizeof *to * count);
}

/* Remembers an order. Without memory it is not remembered. */
static void remember(const pinch_block_graph *g, const pinch_block_order *o, double products,
                     pinch_block_order_memory *memory)
{
    size_t first[5], n = (size_t)g->count, needed = lay_out(g, o->entries, o->visit != NULL, first);
    memory->graph.count = 0;
    if (needed > memory->held) {
        free(memory->room);
        memory->held = needed + needed / 2;
        memory->room = malloc(sizeof *memory->room * memory->held);
        if (!memory->room) {
            memory->held = 0;
            return;
        }
    }
    int *room = memory->room;
    memory->graph = *g;
    memory->graph.edge = room; /* the caller's will not stay */
    memory->products = products;
    memory->order = (pinch_block_order){.order = room + first[0],
                                        .place = room + first[1],
                                        .start = room + first[2],
                                        .later = room + first[3],
                                        .visit = o->visit ? room + first[4] : NULL,
                                        .entries = o->entries,
                                        .without_fill = o->without_fill};
    copy(room, g->edge, 2 * (size_t)g->edge_count);
    copy(memory->order.order, o->order, n);
    copy(memory->order.place, o->place, n);
    copy(memory->order.start, o->start, n + 1);
    copy(memory->order.later, o->later, (size_t)o->entries);
    if (o->visit) copy(memory->order.visit, o->visit, n);
}

/* Is this the graph that is remembered, and would its order be the same with this limit? */
static bool is_remembered(const pinch_block_graph *g, double limit, const pinch_block_order_memory *memory)
{
    const pinch_block_graph *m = &memory->graph;
    if (m->count != g->count || m->early != g->early || m->edge_count != g->edge_count) return false;
    if (memory->order.without_fill != (memory->products > limit)) return false;
    return memcmp(memory->room, g->edge, sizeof *memory->room * 2 * (size_t)g->edge_count) == 0;
}

void pinch_block_order_forget(pinch_block_order_memory *memory)
{
    free(memory->room);
    memset(memory, 0, sizeof *memory);
}

/* The order of a single block, as that of a body which nothing else that moves touches. Returns false when memory ran
 * out. */
static bool order_one(pinch_arena *arena, double limit, pinch_block_order *o)
{
    int *zeros = PINCH_ARENA_ARRAY(arena, int, 4);
    if (!zeros) return false;
    memset(zeros, 0, 4 * sizeof *zeros);
    *o = (pinch_block_order){.order = zeros, .place = zeros, .start = zeros, .later = zeros + 2};
    o->without_fill = 0 > limit;
    return true;
}

bool pinch_block_order_make(pinch_arena *arena, const pinch_block_graph *blocks, double limit,
                            pinch_block_order_memory *memory, pinch_block_order *o)
{
    if (blocks->count == 1 && blocks->edge_count == 0) return order_one(arena, limit, o);
    double products;
    int count = blocks->count;
    if (count < LARGE) memory = NULL;
    if (memory && is_remembered(blocks, limit, memory)) {
        *o = memory->order;
        return true;
    }
    o->order = PINCH_ARENA_ARRAY(arena, int, count + 1);
    o->place = PINCH_ARENA_ARRAY(arena, int, count + 1);
    o->start = PINCH_ARENA_ARRAY(arena, int, count + 1);
    o->visit = count >= LARGE ? PINCH_ARENA_ARRAY(arena, int, count + 1) : NULL;
    if (arena->failed) return false;
    pinch_arena_mark mark = pinch_arena_here(arena);
    neighbours *graph = read_graph(arena, blocks);
    if (!graph || !least_degree(arena, graph, blocks, limit, o, &products)) return false;
    o->without_fill = products > limit;
    if (o->without_fill) {
        pinch_arena_rewind(arena, &mark);
        if (!(graph = read_graph(arena, blocks))) return false;
        by_levels(graph, count, o);
        o->visit = NULL;
    } else if (o->visit && !follow_tree(arena, graph, count, o)) {
        return false;
    }
    if (!collect(arena, &mark, graph, count, o)) return false;
    if (memory) remember(blocks, o, products, memory);
    return true;
}
