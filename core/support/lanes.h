/*
 * Two neighbouring numbers, which processors add and multiply together. Each comes out as it would alone, so that
 * results do not depend on it; it says what the compiler does not always find out by itself.
 */
#ifndef PINCH_SUPPORT_LANES_H
#define PINCH_SUPPORT_LANES_H

#include <stdint.h>

typedef double pinch_lanes __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double)), may_alias));

/* What comparing two numbers with two others gives: all bits of each are set, or none. */
typedef int64_t pinch_lanes_mask __attribute__((vector_size(2 * sizeof(int64_t))));

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
    const pinch_lanes_mask all_but_sign = {INT64_MAX, INT64_MAX};
    return (pinch_lanes)((pinch_lanes_mask)both & all_but_sign);
}

/* a where the mask is set, and b elsewhere */
static inline pinch_lanes pinch_lanes_choose(pinch_lanes_mask mask, pinch_lanes a, pinch_lanes b)
{
    return (pinch_lanes)((mask & (pinch_lanes_mask)a) | (~mask & (pinch_lanes_mask)b));
}

#endif
