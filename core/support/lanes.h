/*
 * Two neighbouring numbers, which processors add and multiply together. Each comes out as it would alone, so that
 * results do not depend on it; it says what the compiler does not always find out by itself.
 */
#ifndef PINCH_SUPPORT_LANES_H
#define PINCH_SUPPORT_LANES_H

#include <stdint.h>

typedef double pinch_lanes __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double)), may_alias));

/* Reads two numbers from an array. */
static inline pinch_lanes pinch_lanes_at(const double *a)
{
    return *(const pinch_lanes *)a;
}

/* Writes two numbers into an array. */
static inline void pinch_lanes_put(pinch_lanes both, double *a)
{
    *(pinch_lanes *)a = both;
}

static inline pinch_lanes pinch_lanes_abs(pinch_lanes both)
{
    typedef int64_t bits __attribute__((vector_size(2 * sizeof(int64_t))));
    typedef double plain __attribute__((vector_size(2 * sizeof(double))));
    const bits all_but_sign = {INT64_MAX, INT64_MAX};
    return (plain)((bits)both & all_but_sign);
}

#endif
