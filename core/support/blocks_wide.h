/*
 * Products of the blocks of bodies, 6 x 6, in registers of more than two numbers, on processors that have such: most of
 * what a large factorization does. Each number is the same sum in the same order as in pairs, and comes out to the bit.
 */
#ifndef PINCH_SUPPORT_BLOCKS_WIDE_H
#define PINCH_SUPPORT_BLOCKS_WIDE_H

#include <stdbool.h>

/* Registers hold so many numbers. */
typedef enum pinch_width { PINCH_PAIRS = 2, PINCH_FOURS = 4, PINCH_EIGHTS = 8 } pinch_width;

/* Returns the widest that the processor has. */
static inline pinch_width pinch_widest(void)
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx512f") ? PINCH_EIGHTS
           : __builtin_cpu_supports("avx2")  ? PINCH_FOURS
                                             : PINCH_PAIRS;
#else
    return PINCH_PAIRS;
#endif
}

/* These do nothing and return false where there is nothing for registers of that width. */

/* Does c -= sum of a[p] b[p], p < count. */
bool pinch_wide_subtract_products(pinch_width width, int count, const double *const a[], const double *const b[],
                                  double *c);

/* Does c = a b. */
bool pinch_wide_product(pinch_width width, const double *a, const double *b, double *c);

/* Does what pinch_block_add_contact does. */
bool pinch_wide_add_contact(pinch_width width, const double *const left[2], const double d[9], const double *right,
                            double *const to[2]);

#endif
