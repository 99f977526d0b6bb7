#include "support/block_lu.h"

#include "support/await.h"
#include "support/blocks.h"
#include "support/lu.h"

#include <string.h>

static bool place_blocks(pinch_arena *arena, pinch_block_lu *lu, int entries)
{
    int n = lu->count, largest = 0;
    lu->first = PINCH_ARENA_ARRAY(arena, int, n + 1);
    lu->diagonal = PINCH_ARENA_ARRAY(arena, size_t, n + 1);
    lu->lower = PINCH_ARENA_ARRAY(arena, size_t, entries + 1);
    if (arena->failed) return false;
    lu->first[0] = 0;
    for (int b = 0; b < n; b++) {
        lu->first[b + 1] = lu->first[b] + lu->size[b];
        if (lu->size[b] > largest) largest = lu->size[b];
    }
    size_t diagonals = 0, lowers = 0;
    for (int k = 0; k < n; k++) {
        size_t mine = (size_t)lu->size[lu->order[k]];
        lu->diagonal[k] = diagonals;
        diagonals += mine * mine;
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            lu->lower[e] = lowers;
            lowers += mine * (size_t)lu->size[lu->order[lu->later[e]]];
        }
    }
    for (int e = 0; e < entries; e++) lu->lower[e] += diagonals;
    lu->to_upper = lowers;
    lu->value_count = diagonals + 2 * lowers;
    lu->values = PINCH_ARENA_ARRAY(arena, double, lu->value_count + 1);
    lu->pivot = PINCH_ARENA_ARRAY(arena, int, lu->first[n] + 1);
    lu->scratch = PINCH_ARENA_ARRAY(arena, double, largest *(largest + 1) + 1);
    return !arena->failed;
}

/* Returns what a factorization in this order takes, in products of 6 x 6 blocks. */
static double cost_of(const pinch_block_order *order, const int *size, int count)
{
    static const double UNIT = 6 * 6 * 6;
    double sum = 0;
    for (int k = 0; k < count; k++) {
        double mine = size[order->order[k]], reach = mine;
        for (int e = order->start[k]; e < order->start[k + 1]; e++) reach += size[order->order[order->later[e]]];
        sum += mine * reach * reach;
    }
    return sum / UNIT;
}

bool pinch_block_lu_plan(pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                         pinch_block_lu *lu)
{
    pinch_block_order order;
    if (!pinch_block_order_make(arena, graph, limit, &order)) return false;
    lu->products = cost_of(&order, size, graph->count);
    lu->count = graph->count;
    lu->early = graph->early;
    lu->incomplete = order.without_fill;
    lu->size = size;
    lu->order = order.order;
    lu->place = order.place;
    lu->later_start = order.start;
    lu->later = order.later;
    lu->earlier_start = NULL;
    return place_blocks(arena, lu, order.entries);
}

void pinch_block_lu_clear(pinch_block_lu *lu)
{
    memset(lu->values, 0, sizeof(double) * lu->value_count);
}

/* Where `place` stands among the later blocks of the k-th; it is there. */
static int entry_of(const pinch_block_lu *lu, int k, int place)
{
    int low = lu->later_start[k], high = lu->later_start[k + 1] - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (lu->later[middle] < place)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

double *pinch_block_lu_at(const pinch_block_lu *lu, int row, int column)
{
    int r = lu->place[row], c = lu->place[column];
    if (r == c) return lu->values + lu->diagonal[r];
    if (r < c) return pinch_block_lu_upper(lu, entry_of(lu, r, c));
    return lu->values + lu->lower[entry_of(lu, c, r)];
}

/* Of the later blocks i, j of the k-th, all blocks (i, j) and (j, i) of one i, that of the entry a, with j >= i:
 * A_ij -= A_ik U_kj. */
static inline void update_with(const pinch_block_lu *lu, int k, int mine, int a)
{
    int end = lu->later_start[k + 1], i = lu->later[a], rows = lu->size[lu->order[i]];
    const double *left = lu->values + lu->lower[a], *right = pinch_block_lu_upper(lu, a);
    pinch_block_subtract_product(rows, mine, rows, left, right, lu->values + lu->diagonal[i]);
    int inside = lu->later_start[i]; /* both lists ascend */
    for (int b = a + 1; b < end; b++) {
        int j = lu->later[b], columns = lu->size[lu->order[j]];
        while (lu->later[inside] < j) inside++;
        pinch_block_subtract_product(rows, mine, columns, left, pinch_block_lu_upper(lu, b),
                                     pinch_block_lu_upper(lu, inside));
        pinch_block_subtract_product(columns, mine, rows, lu->values + lu->lower[b], right,
                                     lu->values + lu->lower[inside]);
    }
}

/* Small diagonal blocks are inverted, because many products with the inverse follow. Factors of wide ones take a third
 * of that work. */
static bool is_inverted(const pinch_block_lu *lu, int block)
{
    enum { WIDEST = 6 };
    return block < lu->early && lu->size[block] <= WIDEST;
}

/* Bodies that no contact acts on have the identity until something fills in. */
static bool is_identity(int size, const double *a)
{
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++)
            if (a[i * size + j] != (i == j)) return false;
    return true;
}

