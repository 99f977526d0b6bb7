/*
 * The order of least degree in which the nodes of a graph are eliminated, and the fill that it leaves (the minimum
 * degree algorithm; Tinney and Walker, "Direct solutions of sparse network equations by optimally ordered triangular
 * factorization", 1967). Ties go to the smaller node: the same graph is always ordered in the same way. In large graphs
 * the nodes then follow the tree of their elimination, so that what is worked on together lies together.
 */
#ifndef PINCH_SUPPORT_BLOCK_ORDER_H
#define PINCH_SUPPORT_BLOCK_ORDER_H

#include "support/arena.h"

typedef struct pinch_block_order {
    int *order;  /* node eliminated k-th */
    int *place;  /* its inverse */
    int *visit;  /* the places in another order that does as well, in which neighbours depend on each other less; NULL:
                  * the same */
    int *start;  /* per k, count + 1: its neighbours then, */
    int *later;  /* as places, ascending */
    int entries; /* of later */
    bool without_fill;
} pinch_block_order;

typedef struct pinch_block_graph {
    int count; /* nodes */
    int early; /* a node from here on is eliminated only after all its neighbours below, in the graph as it is given */
    int edge_count;
    const int *edge; /* 2 edge_count: pairs of different nodes, in any order, repeated or not */
} pinch_block_graph;

/*
 * What is remembered of the last large graph: one that comes again, as that of a pile does in most steps, need not be
 * ordered again. All zero at first.
 */
typedef struct pinch_block_order_memory {
    int *room;   /* the graph's edges, and behind them the order */
    size_t held; /* of room */
    pinch_block_graph graph;
    pinch_block_order order; /* in room */
    double products;         /* what its elimination touches; without fill, more than that */
} pinch_block_order_memory;

void pinch_block_order_forget(pinch_block_order_memory *memory);

/*
 * Where elimination would touch more than `limit`
 * (INFINITY: none) pairs of neighbours, a node counting as its own, the order is one by levels from the first node,
 * those farthest away first, and `later` has the neighbours in the graph alone. memory may be NULL; otherwise the order
 * may be in there, and stays until the next one is made. Returns false when memory ran out.
 */
bool pinch_block_order_make(pinch_arena *arena, const pinch_block_graph *graph, double limit,
                            pinch_block_order_memory *memory, pinch_block_order *order);

#endif
