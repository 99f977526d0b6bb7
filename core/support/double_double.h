/*
 * Numbers of twice the precision of a double, 106 binary digits: the unevaluated sum of two doubles, of which the
 * second is at most half a unit in the last place of the first (Dekker, "A floating-point technique for extending the
 * available precision", 1971). The C type long double is another one on each kind of machine; these have the same bits
 * on all whose doubles are those of IEEE 754.
 *
 * The sum and the product of two doubles are exact, errors kept (Knuth, The Art of Computer Programming, volume
 * 2, 4.2.2, and Dekker). That needs a compiler that neither reorders nor contracts: -ffp-contract=off, no -ffast-math.
 * Products are split instead of taken by fma(), which is a slow call where the processor has no such instruction.
 *
 * Where the first part overflows, the second is 0, so that an infinity stays one. Above 2^996 and below 2^-968 products
 * have the precision of doubles.
 */
#ifndef PINCH_SUPPORT_DOUBLE_DOUBLE_H
#define PINCH_SUPPORT_DOUBLE_DOUBLE_H

#include <math.h>

typedef struct pinch_double_double {
    double high, low;
} pinch_double_double;

/* a + b, exact */
static inline pinch_double_double pinch_dd_sum(double a, double b)
{
    double sum = a + b, part = sum - a;
    double error = (a - (sum - part)) + (b - part);
    return (pinch_double_double){sum, isfinite(sum) ? error : 0};
}

/* The halves of a, 26 digits and a sign each: their products are exact. */
static inline pinch_double_double pinch_dd_split(double a)
{
    double shifted = 134217729 * a; /* 2^27 + 1 */
    double high = shifted - (shifted - a);
    return (pinch_double_double){high, a - high};
}

/* a b, exact */
static inline pinch_double_double pinch_dd_product(double a, double b)
{
    double product = a * b;
    pinch_double_double x = pinch_dd_split(a), y = pinch_dd_split(b);
    double error = ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low;
    return (pinch_double_double){product, isfinite(error) ? error : 0};
}

/* a + b to 104 digits of the sum, however much cancels (Li et al., "Design, implementation and testing of extended and
 * mixed precision BLAS", 2002) */
static inline pinch_double_double pinch_dd_add(pinch_double_double a, pinch_double_double b)
{
    pinch_double_double high = pinch_dd_sum(a.high, b.high), low = pinch_dd_sum(a.low, b.low);
    high = pinch_dd_sum(high.high, high.low + low.high);
    return pinch_dd_sum(high.high, high.low + low.low);
}

/* a b to 103 digits */
static inline pinch_double_double pinch_dd_times(double a, pinch_double_double b)
{
    pinch_double_double product = pinch_dd_product(a, b.high);
    return pinch_dd_sum(product.high, product.low + a * b.low);
}

#endif
