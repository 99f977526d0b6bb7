/*
 * A large hull's vertex that is farthest along a direction d. The vertices are halved again and again along the longest
 * side of the box around them. A box bounds what its vertices reach along d, and half of the boxes need no look once a
 * vertex is known that reaches far.
 *
 * The vertex is the one that a look at all of them finds, to the last bit: the first of those whose x.d is most as it
 * is computed. Sums and products of rounded numbers never fall where a term grows. So a box's corner that is farthest
 * along d reaches at least as far as all that it holds also as computed, if it is computed in the same order. Nothing
 * is asked of the faces, which may be level with each other or not quite convex.
 */
#include "hull.h"

#include "support/vec3.h"

#include <stdlib.h>
#include <string.h>

/* The cells of a cube's faces, GRID by GRID each, hold directions that are nearly the same. The vertex that is farthest
 * along a cell's middle is nearly the farthest for all of them. */
enum { GRID = 16, CELLS = 6 * GRID * GRID, LEAST_IN_LEAF = 6 };

typedef struct sort_item {
    double along;
    pinch_hull_corner corner;
} sort_item;

static int by_place(const void *a, const void *b)
{
    const sort_item *x = a, *y = b;
    if (x->along != y->along) return x->along < y->along ? -1 : 1;
    return x->corner.index < y->corner.index ? -1 : x->corner.index > y->corner.index;
}

static void surround(pinch_hull_node *node, const sort_item *items)
{
    node->lowest = items[node->first].corner.index;
    for (int i = 0; i < 3; i++) node->ends[i][0] = node->ends[i][1] = items[node->first].corner.x[i];
    for (unsigned k = node->first; k < node->last; k++) {
        const pinch_hull_corner *corner = &items[k].corner;
        if (corner->index < node->lowest) node->lowest = corner->index;
        for (int i = 0; i < 3; i++) {
            if (corner->x[i] < node->ends[i][0]) node->ends[i][0] = corner->x[i];
            if (corner->x[i] > node->ends[i][1]) node->ends[i][1] = corner->x[i];
        }
    }
}

static void sort_along_longest(const pinch_hull_node *node, sort_item *items)
{
    double longest = -1;
    int axis = 0;
    for (int i = 0; i < 3; i++) {
        double side = node->ends[i][1] - node->ends[i][0];
        if (!(side > longest)) continue;
        longest = side;
        axis = i;
    }
    for (unsigned k = node->first; k < node->last; k++) items[k].along = items[k].corner.x[axis];
    qsort(items + node->first, node->last - node->first, sizeof *items, by_place);
}

static void build(unsigned leaves, unsigned points, sort_item *items, pinch_hull_node *nodes)
{
    nodes[0].first = 0;
    nodes[0].last = points;
    for (unsigned k = 0; k < 2 * leaves - 1; k++) {
        pinch_hull_node *node = &nodes[k];
        surround(node, items);
        if (k + 1 >= leaves) continue;
        sort_along_longest(node, items);
        unsigned middle = node->first + (node->last - node->first) / 2;
        nodes[2 * k + 1].first = node->first;
        nodes[2 * k + 1].last = nodes[2 * k + 2].first = middle;
        nodes[2 * k + 2].last = node->last;
    }
}

static int step_of(double u)
{
    return u > -1 && u < 1 ? (int)((u + 1) * (GRID / 2)) : u >= 1 ? GRID - 1 : 0;
}

static int cell_of(const double *d)
{
    int axis = pinch_v3_main_axis(d);
    double scale = 1 / fabs(d[axis]);
    int u = step_of(scale * d[(axis + 1) % 3]), v = step_of(scale * d[(axis + 2) % 3]);
    return ((2 * axis + (d[axis] < 0)) * GRID + u) * GRID + v;
}

static void middle_of_cell(int cell, double *d)
{
    int axis = cell / (2 * GRID * GRID), u = cell / GRID % GRID, v = cell % GRID;
    d[axis] = cell / (GRID * GRID) % 2 ? -1 : 1;
    d[(axis + 1) % 3] = (2 * u + 1.0) / GRID - 1;
    d[(axis + 2) % 3] = (2 * v + 1.0) / GRID - 1;
}

/* What is known of the farthest vertex so far. */
typedef struct farthest {
    double most;
    unsigned vertex;
} farthest;

static inline bool may_hold(const pinch_hull_node *node, double bound, const farthest *known)
{
    return bound > known->most || (bound == known->most && node->lowest < known->vertex);
}

