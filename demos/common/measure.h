#ifndef PINCH_COMMON_MEASURE_H
#define PINCH_COMMON_MEASURE_H

/* Seconds on a clock that only goes forward. */
double clock_seconds(void);
/* Seconds of CPU time of this thread. What other programs take in between does not count. */
double clock_thread_seconds(void);

/* The median of `count` values, which are sorted in place. For an even count it is the upper of the two values in the
 * middle. NaN for no values. */
double median(double *values, int count);

#endif
