#include "support/block_lu.h"

#include "support/await.h"
#include "support/lu.h"

#include <stdint.h>
#include <string.h>

enum { BODY = 6, LONGEST_RUN = PINCH_BLOCK_LU_RUN }; /* unknowns of a free body; blocks */

static inline int later_of(const pinch_block_lu *lu, int k)
{
    return lu->later_start[k + 1] - lu->later_start[k];
}

/* Rows of single precision lie in one line of the cache. */
static float *aligned_singles(pinch_arena *arena, size_t count)
{
    enum { LINE = 64 };
    float *all = PINCH_ARENA_ARRAY(arena, float, count + LINE / sizeof(float));
    return all ? (float *)(((uintptr_t)all + LINE - 1) & ~(uintptr_t)(LINE - 1)) : NULL;
}

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
        diagonals += lu->single ? PINCH_SINGLE_BLOCK : mine * mine;
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            lu->lower[e] = lowers;
            lowers += lu->single ? PINCH_SINGLE_BLOCK : mine * (size_t)lu->size[lu->order[lu->later[e]]];
        }
    }
    for (int e = 0; e < entries; e++) lu->lower[e] += diagonals;
    lu->to_upper = lowers;
    lu->value_count = diagonals + 2 * lowers;
    lu->values = lu->single ? NULL : PINCH_ARENA_ARRAY(arena, double, lu->value_count + 1);
    lu->singles = lu->single ? aligned_singles(arena, lu->value_count) : NULL;
    lu->pivot = PINCH_ARENA_ARRAY(arena, int, lu->first[n] + 1);
    lu->scratch = PINCH_ARENA_ARRAY(arena, double, largest *(largest + 1) + 1);
    return !arena->failed;
}

