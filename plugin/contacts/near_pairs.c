#include "contacts/near_pairs.h"

#include "util/box_tree.h"
#include "util/prefetch.h"

#include "support/await.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

/* A reach goes beyond its box by a part of the box's shortest side, and by some steps of what its sides have moved,
 * where that is no more than its longest side. What is faster, or was put elsewhere, is looked for in each step: its
 * reach would have too many neighbours, and one that has come to rest would never leave it again. */
static const double BEYOND = 0.1, AHEAD = 8;
enum { GRAIN = 256 /* geoms that a thread takes at a time */ };
/* Of ODE's geoms, listing reads the first line, another thread's for the most part, and what follows three of them. */
enum { AHEAD_IN_LIST = 16, LISTED_BYTES = 64, AHEAD_IN_GEOMS = 8, GEOM_BYTES = 192 };

/* What is kept of a geom. One that is destroyed is known by its address alone until the next call. */
typedef struct near_geom {
    dGeomID geom; /* NULL: it is forgotten, and goes with the next call */
    dBodyID body;
    unsigned long category, collide;
    pinch_box reach;
    bool is_space;
    bool endless; /* in some direction, as a plane is: not in the tree */
    bool strays;  /* the tree does not have its reach */
    bool left;    /* its old reach: its neighbours are to be found */
} near_geom;

/* What a step reads of it. */
typedef struct near_box {
    pinch_box box;
    dGeomID geom;
    bool is_enabled, is_space;
} near_box;

typedef struct neighbours {
    PINCH_LIST(int) first; /* of each geom and, at the end, how many there are in all */
    PINCH_LIST(int) later; /* the neighbours of each geom that come after it, in their order */
} neighbours;

typedef struct near_link {
    int one, later;
} near_link;

struct pinch_near_space {
    dSpaceID space;
    unsigned long call;          /* the last one */
    PINCH_LIST(near_geom) geoms; /* in the order in which they were first listed */
    PINCH_LIST(near_box) boxes;  /* of the geoms */
    PINCH_LIST(dGeomID) listed;  /* as ODE listed them the last time, from the end */
    bool in_order;               /* which was the order of the geoms */
    bool forgot;                 /* some of the geoms are forgotten */
    atomic_int seen;          /* so many of them, from the end, are listed as the last time; all: no more are awaited */
    atomic_bool other;        /* they are not listed as the last time */
    pinch_item_index index;   /* of geoms */
    pinch_box_tree tree;      /* over the reaches of most geoms */
    PINCH_LIST(int) strays;   /* the others */
    neighbours known, merged; /* merged: for the next ones while they are made */
    PINCH_LIST(near_link) links;        /* new ones */
    pinch_found_boxes found;            /* of one geom */
    atomic_int left;                    /* geoms that have left their reaches */
    atomic_bool has_spaces, has_fields; /* spaces, height fields among the geoms */
};

static void free_space(pinch_near_space *s)
{
    free(s->geoms.items);
    free(s->boxes.items);
    free(s->listed.items);
    pinch_item_index_free(&s->index);
    pinch_box_tree_free(&s->tree);
    free(s->strays.items);
    free(s->known.first.items);
    free(s->known.later.items);
    free(s->merged.first.items);
    free(s->merged.later.items);
    free(s->links.items);
    free(s->found.names.items);
    free(s);
}

static size_t space_bytes(const pinch_near_space *s)
{
    return sizeof *s + PINCH_LIST_BYTES(s->geoms) + PINCH_LIST_BYTES(s->boxes) + PINCH_LIST_BYTES(s->listed) +
           pinch_item_index_bytes(&s->index) + pinch_box_tree_bytes(&s->tree) + PINCH_LIST_BYTES(s->strays) +
           PINCH_LIST_BYTES(s->known.first) + PINCH_LIST_BYTES(s->known.later) + PINCH_LIST_BYTES(s->merged.first) +
           PINCH_LIST_BYTES(s->merged.later) + PINCH_LIST_BYTES(s->links) + PINCH_LIST_BYTES(s->found.names);
}

void pinch_near_pairs_free(pinch_near_pairs *near)
{
    for (int k = 0; k < near->spaces.count; k++) free_space(near->spaces.items[k]);
    free(near->spaces.items);
    free(near->pairs.items);
}

