/*
 * Work whose items depend on earlier ones, done by as many threads of a crew as come. Each takes the next item that
 * nobody has begun, and waits within it for the earlier ones that it depends on. These have been begun, by threads that
 * wait for still earlier ones at most, so that all of them come to an end; where only one thread comes it never waits.
 */
#ifndef PINCH_SUPPORT_AWAIT_H
#define PINCH_SUPPORT_AWAIT_H

#include <pinch/problem.h>
#include <stdatomic.h>
#include <threads.h>

/* Has `part` called so many times that each thread of the crew is in one of them; each call goes on until no item is
 * left. */
static inline void pinch_all_at_once(const pinch_crew *crew, pinch_loop_part *part, void *argument)
{
    enum { CALLS = 64 };
    crew->parallel_for(crew->context, CALLS, 1, part, argument);
}

/* Tells without waiting whether *progress is that far. */
static inline bool pinch_has_said(const atomic_int *progress, int least)
{
    return atomic_load_explicit(progress, memory_order_acquire) >= least;
}

/* Waits until *progress is `least` or more. What its thread has written before it said so can then be read. The core of
 * a thread that is waited for may be taken, so that long waits give way. */
static inline void pinch_await(const atomic_int *progress, int least)
{
    enum { LOOKS = 2000 };
    for (int k = 0; !pinch_has_said(progress, least); k++)
        if (k >= LOOKS) thrd_yield();
}

static inline void pinch_say(atomic_int *progress, int value)
{
    atomic_store_explicit(progress, value, memory_order_release);
}

#endif
