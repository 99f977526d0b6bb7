#include "islands/solver_pool.h"

#include <stdlib.h>
#include <string.h>

/* ---- the loops of one island ---- */

typedef struct shared_loop {
    int count, chunk;
    pinch_loop_part *part;
    void *argument;
} shared_loop;

static void do_chunks(void *context, int worker, int first, int end)
{
    const shared_loop *loop = context;
    (void)worker;
    for (int k = first; k < end; k++) {
        int from = k * loop->chunk, left = loop->count - from;
        loop->part(loop->argument, from, from + (left < loop->chunk ? left : loop->chunk));
    }
}

static void share_loop(void *workers, int count, int chunk, pinch_loop_part *part, void *argument)
{
    shared_loop loop = {count, chunk, part, argument};
    pinch_workers_run(workers, do_chunks, &loop, (count + chunk - 1) / chunk, 1);
}

/* ---- the pool ---- */

bool pinch_solver_pool_create(pinch_solver_pool *pool, int threads)
{
    memset(pool, 0, sizeof *pool);
    pool->thread = calloc((size_t)threads, sizeof *pool->thread);
    if (!pool->thread) return false;
    for (; pool->threads < threads; pool->threads++)
        if (pinch_step_solver_create(&pool->thread[pool->threads].solver) != PINCH_OK) return false;
    if (threads > 1) pool->workers = pinch_workers_create(threads);
    pool->crew = (pinch_crew){share_loop, pool->workers};
    return threads == 1 || pool->workers;
}

void pinch_problem_buffers_free(pinch_problem_buffers *buffers)
{
    free(buffers->bodies.items);
    free(buffers->contacts.items);
    free(buffers->rows.items);
}

static void rise_free(pinch_rise *rise)
{
    free(rise->order.items);
    free(rise->bodies.items);
    free(rise->pairs.items);
    free(rise->parts.items);
}

void pinch_solver_pool_destroy(pinch_solver_pool *pool)
{
    pinch_workers_destroy(pool->workers);
    for (int k = 0; k < pool->threads; k++) {
        pinch_step_solver_destroy(pool->thread[k].solver);
        pinch_problem_buffers_free(&pool->thread[k].buffers);
        pinch_problem_buffers_free(&pool->thread[k].before);
        pinch_problem_buffers_free(&pool->thread[k].first);
        rise_free(&pool->thread[k].rise);
        pinch_step_memory_destroy(pool->thread[k].memory_before);
    }
    free(pool->thread);
    pinch_problem_buffers_free(&pool->kept);
}

static size_t buffer_bytes(const pinch_problem_buffers *buffers)
{
    return PINCH_LIST_BYTES(buffers->bodies) + PINCH_LIST_BYTES(buffers->contacts) + PINCH_LIST_BYTES(buffers->rows);
}

static size_t rise_bytes(const pinch_rise *rise)
{
    return PINCH_LIST_BYTES(rise->order) + PINCH_LIST_BYTES(rise->bodies) + PINCH_LIST_BYTES(rise->pairs) +
           PINCH_LIST_BYTES(rise->parts);
}

static size_t thread_bytes(const pinch_solver_pool *pool)
{
    size_t sum = 0;
    for (int k = 0; k < pool->threads; k++)
        sum += pinch_step_solver_memory(pool->thread[k].solver, NULL) + buffer_bytes(&pool->thread[k].buffers) +
               buffer_bytes(&pool->thread[k].before) + buffer_bytes(&pool->thread[k].first) +
               rise_bytes(&pool->thread[k].rise);
    return sum;
}

size_t pinch_solver_pool_bytes(const pinch_solver_pool *pool)
{
    return thread_bytes(pool) + buffer_bytes(&pool->kept);
}

#define RESERVE_AND_COUNT(list, n)                                                                                     \
    ((n) > (list).count ? (void)((list).count = (n)) : (void)0, PINCH_RESERVE(list, (n) + 1))