static bool find_runs(pinch_arena *arena, pinch_block_lu *lu)
{
    lu->run = PINCH_ARENA_ARRAY(arena, int, lu->count + 1);
    if (arena->failed) return false;
    for (int k = lu->count - 1; k >= 0; k--) {
        bool joins = k + 1 < lu->count && lu->size[lu->order[k]] == BODY && lu->size[lu->order[k + 1]] == BODY &&
                     later_of(lu, k) == later_of(lu, k + 1) + 1 && lu->later[lu->later_start[k]] == k + 1;
        lu->run[k] = joins && lu->run[k + 1] < LONGEST_RUN ? lu->run[k + 1] + 1 : 1;
    }
    return true;
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

static bool plan_in(bool single, pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                    pinch_block_order_memory *memory, pinch_block_lu *lu)
{
    pinch_block_order order;
    if (!pinch_block_order_make(arena, graph, limit, memory, &order)) return false;
    lu->products = cost_of(&order, size, graph->count);
    lu->count = graph->count;
    lu->early = graph->early;
    lu->incomplete = order.without_fill;
    lu->symmetric = false;
    lu->single = single && !lu->incomplete;
    lu->width = pinch_widest();
    lu->size = size;
    lu->order = order.order;
    lu->place = order.place;
    lu->visit = order.visit;
    lu->later_start = order.start;
    lu->later = order.later;
    lu->earlier_start = NULL;
    return place_blocks(arena, lu, order.entries) && (lu->incomplete || find_runs(arena, lu));
}

bool pinch_block_lu_plan(pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                         pinch_block_order_memory *memory, pinch_block_lu *lu)
{
    return plan_in(false, arena, graph, size, limit, memory, lu);
}

bool pinch_block_lu_plan_single(pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                                pinch_block_order_memory *memory, pinch_block_lu *lu)
{
    return plan_in(true, arena, graph, size, limit, memory, lu);
}

static void clear_range(const pinch_block_lu *lu, size_t first, size_t end)
{
    if (first >= end) return;
    if (lu->single)
        memset(lu->singles + first, 0, sizeof(float) * (end - first));
    else
        memset(lu->values + first, 0, sizeof(double) * (end - first));
}

void pinch_block_lu_clear_part(pinch_block_lu *lu, size_t first, size_t end)
{
    size_t upper = lu->value_count - lu->to_upper, lower = upper - lu->to_upper;
    if (!lu->symmetric) {
        clear_range(lu, first, end);
        return;
    }
    clear_range(lu, first, end < lower ? end : lower);
    clear_range(lu, first > upper ? first : upper, end);
}

void pinch_block_lu_clear(pinch_block_lu *lu)
{
    pinch_block_lu_clear_part(lu, 0, lu->value_count);
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

size_t pinch_block_lu_offset(const pinch_block_lu *lu, int row, int column)
{
    int r = lu->place[row], c = lu->place[column];
    if (r == c) return lu->diagonal[r];
    if (r < c) return lu->lower[entry_of(lu, r, c)] + lu->to_upper;
    return lu->lower[entry_of(lu, c, r)];
}

/*
 * For the blocks from the k-th on, `count` of a run: A_ij -= A_ik U_kj and A_ji -= A_jk U_ki with all j >= i among
 * their last `later` later blocks, of which i is the first. What each block is left is the same to the bit as if one
 * block after the other were eliminated. Of a symmetric matrix the A_ij are enough.
 */
static inline void update_row(const pinch_block_lu *lu, int k, int count, int later)
{
    if (lu->single) {
        pinch_block_lu_single_update_row(lu, k, count, later);
        return;
    }
    const double *left[LONGEST_RUN], *right[LONGEST_RUN], *lower[LONGEST_RUN], *upper[LONGEST_RUN];
    int entry = lu->later_start[k + count] - later, mine = lu->size[lu->order[k]];
    int i = lu->later[entry], rows = lu->size[lu->order[i]];
    for (int p = 0; p < count; p++) {
        int e = lu->later_start[k + p + 1] - later;
        left[p] = lu->values + lu->lower[e];
        right[p] = pinch_block_lu_upper(lu, e);
    }
    pinch_block_subtract_products(count, rows, mine, rows, left, right, lu->values + lu->diagonal[i]);
    int inside = lu->later_start[i]; /* both lists ascend */
    for (int b = 1; b < later; b++) {
        int j = lu->later[entry + b], columns = lu->size[lu->order[j]];
        while (lu->later[inside] < j) inside++;
        for (int p = 0; p < count; p++) {
            int e = lu->later_start[k + p + 1] - later + b;
            lower[p] = lu->values + lu->lower[e];
            upper[p] = pinch_block_lu_upper(lu, e);
        }
        pinch_block_subtract_products(count, rows, mine, columns, left, upper, pinch_block_lu_upper(lu, inside));
        if (!lu->symmetric)
            pinch_block_subtract_products(count, columns, mine, rows, lower, right, lu->values + lu->lower[inside]);
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

/* Makes A_jk of the block A_kj of the entry e. */
static inline void transpose(const pinch_block_lu *lu, int e, int rows, int columns)
{
    pinch_block_transpose(rows, columns, pinch_block_lu_upper(lu, e), lu->values + lu->lower[e]);
}

/* Factors the k-th diagonal block, and forms U_kj = A_kk^-1 A_kj. Returns false when a pivot is none. */
static inline bool factor_own(const pinch_block_lu *lu, int k, double *scratch)
{
    if (lu->single) return pinch_block_lu_single_factor_own(lu, k);
    int block = lu->order[k], mine = lu->size[block], *pivot = lu->pivot + lu->first[block];
    double *diagonal = lu->values + lu->diagonal[k];
    bool early = is_inverted(lu, block), identity = early && is_identity(mine, diagonal);
    if (!identity &&
        !(early ? pinch_block_invert(mine, diagonal, pivot) : pinch_lu_factor(mine, diagonal, pivot, scratch)))
        return false;
    for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
        int other = lu->size[lu->order[lu->later[e]]];
        double *upper = pinch_block_lu_upper(lu, e);
        if (lu->symmetric) transpose(lu, e, mine, other);
        if (identity) continue;
        if (early)
            pinch_block_multiply(mine, other, diagonal, upper, scratch);
        else
            pinch_block_solve(mine, other, diagonal, pivot, upper);
    }
    return true;
}

/* x_k = A_kk^-1 x_k */
static inline void solve_own(const pinch_block_lu *lu, int k, double *negative, double *x)
{
    if (lu->single) {
        pinch_block_lu_single_solve_own(lu, k, x);
        return;
    }
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
    if (lu->single) {
        pinch_block_lu_single_subtract_earlier(lu, k, a, x);
        return;
    }
    int block = lu->order[k], other = lu->order[lu->later[a]];
    pinch_block_subtract_applied(lu->size[other], lu->size[block], lu->values + lu->lower[a], x + lu->first[block],
                                 x + lu->first[other]);
}

/* x_k -= U_kj x_j for all j */
static inline void subtract_later(const pinch_block_lu *lu, int k, double *x)
{
    if (lu->single) {
        pinch_block_lu_single_subtract_later(lu, k, x);
        return;
    }
    int block = lu->order[k];
    for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
        int other = lu->order[lu->later[e]];
        pinch_block_subtract_applied(lu->size[block], lu->size[other], pinch_block_lu_upper(lu, e),
                                     x + lu->first[other], x + lu->first[block]);
    }
}

/* Factors, and where x is given, eliminates what is known of it on the way. Returns false when a pivot is none. */
static bool factor_with(pinch_block_lu *lu, double *x)
{
    for (int k = 0, run; k < lu->count; k += run) {
        run = lu->run[k];
        for (int i = k; i < k + run; i++) {
            if (i > k) update_row(lu, k, i - k, later_of(lu, i) + 1);
            if (!factor_own(lu, i, lu->scratch)) return false;
            solve_own(lu, i, lu->scratch, x);
            for (int a = lu->later_start[i]; a < lu->later_start[i + 1]; a++) subtract_earlier(lu, i, a, x);
        }
        for (int later = later_of(lu, k + run - 1); later > 0; later--) update_row(lu, k, run, later);
    }
    return true;
}

static void solve_back(const pinch_block_lu *lu, double *x)
{
    for (int k = lu->count - 1; k >= 0; k--) subtract_later(lu, k, x);
}

static void solve_alone(const pinch_block_lu *lu, double *x)
{
    for (int k = 0; k < lu->count; k++) {
        solve_own(lu, k, lu->scratch, x);
        for (int a = lu->later_start[k]; a < lu->later_start[k + 1]; a++) subtract_earlier(lu, k, a, x);
    }
    solve_back(lu, x);
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
    for (int m = lu->earlier_start[i], run; m < lu->earlier_start[i + 1]; m += run) {
        int k = lu->earlier[m].place, most = lu->run[k] < i - k ? lu->run[k] : i - k;
        pinch_await(&lu->done[k], 1);
        for (run = 1; run < most && pinch_has_said(&lu->done[k + run], 1);) run++; /* more would be waited for */
        update_row(lu, k, run, lu->later_start[k + 1] - lu->earlier[m].entry);
        for (int p = 0; p < run; p++) subtract_earlier(lu, k + p, lu->earlier[m + p].entry, x);
    }
    if (!factor_own(lu, i, scratch)) return false;
    solve_own(lu, i, scratch, x);
    return true;
}

static int visited(const pinch_block_lu *lu, int at)
{
    return lu->visit ? lu->visit[at] : at;
}

static void eliminate_rows(void *argument, int first, int end)
{
    shared_solve *s = argument;
    (void)first, (void)end;
    for (int taken; (taken = atomic_fetch_add(&s->next, 1)) < s->lu->count;) {
        int i = visited(s->lu, taken);
        if (!atomic_load(&s->singular) && !eliminate_row(s->lu, i, s->x)) atomic_store(&s->singular, true);
        pinch_say(&s->lu->done[i], 1);
    }
}

/* Solves take little time for a row: threads take several at once. */
enum { ROWS_AT_ONCE = 8 };

static void solve_row(const pinch_block_lu *lu, int i, double *x)
{
    double scratch[SMALL * (SMALL + 1)];
    for (int m = lu->earlier_start[i]; m < lu->earlier_start[i + 1]; m++) {
        pinch_await(&lu->done[lu->earlier[m].place], 1);
        subtract_earlier(lu, lu->earlier[m].place, lu->earlier[m].entry, x);
    }
    solve_own(lu, i, scratch, x);
}

static void go_forward(void *argument, int first, int end)
{
    shared_solve *s = argument;
    const pinch_block_lu *lu = s->lu;
    (void)first, (void)end;
    for (int from; (from = atomic_fetch_add(&s->next, ROWS_AT_ONCE)) < lu->count;) {
        for (int at = from; at < from + ROWS_AT_ONCE && at < lu->count; at++) {
            int i = visited(lu, at);
            solve_row(lu, i, s->x);
            pinch_say(&lu->done[i], 1);
        }
    }
}

/* All later blocks are ancestors of a block in the tree of elimination, in which the first of them is its parent. */
static void go_back(void *argument, int first, int end)
{
    shared_solve *s = argument;
    const pinch_block_lu *lu = s->lu;
    (void)first, (void)end;
    for (int taken; (taken = atomic_fetch_add(&s->next, ROWS_AT_ONCE)) < lu->count;) {
        int from = lu->count - 1 - taken, to = from - ROWS_AT_ONCE;
        for (int at = from; at > to && at >= 0; at--) {
            int k = visited(lu, at);
            if (lu->later_start[k] < lu->later_start[k + 1]) pinch_await(&lu->done[lu->later[lu->later_start[k]]], 2);
            subtract_later(lu, k, s->x);
            pinch_say(&lu->done[k], 2);
        }
    }
}

/* To hand a row from thread to thread takes as long as to eliminate some of its blocks. */
static bool is_shared(const pinch_block_lu *lu, const pinch_crew *crew)
{
    enum { BLOCKS = 4 /* of a row, in the mean */ };
    bool small = crew && lu->earlier_start && lu->later_start[lu->count] >= BLOCKS * lu->count;
    for (int k = 0; k < lu->count && small; k++) small = lu->size[k] <= SMALL;
    return small;
}

/* Does `forward` with all threads, and then what is to be done backwards. Returns false when a pivot is none. */
static bool go_there_and_back(const pinch_block_lu *lu, const pinch_crew *crew, pinch_loop_part *forward, double *x)
{
    shared_solve s = {.lu = lu, .x = x};
    for (int k = 0; k < lu->count; k++) atomic_init(&lu->done[k], 0);
    pinch_all_at_once(crew, forward, &s);
    if (atomic_load(&s.singular)) return false;
    atomic_store(&s.next, 0);
    pinch_all_at_once(crew, go_back, &s);
    return true;
}

void pinch_block_lu_solve(const pinch_block_lu *lu, const pinch_crew *crew, double *x)
{
    if (is_shared(lu, crew))
        (void)go_there_and_back(lu, crew, go_forward, x);
    else
        solve_alone(lu, x);
}

bool pinch_block_lu_factor_and_solve(pinch_block_lu *lu, const pinch_crew *crew, double *x)
{
    if (is_shared(lu, crew)) return go_there_and_back(lu, crew, eliminate_rows, x);
    if (!factor_with(lu, x)) return false;
    solve_back(lu, x);
    return true;
}
