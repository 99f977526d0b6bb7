/* The larger and the smaller of two numbers, inline, where fmax and fmin would be calls; the order matters where one is
 * no number: then the second is returned. */
#ifndef PINCH_SUPPORT_EXTREMES_H
#define PINCH_SUPPORT_EXTREMES_H

static inline double pinch_larger(double a, double b)
{
    return a > b ? a : b;
}

static inline double pinch_smaller(double a, double b)
{
    return a < b ? a : b;
}

/* x within [low, high]; what is no number stays so */
static inline double pinch_clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* x within [low, high]; low where x is no number */
static inline double pinch_within(double x, double low, double high)
{
    return pinch_smaller(pinch_larger(x, low), high);
}

#endif
