/* Threads that share out the items of a loop. What an item does must not depend on who does it, nor on when. */
#ifndef PINCH_UTIL_WORKERS_H
#define PINCH_UTIL_WORKERS_H

#include <stdbool.h>

typedef struct pinch_workers pinch_workers;

/* Items first to end - 1, by worker 0 to threads - 1; each worker does one range at a time. */
typedef void pinch_task(void *context, int worker, int first, int end);

/* threads >= 2, the caller's own counted. NULL: no memory, or the system gives no threads. */
pinch_workers *pinch_workers_create(int threads);
/* NULL is allowed. */
void pinch_workers_destroy(pinch_workers *workers);

/* Runs the task over items 0 to count - 1 in ranges of `grain`, and returns when all are done. workers NULL, or no more
 * items than a range: by the caller alone. */
void pinch_workers_run(pinch_workers *workers, pinch_task *task, void *context, int count, int grain);

#endif
