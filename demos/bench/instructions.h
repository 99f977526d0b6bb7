#ifndef PINCH_BENCH_INSTRUCTIONS_H
#define PINCH_BENCH_INSTRUCTIONS_H

#include <stdbool.h>

/* Counts the instructions that this thread executes in user space, where Linux and the machine permit it. */

/* Returns false where they do not. Opens the counter once. */
bool instructions_counted(void);
/* Instructions so far; NaN where they are not counted. */
double instructions_now(void);

#endif
