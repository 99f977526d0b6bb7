#include "support/sparse_lu.h"

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

/* Takes a multiple of an earlier row of U from the row at hand, whose pattern grows by that row's. */
static void subtract(int words, double factor, const double *above, const uint64_t *upper, double *row, uint64_t *bits)
{
    for (int w = 0; w < words; w++) {
        bits[w] |= upper[w];
        for (uint64_t left = upper[w]; left != 0; left &= left - 1) {
            int j = w * BITS + lowest(left);
            row[j] -= factor * above[j];
        }
    }
}

/* Makes row i one of L and U by the rows above it. Returns false where an entry of L is too large. */
static bool eliminate_row(const pinch_sparse_lu *lu, int n, double *a, int i)
{
    static const double LARGEST_FACTOR = 1e8;
    int words = words_of(n);
    double *row = a + (size_t)i * (size_t)n, largest = 0;
    for (int w = 0; w <= i / BITS; w++) {
        uint64_t below = w < i / BITS ? ~(uint64_t)0 : ((uint64_t)1 << i % BITS) - 1, done = 0;
        while ((lu->row[w] & below & ~done) != 0) {
            int bit = lowest(lu->row[w] & below & ~done), k = w * BITS + bit;
            double factor = row[k] *= lu->inverse[k];
            done |= (uint64_t)1 << bit;
            largest = fmax(largest, fabs(factor));
            subtract(words, factor, a + (size_t)k * (size_t)n, lu->upper + (size_t)k * (size_t)words, row, lu->row);
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
    }
    return true;
}