static void look_at_leaf(const pinch_hull_tree *tree, const pinch_hull_node *leaf, const double *d, farthest *known)
{
    const pinch_hull_corner *corner = tree->corners + leaf->first, *end = tree->corners + leaf->last;
    for (; corner < end; corner++) {
        double along = corner->x[0] * d[0] + corner->x[1] * d[1] + corner->x[2] * d[2];
        if (!(along > known->most || (along == known->most && corner->index < known->vertex))) continue;
        known->most = along;
        known->vertex = corner->index;
    }
}

/* The search starts with a vertex whose reach it has to beat. */
static unsigned farthest_of(const pinch_hull *hull, const double *d, unsigned start)
{
    enum { DEEPEST = 33 }; /* a level has two nodes in waiting at most, and there are no more levels than bits */
    const pinch_hull_tree *tree = &hull->tree;
    const double *x = hull->convex.points + 3 * start;
    const int far[3] = {d[0] >= 0, d[1] >= 0, d[2] >= 0};
    farthest known = {x[0] * d[0] + x[1] * d[1] + x[2] * d[2], start};
    struct {
        double bound;
        unsigned node;
    } waiting[DEEPEST];
    int count = 0;
    for (unsigned at = 0;;) {
        if (at + 1 >= tree->leaves) {
            look_at_leaf(tree, &tree->nodes[at], d, &known);
        } else {
            const pinch_hull_node *one = &tree->nodes[2 * at + 1], *two = one + 1;
            double first = one->ends[0][far[0]] * d[0] + one->ends[1][far[1]] * d[1] + one->ends[2][far[2]] * d[2];
            double second = two->ends[0][far[0]] * d[0] + two->ends[1][far[1]] * d[1] + two->ends[2][far[2]] * d[2];
            bool is_first = may_hold(one, first, &known), is_second = may_hold(two, second, &known);
            unsigned nearer = 2 * at + (first >= second ? 1 : 2), other = 4 * at + 3 - nearer;
            if (is_first && is_second) {
                waiting[count].bound = first >= second ? second : first;
                waiting[count++].node = other;
            }
            if (is_first || is_second) {
                at = is_first && is_second ? nearer : 2 * at + (is_first ? 1 : 2);
                continue;
            }
        }
        do {
            if (count == 0) return known.vertex;
            count--;
        } while (!may_hold(&tree->nodes[waiting[count].node], waiting[count].bound, &known));
        at = waiting[count].node;
    }
}

bool pinch_hull_build_tree(pinch_hull *hull)
{
    const unsigned points = hull->convex.point_count;
    unsigned leaves = 1;
    while (points / (2 * leaves) >= LEAST_IN_LEAF) leaves *= 2;
    size_t node_bytes = (2 * (size_t)leaves - 1) * sizeof(pinch_hull_node), corner_bytes;
    corner_bytes = points * sizeof(pinch_hull_corner);
    char *memory = malloc(node_bytes + corner_bytes + CELLS * sizeof(unsigned));
    sort_item *items = malloc(points * sizeof *items);
    if (!memory || !items) {
        free(memory);
        free(items);
        return false;
    }
    pinch_hull_node *nodes = (pinch_hull_node *)memory;
    pinch_hull_corner *corners = (pinch_hull_corner *)(memory + node_bytes);
    unsigned *near = (unsigned *)(memory + node_bytes + corner_bytes);
    for (unsigned k = 0; k < points; k++) {
        pinch_v3_copy(items[k].corner.x, hull->convex.points + 3 * (size_t)k);
        items[k].corner.index = k;
    }
    build(leaves, points, items, nodes);
    for (unsigned k = 0; k < points; k++) corners[k] = items[k].corner;
    free(items);
    hull->tree = (pinch_hull_tree){memory, leaves, nodes, corners, NULL};
    for (int cell = 0; cell < CELLS; cell++) {
        double d[3];
        middle_of_cell(cell, d);
        near[cell] = farthest_of(hull, d, cell > 0 ? near[cell - 1] : 0);
    }
    hull->tree.near = near;
    return true;
}

void pinch_hull_free_tree(pinch_hull *hull)
{
    free(hull->tree.memory);
}

unsigned pinch_hull_near_vertex(const pinch_hull *hull, const double d[3])
{
    return hull->tree.near[cell_of(d)];
}

unsigned pinch_hull_tree_vertex(const pinch_hull *hull, const double d[3])
{
    return farthest_of(hull, d, pinch_hull_near_vertex(hull, d));
}
