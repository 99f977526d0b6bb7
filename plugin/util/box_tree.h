/*
 * A tree over boxes along the axes, which finds those that overlap another one. It is built at once and does not
 * change; the order of what it finds means nothing.
 */
#ifndef PINCH_UTIL_BOX_TREE_H
#define PINCH_UTIL_BOX_TREE_H

#include "util/list.h"

typedef struct pinch_box {
    double low[3], high[3];
} pinch_box;

/* As ODE tells it: boxes that touch overlap, and so do those with a side that is not a number. */
static inline bool pinch_boxes_overlap(const pinch_box *a, const pinch_box *b)
{
    return !((a->low[0] > b->high[0]) | (a->high[0] < b->low[0]) | (a->low[1] > b->high[1]) | (a->high[1] < b->low[1]) |
             (a->low[2] > b->high[2]) | (a->high[2] < b->low[2]));
}

typedef struct pinch_tree_item {
    pinch_box box;
    int name; /* what is found */
} pinch_tree_item;

typedef struct pinch_tree_node {
    pinch_box box;   /* of all items below */
    pinch_range own; /* items of a leaf; none in other nodes, whose first child follows them */
    int beyond;      /* the next node that is not below this one */
} pinch_tree_node;

/* Everything starts as 0. */
typedef struct pinch_box_tree {
    PINCH_LIST(pinch_tree_item) items;
    PINCH_LIST(pinch_tree_node) nodes;
} pinch_box_tree;

typedef struct pinch_found_boxes {
    PINCH_LIST(int) names;
} pinch_found_boxes;

void pinch_box_tree_free(pinch_box_tree *tree);
size_t pinch_box_tree_bytes(const pinch_box_tree *tree);

/* Builds the tree over its items, which are put into another order. Their sides must be finite. Returns false when
 * memory runs out. */
bool pinch_box_tree_build(pinch_box_tree *tree);

/* Appends the names of the items whose boxes overlap the box, of those that are larger than `above`. Returns false when
 * memory runs out. */
bool pinch_box_tree_find(const pinch_box_tree *tree, const pinch_box *box, int above, pinch_found_boxes *found);

#endif