size_t pinch_near_pairs_bytes(const pinch_near_pairs *near)
{
    size_t bytes = PINCH_LIST_BYTES(near->pairs) + PINCH_LIST_BYTES(near->spaces);
    for (int k = 0; k < near->spaces.count; k++) bytes += space_bytes(near->spaces.items[k]);
    return bytes;
}

/* ---- which geoms there are ---- */

static pinch_item_keys keys_of(const pinch_near_space *s)
{
    return PINCH_ITEM_KEYS(s->geoms, near_geom, geom);
}

static near_geom new_geom(dGeomID geom)
{
    return (near_geom){.geom = geom, .left = true};
}

static const near_box nowhere = {.box = {{NAN, NAN, NAN}, {NAN, NAN, NAN}}};

/* Keeps the geoms that have left their reaches, in their order. Neighbours and tree hold the places of all, and are
 * made anew by the next search. */
static bool keep_those_that_left(pinch_near_space *s)
{
    int kept = 0;
    for (int k = 0; k < s->geoms.count; k++) {
        if (!s->geoms.items[k].left) continue;
        s->geoms.items[kept] = s->geoms.items[k];
        s->boxes.items[kept++] = s->boxes.items[k];
    }
    s->geoms.count = s->boxes.count = kept;
    s->tree.items.count = s->strays.count = 0;
    s->forgot = false;
    return pinch_item_index_rebuild(&s->index, keys_of(s), kept);
}

/* Keeps the geoms that are still listed, and appends new ones. Every geom has left its reach then. */
static bool list_anew(pinch_near_space *s)
{
    int known = s->geoms.count, all = s->listed.count;
    for (int k = 0; k < known; k++) s->geoms.items[k].left = s->geoms.items[k].strays = false; /* until it is found */
    if (!PINCH_RESERVE(s->geoms, known + all) || !PINCH_RESERVE(s->boxes, known + all)) return false;
    for (int k = 0; k < all; k++) {
        int place = pinch_item_index_get(&s->index, keys_of(s), &s->listed.items[k]);
        if (place >= 0) {
            s->geoms.items[place].left = true;
        } else {
            s->geoms.items[s->geoms.count] = new_geom(s->listed.items[k]);
            s->boxes.items[s->geoms.count++] = nowhere;
        }
    }
    return keep_those_that_left(s);
}

/* Tells whether all that is listed is known, and nothing else is. */
static bool has_the_listed(const pinch_near_space *s)
{
    if (s->listed.count != s->geoms.count) return false;
    for (int k = 0; k < s->listed.count; k++)
        if (pinch_item_index_get(&s->index, keys_of(s), &s->listed.items[k]) < 0) return false;
    return true;
}

/* Lists the geoms, and tells as it goes how many are as they were the last time. Sets `other` where not all are. */
static void list_geoms(pinch_near_space *s)
{
    enum { AT_A_TIME = 64 };
    int count = s->listed.count;
    bool same = !atomic_load(&s->other);
    for (int k = 0; k < count; k++) { /* ODE steps on from the one asked for before, by a pointer in it */
        int ahead = count - 1 - k - AHEAD_IN_LIST;
        if (same && ahead >= 0) pinch_prefetch(s->listed.items[ahead], LISTED_BYTES);
        dGeomID geom = dSpaceGetGeom(s->space, k), *place = &s->listed.items[count - 1 - k];
        same = same && *place == geom;
        *place = geom;
        if (same && k % AT_A_TIME == 0) pinch_say(&s->seen, k);
    }
    if (!same) atomic_store(&s->other, true);
    pinch_say(&s->seen, count);
}

/* Begins with listing. Returns false when memory runs out. */
static bool begin_list(pinch_near_space *s)
{
    int count = dSpaceGetNumGeoms(s->space);
    if (!PINCH_RESERVE(s->listed, count)) return false;
    atomic_store(&s->other, s->forgot || count != s->listed.count);
    atomic_store(&s->seen, 0);
    s->listed.count = count;
    return true;
}

/* Ends it. Returns false when memory runs out. */
static bool end_list(pinch_near_space *s)
{
    if (!atomic_load(&s->other)) return true;
    if (!has_the_listed(s) && !list_anew(s)) return false;
    s->in_order = true;
    for (int k = 0; k < s->geoms.count && s->in_order; k++) s->in_order = s->geoms.items[k].geom == s->listed.items[k];
    return true;
}

