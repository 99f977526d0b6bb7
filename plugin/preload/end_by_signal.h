/* What is still to be done where SIGTERM or SIGINT ends the program. */
#ifndef PINCH_PRELOAD_END_BY_SIGNAL_H
#define PINCH_PRELOAD_END_BY_SIGNAL_H

/*
 * Has `last` called before one of the two signals ends the process, in the handler of a signal. Only signals that have
 * their default action now are watched. A program that sets a handler later sets it in this one's place.
 */
void pinch_end_by_signal(void (*last)(void));

#endif
