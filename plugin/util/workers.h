/* Threads that share the items of a loop. What happens to an item must not depend on who does it, nor on when. */
#ifndef PINCH_UTIL_WORKERS_H
#define PINCH_UTIL_WORKERS_H

#include <stdbool.h>

typedef struct pinch_workers pinch_workers;

/* Does items first to end - 1. Workers are numbered from 0 to threads - 1; each does one range at a time. */
typedef void pinch_task(void *context, int worker, int first, int end);

/* threads >= 2 counts the caller's own. Returns NULL when memory runs out or the system gives no threads. */
pinch_workers *pinch_workers_create(int threads);
/* NULL is allowed. */
void pinch_workers_destroy(pinch_workers *workers);

/* Wakes the threads up. Until they are dismissed they look out for loops, and give way to whatever else wants their
 * cores; where none comes for a while, they sleep until the next one. NULL is allowed. */
void pinch_workers_call(pinch_workers *workers);
/* Lets them sleep after a loop, as what comes next may take long; they linger for a moment. NULL is allowed. */
void pinch_workers_dismiss(pinch_workers *workers);

/* Runs the task over items 0 to count - 1 in ranges of `grain`, and returns when all are done. Each thread begins with
 * a share of its own, worker 0, the caller, with the first; it does not wait for threads that have not begun when
 * nothing is left to do. The caller does it alone where workers is NULL or there are no more items than one range has.
 */
void pinch_workers_run(pinch_workers *workers, pinch_task *task, void *context, int count, int grain);

#endif