static void drop_forgotten(pinch_near_space *s)
{
    if (!s->forgot) return;
    for (int k = 0; k < s->geoms.count; k++) {
        s->geoms.items[k].left = s->geoms.items[k].geom != NULL;
        s->geoms.items[k].strays = false;
    }
    (void)keep_those_that_left(s); /* the index has held as many */
    s->listed.count = 0;
}

void pinch_near_drop_forgotten(pinch_near_pairs *near)
{
    for (int k = 0; k < near->spaces.count; k++) drop_forgotten(near->spaces.items[k]);
}

/* A forgotten geom stays where the index has put it, under a key that nobody looks for: to index all others anew for
 * each would take the square of their number. */
static void forget_in(pinch_near_space *s, dGeomID geom)
{
    int place = pinch_item_index_get(&s->index, keys_of(s), &geom);
    if (place < 0) return;
    s->geoms.items[place].geom = s->boxes.items[place].geom = NULL;
    s->forgot = true;
}

void pinch_near_forget(pinch_near_pairs *near, dGeomID geom)
{
    int kept = 0;
    for (int k = 0; k < near->spaces.count; k++) {
        pinch_near_space *s = near->spaces.items[k];
        if ((dGeomID)s->space == geom) {
            free_space(s);
            continue;
        }
        forget_in(s, geom);
        near->spaces.items[kept++] = s;
    }
    near->spaces.count = kept;
}

int pinch_near_count(const pinch_near_pairs *near, int space)
{
    return near->spaces.items[space]->geoms.count;
}

dGeomID pinch_near_geom(const pinch_near_pairs *near, int space, int place)
{
    return near->spaces.items[space]->geoms.items[place].geom;
}

/* ---- where they are ---- */

static bool is_inside(const pinch_box *box, const pinch_box *reach)
{
    bool inside = true;
    for (int k = 0; k < 3; k++) inside &= (box->low[k] >= reach->low[k]) & (box->high[k] <= reach->high[k]);
    return inside;
}

/* Sets the reach of a box which was at `before` in the last step; NaN: nobody knows. */
static void set_reach(near_geom *g, const pinch_box *box, const pinch_box *before)
{
    double shortest = INFINITY, longest = 0;
    g->endless = false;
    for (int k = 0; k < 3; k++) {
        double side = box->high[k] - box->low[k];
        g->endless = g->endless || !isfinite(side);
        shortest = fmin(shortest, side);
        longest = fmax(longest, side);
    }
    for (int k = 0; k < 3; k++) { /* fmax takes the number of a number and NaN */
        double down = AHEAD * fmax(before->low[k] - box->low[k], 0),
               up = AHEAD * fmax(box->high[k] - before->high[k], 0);
        g->reach.low[k] = box->low[k] - BEYOND * shortest - (down <= longest ? down : 0);
        g->reach.high[k] = box->high[k] + BEYOND * shortest + (up <= longest ? up : 0);
    }
    if (g->endless) g->reach = *box;
}

static void bring_up_to_date(near_geom *g, near_box *b)
{
    dReal side[6];
    dGeomGetAABB(g->geom, side);
    const pinch_box box = {{side[0], side[2], side[4]}, {side[1], side[3], side[5]}};
    near_geom now = {.geom = g->geom,
                     .body = dGeomGetBody(g->geom),
                     .category = dGeomGetCategoryBits(g->geom),
                     .collide = dGeomGetCollideBits(g->geom),
                     .is_space = dGeomIsSpace(g->geom) != 0,
                     .strays = g->strays};
    g->left = g->left || now.body != g->body || now.category != g->category || now.collide != g->collide ||
              now.is_space != g->is_space || !is_inside(&box, &g->reach);
    if (g->left) {
        set_reach(&now, &box, &b->box);
        now.left = true;
        *g = now;
    }
    *b = (near_box){box, g->geom, dGeomIsEnabled(g->geom) != 0, now.is_space};
}

static void bring_some_up_to_date(void *context, int worker, int first, int end)
{
    pinch_near_space *s = context;
    int left = 0;
    bool spaces = false, fields = false;
    (void)worker;
    for (int k = first; k < end; k++) {
        if (k + AHEAD_IN_GEOMS < end) pinch_prefetch_to_write(s->geoms.items[k + AHEAD_IN_GEOMS].geom, GEOM_BYTES);
        bring_up_to_date(&s->geoms.items[k], &s->boxes.items[k]);
        left += s->geoms.items[k].left;
        spaces = spaces || s->geoms.items[k].is_space;
        fields = fields || dGeomGetClass(s->geoms.items[k].geom) == dHeightfieldClass;
    }
    if (spaces) atomic_store(&s->has_spaces, true);
    if (fields) atomic_store(&s->has_fields, true);
    if (left > 0) atomic_fetch_add(&s->left, left);
}

