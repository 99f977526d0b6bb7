#ifndef PINCH_COMPARE_MOMENTS_H
#define PINCH_COMPARE_MOMENTS_H

#include "scenes/world/world.h"

/* Which steps of a run are looked at closely: evenly spaced ones, the first in which a finger's state changes, and
 * those in which the fingers' forces change most. */

typedef enum moment_reason { MOMENT_EVEN = 0, MOMENT_STATE, MOMENT_LOAD } moment_reason;

/* "even", "state change", "load change" */
const char *moment_reason_text(moment_reason reason);

typedef struct moment {
    long step; /* from 1 */
    moment_reason reason;
} moment;

typedef struct moment_watch {
    const world *w;
    long steps;
    double *change;             /* per step: sum over the fingers of the force's change, N */
    bool *turned;               /* per step: has a finger's state changed? */
    double *last;               /* per finger: its force in the step before */
    pinch_contact_state *state; /* per finger: likewise */
} moment_watch;

/* false: no memory. Free it in either case. */
bool moments_start(moment_watch *watch, const world *w, long steps);
void moments_after_step(moment_watch *watch);
/* At most `count` moments, in order of time, none twice; how many there are. */
int moments_choose(const moment_watch *watch, int count, moment *chosen);
void moments_free(moment_watch *watch);

#endif
