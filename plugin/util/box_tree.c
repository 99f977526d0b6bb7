#include "util/box_tree.h"

#include <math.h>
#include <stdlib.h>

enum { LEAF = 4 /* items at most */, DEEP = 40 /* levels, from which on halves are equal */ };

void pinch_box_tree_free(pinch_box_tree *tree)
{
    free(tree->items.items);
    free(tree->nodes.items);
}

size_t pinch_box_tree_bytes(const pinch_box_tree *tree)
{
    return PINCH_LIST_BYTES(tree->items) + PINCH_LIST_BYTES(tree->nodes);
}

/* ---- building ---- */

static double middle(const pinch_box *box, int axis)
{
    return 0.5 * box->low[axis] + 0.5 * box->high[axis];
}

static void include(pinch_box *all, const double low[3], const double high[3])
{
    for (int k = 0; k < 3; k++) {
        all->low[k] = fmin(all->low[k], low[k]);
        all->high[k] = fmax(all->high[k], high[k]);
    }
}

static const pinch_box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static pinch_box box_of(const pinch_tree_item *items, int count)
{
    pinch_box all = nothing;
    for (int k = 0; k < count; k++) include(&all, items[k].box.low, items[k].box.high);
    return all;
}

/* Puts those items first whose middle is below half of the longest side that the middles span. Returns how many. */
static int split(pinch_tree_item *items, int count)
{
    pinch_box middles = nothing;
    int axis = 0, below = 0;
    for (int i = 0; i < count; i++) {
        const double at[3] = {middle(&items[i].box, 0), middle(&items[i].box, 1), middle(&items[i].box, 2)};
        include(&middles, at, at);
    }
    for (int k = 1; k < 3; k++)
        if (middles.high[k] - middles.low[k] > middles.high[axis] - middles.low[axis]) axis = k;
    double half = middle(&middles, axis);
    for (int i = 0; i < count; i++) {
        if (middle(&items[i].box, axis) >= half) continue;
        pinch_tree_item moved = items[i];
        items[i] = items[below];
        items[below++] = moved;
    }
    return below;
}

/* The halves of a level have as many items as it has at most, so that levels below DEEP are as many as the bits of a
 * number: the calls do not nest deeply, wherever the boxes lie. */
static bool build_below(pinch_box_tree *tree, pinch_range items, int depth)
{
    pinch_tree_item *own = tree->items.items + items.first;
    int node = tree->nodes.count, below;
    if (!PINCH_RESERVE(tree->nodes, node + 1)) return false;
    tree->nodes.count++;
    tree->nodes.items[node] = (pinch_tree_node){.box = box_of(own, items.count), .own = {items.first, 0}};
    if (items.count <= LEAF) {
        tree->nodes.items[node].own.count = items.count;
    } else {
        below = depth < DEEP ? split(own, items.count) : items.count / 2;
        if (below == 0 || below == items.count) below = items.count / 2;
        if (!build_below(tree, (pinch_range){items.first, below}, depth + 1) ||
            !build_below(tree, (pinch_range){items.first + below, items.count - below}, depth + 1))
            return false;
    }
    tree->nodes.items[node].beyond = tree->nodes.count;
    return true;
}

bool pinch_box_tree_build(pinch_box_tree *tree)
{
    tree->nodes.count = 0;
    return tree->items.count == 0 || build_below(tree, (pinch_range){0, tree->items.count}, 0);
}

/* ---- looking ---- */

bool pinch_box_tree_find(const pinch_box_tree *tree, const pinch_box *box, int above, pinch_found_boxes *found)
{
    for (int node = 0; node < tree->nodes.count;) {
        const pinch_tree_node *n = &tree->nodes.items[node];
        if (!pinch_boxes_overlap(&n->box, box)) {
            node = n->beyond;
            continue;
        }
        for (int k = n->own.first; k < n->own.first + n->own.count; k++) {
            const pinch_tree_item *item = &tree->items.items[k];
            if (item->name <= above || !pinch_boxes_overlap(&item->box, box)) continue;
            if (!PINCH_RESERVE(found->names, found->names.count + 1)) return false;
            found->names.items[found->names.count++] = item->name;
        }
        node++;
    }
    return true;
}
