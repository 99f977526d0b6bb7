#ifndef PINCH_COMMON_MEDIAN_H
#define PINCH_COMMON_MEDIAN_H

/* The median of `count` values, which are sorted in place. For an even count it is the upper of the two values in the
 * middle. NaN for no values. */
double median(double *values, int count);

#endif
