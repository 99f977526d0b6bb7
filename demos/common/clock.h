#ifndef PINCH_DEMOS_CLOCK_H
#define PINCH_DEMOS_CLOCK_H

/* Seconds on a clock that only goes forward. */
double clock_seconds(void);

#endif