/* The same beside listing, which one thread does: what is listed as the last time is still there. */
static void bring_listed_up_to_date(void *context, int worker, int first, int end)
{
    pinch_near_space *s = context;
    int count = s->geoms.count;
    if (worker == 0 && atomic_load(&s->seen) < count) list_geoms(s);
    pinch_await(&s->seen, count - first);
    if (!atomic_load(&s->other)) bring_some_up_to_date(s, worker, first, end);
}

/* Lists the geoms, and finds out where they are. Returns false when memory runs out. */
static bool look_where_they_are(pinch_near_space *s, pinch_workers *workers)
{
    if (!begin_list(s)) return false;
    atomic_store(&s->left, 0);
    atomic_store(&s->has_spaces, false);
    atomic_store(&s->has_fields, false);
    if (s->in_order && !atomic_load(&s->other) && s->listed.count > 0) {
        pinch_workers_run(workers, bring_listed_up_to_date, s, s->geoms.count, GRAIN);
        if (!atomic_load(&s->other)) return true;
    } else {
        list_geoms(s);
    }
    if (!end_list(s)) return false;
    atomic_store(&s->left, 0);
    pinch_workers_run(workers, bring_some_up_to_date, s, s->geoms.count, GRAIN);
    return true;
}

/* ---- who is a neighbour of whom ---- */

static int by_number(const void *a, const void *b)
{
    int one = *(const int *)a, other = *(const int *)b;
    return (one > other) - (one < other);
}

static int by_place(const void *a, const void *b)
{
    const near_link *one = a, *other = b;
    int order = by_number(&one->one, &other->one);
    return order != 0 ? order : by_number(&one->later, &other->later);
}

/* Two geoms of one body never collide, nor do those whose bits forbid it. */
static bool may_collide(const near_geom *a, const near_geom *b)
{
    if (a->body == b->body && a->body) return false;
    return (a->category & b->collide) != 0 || (b->category & a->collide) != 0;
}

static bool note_neighbour(pinch_near_space *s, int geom, int other)
{
    const near_geom *a = &s->geoms.items[geom], *b = &s->geoms.items[other];
    if (!pinch_boxes_overlap(&a->reach, &b->reach)) return true;
    if (!PINCH_RESERVE(s->found.names, s->found.names.count + 1)) return false;
    s->found.names.items[s->found.names.count++] = other;
    return true;
}

/* Finds those after `above` whose reach overlaps that of a geom, itself and those that it never collides with among
 * them. What the tree tells of strays is old. */
static bool find_around(pinch_near_space *s, int geom, int above)
{
    const near_geom *g = &s->geoms.items[geom];
    s->found.names.count = 0;
    if (g->endless) {
        for (int k = above + 1; k < s->geoms.count; k++)
            if (!note_neighbour(s, geom, k)) return false;
        return true;
    }
    if (!pinch_box_tree_find(&s->tree, &g->reach, above, &s->found)) return false;
    int kept = 0;
    for (int k = 0; k < s->found.names.count; k++)
        if (!s->geoms.items[s->found.names.items[k]].strays) s->found.names.items[kept++] = s->found.names.items[k];
    s->found.names.count = kept;
    for (int k = 0; k < s->strays.count; k++)
        if (s->strays.items[k] > above && !note_neighbour(s, geom, s->strays.items[k])) return false;
    return true;
}

static bool append(neighbours *n, int geom)
{
    if (!PINCH_RESERVE(n->later, n->later.count + 1)) return false;
    n->later.items[n->later.count++] = geom;
    return true;
}

static bool begin(neighbours *n, int geoms)
{
    if (!PINCH_RESERVE(n->first, geoms + 1)) return false;
    n->first.count = geoms + 1;
    n->later.count = 0;
    return true;
}

