/*
 * A crew of threads that are started for each loop, and take its items one by one.
 */
#ifndef PINCH_TEST_CREW_H
#define PINCH_TEST_CREW_H

#include "support/cmocka_all.h"

#include <pinch/problem.h>
#include <stdatomic.h>
#include <threads.h>

enum { CREW = 3 }; /* one more than the most threads that help the caller's */

typedef struct crew_call {
    pinch_loop_part *part;
    void *argument;
    atomic_int next;
    int count;
} crew_call;

static inline int crew_join_in(void *data)
{
    crew_call *c = data;
    for (int k; (k = atomic_fetch_add(&c->next, 1)) < c->count;) c->part(c->argument, k, k + 1);
    return 0;
}

/* parallel_for of a crew whose context is an int: how many threads help. */
static inline void crew_call_all(void *helpers, int count, int chunk, pinch_loop_part *part, void *argument)
{
    crew_call c = {.part = part, .argument = argument, .count = count};
    thrd_t thread[CREW];
    assert_true(chunk == 1 && count >= CREW && *(int *)helpers < CREW);
    for (int k = 0; k < *(int *)helpers; k++) assert_int_equal(thrd_create(&thread[k], crew_join_in, &c), thrd_success);
    crew_join_in(&c);
    for (int k = 0; k < *(int *)helpers; k++) thrd_join(thread[k], NULL);
}

#endif
