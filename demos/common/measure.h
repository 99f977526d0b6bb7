#ifndef PINCH_COMMON_MEASURE_H
#define PINCH_COMMON_MEASURE_H

#include <stdbool.h>

/* Seconds on a clock that only goes forward. */
double clock_seconds(void);
/* Seconds of CPU time of this thread. What other programs take in between does not count. */
double clock_thread_seconds(void);

/* Does this machine let a program count the instructions that its thread executes in user space? */
bool instructions_counted(void);
/* Instructions so far; NaN where they are not counted. */
double instructions_now(void);

/* The median of `count` values, which are sorted in place. For an even count it is the upper of the two values in the
 * middle. NaN for no values. */
double median(double *values, int count);

#endif