/* Finds the neighbours of all geoms by a new tree, in which all are that have an end. */
static bool search_all(pinch_near_space *s)
{
    int count = s->geoms.count;
    s->tree.items.count = s->strays.count = 0;
    if (!PINCH_RESERVE(s->tree.items, count) || !PINCH_RESERVE(s->strays, count) || !begin(&s->known, count))
        return false;
    for (int k = 0; k < count; k++) {
        near_geom *g = &s->geoms.items[k];
        g->strays = g->endless;
        if (g->strays)
            s->strays.items[s->strays.count++] = k;
        else
            s->tree.items.items[s->tree.items.count++] = (pinch_tree_item){g->reach, k};
    }
    if (!pinch_box_tree_build(&s->tree)) return false;
    for (int k = 0; k < count; k++) {
        s->known.first.items[k] = s->known.later.count;
        if (!find_around(s, k, k)) return false;
        if (s->found.names.count > 0) qsort(s->found.names.items, (size_t)s->found.names.count, sizeof(int), by_number);
        for (int i = 0; i < s->found.names.count; i++) {
            int other = s->found.names.items[i];
            if (may_collide(&s->geoms.items[k], &s->geoms.items[other]) && !append(&s->known, other)) return false;
        }
    }
    s->known.first.items[count] = s->known.later.count;
    return true;
}

/* Links geoms that have left their reaches to their neighbours, each pair once. */
static bool link_those_that_left(pinch_near_space *s)
{
    s->links.count = 0;
    for (int k = 0; k < s->geoms.count; k++) {
        if (!s->geoms.items[k].left) continue;
        if (!find_around(s, k, -1) || !PINCH_RESERVE(s->links, s->links.count + s->found.names.count)) return false;
        for (int i = 0; i < s->found.names.count; i++) {
            int other = s->found.names.items[i];
            bool again = other == k || (s->geoms.items[other].left && other < k);
            if (again || !may_collide(&s->geoms.items[k], &s->geoms.items[other])) continue;
            s->links.items[s->links.count++] = k < other ? (near_link){k, other} : (near_link){other, k};
        }
    }
    if (s->links.count > 0) qsort(s->links.items, (size_t)s->links.count, sizeof(near_link), by_place);
    return true;
}

/* Puts the new links among the neighbours, and leaves out those of geoms that have left their reaches. */
static bool merge_links(pinch_near_space *s)
{
    const near_link *link = s->links.items, *end = link + s->links.count;
    if (!begin(&s->merged, s->geoms.count)) return false;
    for (int k = 0; k < s->geoms.count; k++) {
        s->merged.first.items[k] = s->merged.later.count;
        for (int i = s->known.first.items[k]; i < s->known.first.items[k + 1]; i++) {
            int later = s->known.later.items[i];
            if (s->geoms.items[k].left || s->geoms.items[later].left) continue;
            for (; link < end && link->one == k && link->later < later; link++)
                if (!append(&s->merged, link->later)) return false;
            if (!append(&s->merged, later)) return false;
        }
        for (; link < end && link->one == k; link++)
            if (!append(&s->merged, link->later)) return false;
    }
    s->merged.first.items[s->geoms.count] = s->merged.later.count;
    const neighbours swapped = s->known;
    s->known = s->merged;
    s->merged = swapped;
    return true;
}

/* Finds the neighbours of geoms that have left their reaches. The tree is good while it has most of the geoms. */
static bool search_again(pinch_near_space *s)
{
    enum { SOME = 32, PART = 8 };
    int strays = s->strays.count;
    if (!PINCH_RESERVE(s->strays, s->geoms.count)) return false;
    for (int k = 0; k < s->geoms.count; k++) {
        near_geom *g = &s->geoms.items[k];
        if (g->left && !g->strays) s->strays.items[strays++] = k;
        g->strays = g->strays || g->left;
    }
    s->strays.count = strays;
    bool done = strays > SOME + s->geoms.count / PART || s->tree.items.count == 0
                    ? search_all(s)
                    : link_those_that_left(s) && merge_links(s);
    for (int k = 0; k < s->geoms.count; k++) s->geoms.items[k].left = false;
    return done;
}

/* ---- pairs ---- */

void pinch_note_near_pair(void *context, dGeomID a, dGeomID b)
{
    pinch_near_pairs *near = context;
    near->no_memory = near->no_memory || !PINCH_RESERVE(near->pairs, near->pairs.count + 1);
    if (near->no_memory) return;
    near->pairs.items[near->pairs.count++] = (pinch_near_pair){.geom = {a, b}};
    near->with_spaces = near->with_spaces || dGeomIsSpace(a) || dGeomIsSpace(b);
}