/* Factors the k-th diagonal block, and forms U_kj = A_kk^-1 A_kj. Returns false when a pivot is none. */
static inline bool factor_own(const pinch_block_lu *lu, int k, double *scratch)
{
    int block = lu->order[k], mine = lu->size[block], *pivot = lu->pivot + lu->first[block];
    double *diagonal = lu->values + lu->diagonal[k];
    bool early = is_inverted(lu, block), identity = early && is_identity(mine, diagonal);
    if (!identity &&
        !(early ? pinch_block_invert(mine, diagonal, pivot) : pinch_lu_factor(mine, diagonal, pivot, scratch)))
        return false;
    for (int e = lu->later_start[k]; e < lu->later_start[k + 1] && !identity; e++) {
        int other = lu->size[lu->order[lu->later[e]]];
        double *upper = pinch_block_lu_upper(lu, e);
        if (early)
            pinch_block_multiply(mine, other, diagonal, upper, scratch);
        else
            pinch_block_solve(mine, other, diagonal, pivot, upper);
    }
    return true;
}

bool pinch_block_lu_factor(pinch_block_lu *lu)
{
    for (int k = 0; k < lu->count; k++) {
        if (!factor_own(lu, k, lu->scratch)) return false;
        int mine = lu->size[lu->order[k]];
        for (int a = lu->later_start[k]; a < lu->later_start[k + 1]; a++) update_with(lu, k, mine, a);
    }
    return true;
}

/* x_k = A_kk^-1 x_k */
static inline void solve_own(const pinch_block_lu *lu, int k, double *negative, double *x)
{
    int block = lu->order[k], mine = lu->size[block];
    double *part = x + lu->first[block];
    if (!is_inverted(lu, block)) {
        pinch_lu_solve(mine, lu->values + lu->diagonal[k], lu->pivot + lu->first[block], part, part);
        return;
    }
    for (int i = 0; i < mine; i++) {
        negative[i] = -part[i];
        part[i] = 0;
    }
    pinch_block_subtract_applied(mine, mine, lu->values + lu->diagonal[k], negative, part);
}

/* x_i -= A_ik x_k, i being that of the entry a */
static inline void subtract_earlier(const pinch_block_lu *lu, int k, int a, double *x)
{
    int block = lu->order[k], other = lu->order[lu->later[a]];
    pinch_block_subtract_applied(lu->size[other], lu->size[block], lu->values + lu->lower[a], x + lu->first[block],
                                 x + lu->first[other]);
}

/* x_k -= U_kj x_j for all j */
static inline void subtract_later(const pinch_block_lu *lu, int k, double *x)
{
    int block = lu->order[k];
    for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
        int other = lu->order[lu->later[e]];
        pinch_block_subtract_applied(lu->size[block], lu->size[other], pinch_block_lu_upper(lu, e),
                                     x + lu->first[other], x + lu->first[block]);
    }
}

void pinch_block_lu_solve(const pinch_block_lu *lu, double *x)
{
    for (int k = 0; k < lu->count; k++) {
        solve_own(lu, k, lu->scratch, x);
        for (int a = lu->later_start[k]; a < lu->later_start[k + 1]; a++) subtract_earlier(lu, k, a, x);
    }
    for (int k = lu->count - 1; k >= 0; k--) subtract_later(lu, k, x);
}