bool pinch_reserve_problem(pinch_problem_buffers *buffers, int bodies, int contacts, int rows)
{
    return RESERVE_AND_COUNT(buffers->bodies, bodies) && RESERVE_AND_COUNT(buffers->contacts, contacts) &&
           RESERVE_AND_COUNT(buffers->rows, rows);
}

bool pinch_copy_problem(const pinch_problem *problem, pinch_problem_buffers *to, pinch_problem *copy)
{
    if (!pinch_reserve_problem(to, problem->body_count, problem->contact_count, problem->row_count)) return false;
    *copy = *problem;
    copy->bodies = to->bodies.items;
    copy->contacts = to->contacts.items;
    copy->rows = to->rows.items;
    pinch_copy_items(problem, copy);
    return true;
}

void pinch_copy_items(const pinch_problem *from, pinch_problem *to)
{
    memcpy(to->bodies, from->bodies, sizeof *to->bodies * (size_t)from->body_count);
    memcpy(to->contacts, from->contacts, sizeof *to->contacts * (size_t)from->contact_count);
    memcpy(to->rows, from->rows, sizeof *to->rows * (size_t)from->row_count);
}

bool pinch_reserve_rise(pinch_rise *rise, int bodies, int pairs, int parts)
{
    return RESERVE_AND_COUNT(rise->order, bodies) && RESERVE_AND_COUNT(rise->bodies, bodies) &&
           RESERVE_AND_COUNT(rise->pairs, pairs) && RESERVE_AND_COUNT(rise->parts, parts);
}

/*
 * ---- giving memory back ----
 *
 * A step may need far more memory than those that follow: the first step of a heap, whose linear systems are not known
 * yet, or the last before everything rests. What a span of steps has not needed is given back. Where it was missed
 * after that, the next span is twice as long, so that a scene that goes to and fro soon asks for nothing any more.
 * Small amounts are not worth it.
 */

enum { FIRST_SPAN = 8, LONGEST_SPAN = 1 << 20, LITTLE = 1 << 16 /* bytes of a thread's solver, and of each list */ };

/* Trims a list to the most that was needed, where that is much less. Its content is not needed. */
static void trim(void **items, int *room, int *most, size_t item_size)
{
    int needed = *most, least = (int)(LITTLE / item_size);
    *most = 0;
    if (needed < least) needed = least;
    if (needed >= *room - *room / 4) return;
    free(*items);
    *items = NULL;
    *room = 0;
    (void)pinch_list_reserve(items, room, needed, item_size); /* or when it is needed */
}

#define TRIM(list) trim((void **)&(list).items, &(list).room, &(list).count, sizeof *(list).items)

static void trim_buffers(pinch_problem_buffers *buffers)
{
    TRIM(buffers->bodies);
    TRIM(buffers->contacts);
    TRIM(buffers->rows);
}

void pinch_trim_solver_pool(pinch_solver_pool *pool, long step)
{
    if (pool->trim_span == 0) pool->trim_span = FIRST_SPAN;
    if (step < pool->last_trim + pool->trim_span) return;
    size_t before = thread_bytes(pool);
    if (pool->missed_above > 0 && before > pool->missed_above) {
        if (pool->trim_span < LONGEST_SPAN) pool->trim_span *= 2;
        pool->missed_above = 0;
    }
    for (int k = 0; k < pool->threads; k++) {
        pinch_rise *rise = &pool->thread[k].rise;
        pinch_step_solver_trim(pool->thread[k].solver, LITTLE);
        trim_buffers(&pool->thread[k].buffers);
        trim_buffers(&pool->thread[k].first);
        TRIM(rise->order);
        TRIM(rise->bodies);
        TRIM(rise->pairs);
        TRIM(rise->parts);
    }
    size_t after = thread_bytes(pool);
    if (after < before) pool->missed_above = after + (before - after) / 2;
    pool->last_trim = step;
}
