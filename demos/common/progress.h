#ifndef PINCH_COMMON_PROGRESS_H
#define PINCH_COMMON_PROGRESS_H

#include <stdbool.h>

/* One line on a terminal that tells how far long work has come. It appears after a second and is renewed twice a
 * second; where standard error is no terminal, there is none. */
typedef struct progress {
    bool wanted, shown;
    double started, last; /* s, by clock_seconds */
    int done, parts;      /* of progress_part */
} progress;

enum { PROGRESS_EVERY_MS = 500 };

void progress_start(progress *p, bool wanted);
/* `done` of `all` steps are done, `time` of `duration` seconds are simulated. Costs next to nothing when called often.
 */
void progress_show(progress *p, long done, long all, double time, double duration);
/* Is it time for the line to be renewed? */
bool progress_is_due(progress *p);
/* Renews the line: what has been done, then the time so far and what is left of it, by the part (0 to 1) of the work
 * that is done. */
void progress_tell(progress *p, const char *what, double part);
/* Another one of `parts` parts of the work, which take about as long as each other, begins. */
void progress_part(progress *p, const char *what);
/* Takes the line away. */
void progress_end(progress *p);

#endif