/*
 * ---- by many threads ----
 *
 * Each row of blocks gathers what the eliminated ones before it leave of it, in their order, in which it also comes
 * when each block is handed on as soon as it is eliminated: the sums are the same to the bit.
 */

enum { SMALL = 6 };

bool pinch_block_lu_share(pinch_arena *arena, pinch_block_lu *lu)
{
    int n = lu->count, *next = PINCH_ARENA_ARRAY(arena, int, n + 2);
    lu->earlier_start = next;
    lu->earlier = PINCH_ARENA_ARRAY(arena, pinch_block_lu_earlier, lu->later_start[n] + 1);
    lu->done = PINCH_ARENA_ARRAY(arena, atomic_int, n + 1);
    if (arena->failed) return false;
    memset(next, 0, sizeof *next * (size_t)(n + 2));
    for (int e = 0; e < lu->later_start[n]; e++) next[lu->later[e] + 2]++; /* earlier_start[k + 1] goes up to where */
    for (int k = 0; k < n; k++) next[k + 2] += next[k + 1];                /* k + 1 begins */
    for (int k = 0; k < n; k++)
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++)
            lu->earlier[next[lu->later[e] + 1]++] = (pinch_block_lu_earlier){k, e};
    return true;
}

typedef struct shared_solve {
    const pinch_block_lu *lu;
    double *x;
    atomic_int next;
    atomic_bool singular;
} shared_solve;

static bool eliminate_row(const pinch_block_lu *lu, int i, double *x)
{
    double scratch[SMALL * (SMALL + 1)];
    for (int m = lu->earlier_start[i]; m < lu->earlier_start[i + 1]; m++) {
        int k = lu->earlier[m].place, a = lu->earlier[m].entry;
        pinch_await(&lu->done[k], 1);
        update_with(lu, k, lu->size[lu->order[k]], a);
        subtract_earlier(lu, k, a, x);
    }
    if (!factor_own(lu, i, scratch)) return false;
    solve_own(lu, i, scratch, x);
    return true;
}

static void eliminate_rows(void *argument, int first, int end)
{
    shared_solve *s = argument;
    (void)first, (void)end;
    for (int i; (i = atomic_fetch_add(&s->next, 1)) < s->lu->count;) {
        if (!atomic_load(&s->singular) && !eliminate_row(s->lu, i, s->x)) atomic_store(&s->singular, true);
        pinch_say(&s->lu->done[i], 1);
    }
}

/* All later blocks are ancestors of a block in the tree of elimination, in which the first of them is its parent. */
static void go_back(void *argument, int first, int end)
{
    enum { AT_A_TIME = 8 };
    shared_solve *s = argument;
    const pinch_block_lu *lu = s->lu;
    (void)first, (void)end;
    for (int taken; (taken = atomic_fetch_add(&s->next, AT_A_TIME)) < lu->count;) {
        int from = lu->count - 1 - taken, to = from - AT_A_TIME;
        for (int k = from; k > to && k >= 0; k--) {
            if (lu->later_start[k] < lu->later_start[k + 1]) pinch_await(&lu->done[lu->later[lu->later_start[k]]], 2);
            subtract_later(lu, k, s->x);
            pinch_say(&lu->done[k], 2);
        }
    }
}

bool pinch_block_lu_factor_and_solve(pinch_block_lu *lu, const pinch_crew *crew, double *x)
{
    bool small = lu->earlier_start != NULL;
    for (int k = 0; k < lu->count && small; k++) small = lu->size[k] <= SMALL;
    if (!crew || !small) {
        if (!pinch_block_lu_factor(lu)) return false;
        pinch_block_lu_solve(lu, x);
        return true;
    }
    shared_solve s = {.lu = lu, .x = x};
    for (int k = 0; k < lu->count; k++) atomic_init(&lu->done[k], 0);
    pinch_all_at_once(crew, eliminate_rows, &s);
    if (atomic_load(&s.singular)) return false;
    atomic_store(&s.next, 0);
    pinch_all_at_once(crew, go_back, &s);
    return true;
}
