#include "support/block_dilu.h"

#include "support/blocks.h"

#include <string.h>

static int size_of(const pinch_block_lu *lu, int k)
{
    return lu->size[lu->order[k]];
}

size_t pinch_block_dilu_room(const pinch_block_lu *lu)
{
    int largest = 0;
    for (int b = 0; b < lu->count; b++) largest = lu->size[b] > largest ? lu->size[b] : largest;
    return (size_t)largest * (size_t)lu->first[lu->count];
}

/* Puts D^-1 in the place of the diagonal, D^-1 U in that of U, and D - D0 into `change`, `width` doubles for each
 * unknown. */
static bool find_diagonal(pinch_block_lu *lu, double *change, size_t width)
{
    for (int k = 0; k < lu->count; k++) {
        int mine = size_of(lu, k);
        double *diagonal = lu->values + lu->diagonal[k];
        const double *changed = change + width * (size_t)lu->first[lu->order[k]];
        for (int i = 0; i < mine * mine; i++) diagonal[i] += changed[i];
        if (!pinch_block_invert(mine, diagonal, lu->pivot)) return false;
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int later = lu->order[lu->later[e]], other = lu->size[later];
            double *upper = pinch_block_lu_upper(lu, e);
            pinch_block_multiply(mine, other, diagonal, upper, lu->scratch);
            pinch_block_subtract_product(other, mine, other, lu->values + lu->lower[e], upper,
                                         change + width * (size_t)lu->first[later]);
        }
    }
    return true;
}

/* Makes D^-1 L of L; the diagonal is D^-1 already. */
static void scale_lower(pinch_block_lu *lu)
{
    for (int k = 0; k < lu->count; k++) {
        int mine = size_of(lu, k);
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int j = lu->later[e];
            pinch_block_multiply(size_of(lu, j), mine, lu->values + lu->diagonal[j], lu->values + lu->lower[e],
                                 lu->scratch);
        }
    }
}

bool pinch_block_dilu_split(pinch_block_lu *lu, double *b, double *room)
{
    size_t width = pinch_block_dilu_room(lu) / (size_t)lu->first[lu->count];
    memset(room, 0, sizeof *room * pinch_block_dilu_room(lu));
    if (!find_diagonal(lu, room, width)) return false;
    scale_lower(lu);
    for (int k = 0; k < lu->count; k++) { /* D^-1 D0 - 2 = -(D^-1 (D - D0) + 1) */
        int mine = size_of(lu, k), first = lu->first[lu->order[k]];
        double *diagonal = lu->values + lu->diagonal[k], *change = room + width * (size_t)first;
        memcpy(lu->scratch, b + first, sizeof *b * (size_t)mine);
        for (int i = 0; i < mine; i++) {
            b[first + i] = 0;
            lu->scratch[i] = -lu->scratch[i];
        }
        pinch_block_subtract_applied(mine, mine, diagonal, lu->scratch, b + first);
        pinch_block_multiply(mine, mine, diagonal, change, lu->scratch);
        for (int i = 0; i < mine * mine; i++) diagonal[i] = -change[i];
        for (int i = 0; i < mine; i++) diagonal[i * (mine + 1)] -= 1;
    }
    return true;
}

void pinch_block_dilu_lower(const pinch_block_lu *lu, double *x)
{
    for (int k = 0; k < lu->count; k++) {
        int mine = size_of(lu, k);
        const double *part = x + lu->first[lu->order[k]];
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int later = lu->order[lu->later[e]];
            pinch_block_subtract_applied(lu->size[later], mine, lu->values + lu->lower[e], part, x + lu->first[later]);
        }
    }
}

void pinch_block_dilu_upper(const pinch_block_lu *lu, double *x)
{
    for (int k = lu->count - 1; k >= 0; k--) {
        int mine = size_of(lu, k);
        double *part = x + lu->first[lu->order[k]];
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int later = lu->order[lu->later[e]], other = lu->size[later];
            pinch_block_subtract_applied(mine, other, pinch_block_lu_upper(lu, e), x + lu->first[later],
                                         part);
        }
    }
}

void pinch_block_dilu_times(const pinch_block_lu *lu, const double *v, double *kv, double *y)
{
    int n = lu->first[lu->count];
    memcpy(y, v, sizeof *y * (size_t)n);
    pinch_block_dilu_upper(lu, y);
    for (int i = 0; i < n; i++) kv[i] = -v[i];
    for (int k = 0; k < lu->count; k++) {
        int mine = size_of(lu, k), first = lu->first[lu->order[k]];
        pinch_block_subtract_applied(mine, mine, lu->values + lu->diagonal[k], y + first, kv + first);
    }
    pinch_block_dilu_lower(lu, kv); /* all of it with the other sign */
    for (int i = 0; i < n; i++) kv[i] = y[i] - kv[i];
}
