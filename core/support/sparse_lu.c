#include "support/sparse_lu.h"

#include "support/dense.h"
#include "support/extremes.h"

#include <math.h>
#include <string.h>

enum { BITS = 64 };

static int words_of(int n)
{
    return (n + BITS - 1) / BITS;
}

bool pinch_sparse_lu_allocate(pinch_arena *arena, int n, pinch_sparse_lu *lu)
{
    size_t words = (size_t)words_of(n);
    lu->room = n;
    lu->upper = PINCH_ARENA_ARRAY(arena, uint64_t, words * (size_t)n + 1);
    lu->row = PINCH_ARENA_ARRAY(arena, uint64_t, words + 1);
    lu->inverse = PINCH_ARENA_ARRAY(arena, double, n + 1);
    lu->stretch = PINCH_ARENA_ARRAY(arena, pinch_sparse_stretch, n + 1);
    return !arena->failed;
}

static int lowest(uint64_t bits)
{
    return __builtin_ctzll(bits);
}

/* Notes which entries of a row are not zero. */
static void note_entries(int n, const double *row, uint64_t *bits)
{
    for (int first = 0; first < n; first += BITS) {
        uint64_t word = 0;
        int end = n - first < BITS ? n - first : BITS;
        for (int j = 0; j < end; j++) word |= (uint64_t)(row[first + j] != 0) << j;
        bits[first / BITS] = word;
    }
}

/* Takes a multiple of row k of U from the row at hand, whose pattern grows by that row's. */
static void subtract(const pinch_sparse_lu *lu, int n, double factor, int k, const double *above, double *row)
{
    int words = words_of(n);
    const uint64_t *upper = lu->upper + (size_t)k * (size_t)words;
    const pinch_sparse_stretch *of = &lu->stretch[k];
    if (of->size > 0) pinch_add_multiple(of->size, -factor, above + of->first, row + of->first);
    for (int w = 0; w < words; w++) {
        lu->row[w] |= upper[w];
        for (uint64_t left = of->size > 0 ? 0 : upper[w]; left != 0; left &= left - 1) {
            int j = w * BITS + lowest(left);
            row[j] -= factor * above[j];
        }
    }
}

/* The stretch of a row of U. Where more than two in five of it may not be zero, all of it is multiplied sooner than
 * these are looked for. */
static pinch_sparse_stretch stretch_of(int words, const uint64_t *upper)
{
    int first = -1, last = -1, count = 0;
    for (int w = 0; w < words; w++) {
        for (uint64_t left = upper[w]; left != 0; left &= left - 1) count++;
        if (upper[w] == 0) continue;
        if (first < 0) first = w * BITS + lowest(upper[w]);
        last = w * BITS + BITS - 1 - __builtin_clzll(upper[w]);
    }
    int size = last - first + 1;
    return count > 0 && 5 * count > 2 * size ? (pinch_sparse_stretch){first, size} : (pinch_sparse_stretch){0, 0};
}

/* Makes row i one of L and U by the rows above it. Returns false where an entry of L is too large. */
static bool eliminate_row(const pinch_sparse_lu *lu, int n, double *a, int i)
{
    static const double LARGEST_FACTOR = 1e8;
    double *row = a + (size_t)i * (size_t)n, largest = 0;
    for (int w = 0; w <= i / BITS; w++) {
        uint64_t below = w < i / BITS ? ~(uint64_t)0 : ((uint64_t)1 << i % BITS) - 1, done = 0;
        while ((lu->row[w] & below & ~done) != 0) {
            int bit = lowest(lu->row[w] & below & ~done), k = w * BITS + bit;
            double factor = row[k] *= lu->inverse[k];
            done |= (uint64_t)1 << bit;
            largest = pinch_larger(fabs(factor), largest);
            subtract(lu, n, factor, k, a + (size_t)k * (size_t)n, row);
        }
    }
    return largest <= LARGEST_FACTOR;
}

bool pinch_sparse_lu_factor(const pinch_sparse_lu *lu, int n, double *a)
{
    int words = words_of(n);
    for (int i = 0; i < n; i++) {
        double *row = a + (size_t)i * (size_t)n;
        uint64_t *upper = lu->upper + (size_t)i * (size_t)words;
        note_entries(n, row, lu->row);
        if (!eliminate_row(lu, n, a, i)) return false;
        lu->inverse[i] = 1 / row[i];
        if (!isfinite(row[i]) || !isfinite(lu->inverse[i])) return false;
        for (int w = 0; w < words; w++) upper[w] = w < i / BITS ? 0 : lu->row[w];
        upper[i / BITS] &= i % BITS == BITS - 1 ? 0 : ~(uint64_t)0 << (i % BITS + 1);
        lu->stretch[i] = stretch_of(words, upper);
    }
    return true;
}
