#ifndef PINCH_COMMON_PROGRESS_H
#define PINCH_COMMON_PROGRESS_H

#include <stdbool.h>

/* One line on a terminal that tells how far long work has come. It appears after a second and is renewed twice a
 * second; where standard error is no terminal, there is none. */
typedef struct progress {
    bool wanted, shown;
    double started, last; /* s, by clock_seconds */
} progress;

void progress_start(progress *p, bool wanted);
/* `done` of `all` steps are done, `time` of `duration` seconds are simulated. Costs next to nothing when called often.
 */
void progress_show(progress *p, long done, long all, double time, double duration);
/* Takes the line away. */
void progress_end(progress *p);

#endif