bool pinch_near_pairs_from(const pinch_near_space *s, int first, int end, pinch_near_pair_list *to)
{
    for (int k = first; k < end && k < s->geoms.count; k++) {
        const near_box *one = &s->boxes.items[k];
        if (!one->is_enabled) continue;
        for (int i = s->known.first.items[k]; i < s->known.first.items[k + 1]; i++) {
            const near_box *other = &s->boxes.items[s->known.later.items[i]];
            if (!other->is_enabled || !pinch_boxes_overlap(&one->box, &other->box)) continue;
            if (!PINCH_RESERVE(*to, to->count + 1)) return false;
            to->items[to->count++] = (pinch_near_pair){.geom = {one->geom, other->geom}};
        }
    }
    return true;
}

/* Returns what is known of a space, for one that is new in the place of the one that was not asked about for longest.
 * Returns NULL when memory runs out. */
static pinch_near_space *space_of(pinch_near_pairs *near, dSpaceID space)
{
    int count = near->spaces.count, oldest = 0;
    for (int k = 0; k < count; k++) {
        if (near->spaces.items[k]->space == space) return near->spaces.items[k];
        if (near->spaces.items[k]->call < near->spaces.items[oldest]->call) oldest = k;
    }
    if (count < PINCH_NEAR_MOST_SPACES && !PINCH_RESERVE(near->spaces, count + 1)) return NULL;
    pinch_near_space *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->space = space;
    if (count < PINCH_NEAR_MOST_SPACES) {
        near->spaces.items[near->spaces.count++] = s;
    } else {
        free_space(near->spaces.items[oldest]);
        near->spaces.items[oldest] = s;
    }
    return s;
}

pinch_status pinch_near_remember(pinch_near_pairs *near, dSpaceID space, const dGeomID *geoms, int count)
{
    pinch_near_space *s = space_of(near, space);
    if (!s || !PINCH_RESERVE(s->geoms, count) || !PINCH_RESERVE(s->boxes, count)) return PINCH_OUT_OF_MEMORY;
    if (s->geoms.count > 0) return PINCH_INVALID_ARGUMENT;
    for (int k = 0; k < count; k++) {
        if (pinch_item_index_get(&s->index, keys_of(s), &geoms[k]) >= 0) return PINCH_INVALID_ARGUMENT;
        if (!pinch_item_index_add(&s->index, keys_of(s), &geoms[k], k)) return PINCH_OUT_OF_MEMORY;
        s->geoms.items[k] = new_geom(geoms[k]);
        s->boxes.items[k] = nowhere;
        s->geoms.count = s->boxes.count = k + 1;
    }
    return PINCH_OK;
}

static bool find_neighbours(pinch_near_pairs *near, pinch_workers *workers, pinch_near_space *s)
{
    s->call = near->calls;
    if (!look_where_they_are(s, workers)) return false;
    return atomic_load(&s->left) == 0 || search_again(s);
}

bool pinch_find_neighbours(pinch_near_pairs *near, pinch_workers *workers, dSpaceID space,
                           const pinch_near_space **found, int *geoms)
{
    near->calls++;
    near->pairs.count = 0;
    near->with_spaces = near->with_fields = near->no_memory = false;
    *found = NULL;
    /* Quadtree spaces do not list their geoms. */
    if (dSpaceGetClass(space) == dQuadTreeSpaceClass) {
        dSpaceCollide(space, near, pinch_note_near_pair);
        return !near->no_memory;
    }
    pinch_near_space *s = space_of(near, space);
    bool done = s && find_neighbours(near, workers, s);
    if (s && !done)
        s->forgot = false, s->listed.count = s->geoms.count = 0, pinch_item_index_clear(&s->index); /* half done */
    if (!done) return false;
    near->with_spaces = atomic_load(&s->has_spaces);
    near->with_fields = atomic_load(&s->has_fields);
    *found = s;
    *geoms = s->geoms.count;
    return true;
}

bool pinch_find_near_pairs(pinch_near_pairs *near, dSpaceID space)
{
    const pinch_near_space *s;
    int geoms;
    return pinch_find_neighbours(near, NULL, space, &s, &geoms) &&
           (!s || pinch_near_pairs_from(s, 0, geoms, &near->pairs));
}
