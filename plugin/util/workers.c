#include "util/workers.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <threads.h>

/* How often to look for work before going to sleep. Loops of a step follow each other within microseconds, as a rule,
 * and what one thread does between them takes some hundreds; who has gone to sleep is late by a hundred. After a step
 * the next one may follow soon: to linger takes some two hundred microseconds. */
enum { LOOKS = 300, YIELDS = 2000, LINGER = 500 };

/* A worker's share of the items. Each counter has a cache line of its own. */
typedef struct share {
    atomic_int next;
    int end;
    char apart[64 - 2 * sizeof(int)];
} share;

struct pinch_workers {
    int threads; /* the caller's own counted */
    mtx_t lock;
    cnd_t begins, ends;
    atomic_uint round;  /* counts the loops */
    atomic_int numbers; /* given out to workers as they start */
    atomic_int running; /* workers that have begun with this round and are not through, the caller not counted */
    atomic_bool called; /* rounds are about to begin, or follow each other: it pays to stay awake */
    bool open, stop;    /* under the lock: workers may begin with the round; the pool ends */
    /* of the round */
    pinch_task *task;
    void *context;
    int grain;
    share *shares;   /* threads */
    thrd_t thread[]; /* threads - 1 */
};

/* Equal shares of items that follow each other: in every loop over the same items a worker gets those that it had in
 * the last one, as long as no other takes them, and with them what its caches hold. */
static void share_out(pinch_workers *w, int count)
{
    for (int k = 0; k < w->threads; k++) {
        atomic_store(&w->shares[k].next, (int)((long long)count * k / w->threads));
        w->shares[k].end = (int)((long long)count * (k + 1) / w->threads);
    }
}

/* Does the worker's own share, and then what others have not begun of theirs. */
static void work(pinch_workers *w, int worker)
{
    for (int k = 0; k < w->threads; k++) {
        share *s = &w->shares[(worker + k) % w->threads];
        for (int first; (first = atomic_fetch_add(&s->next, w->grain)) < s->end;)
            w->task(w->context, worker, first, first + w->grain < s->end ? first + w->grain : s->end);
    }
}

/* Looks out for a round after `seen` for as long as one may come soon. */
static void look_out(pinch_workers *w, unsigned seen)
{
    int dismissed = 0;
    for (int k = 0; k < LOOKS + YIELDS && dismissed < LINGER && atomic_load(&w->round) == seen; k++) {
        bool called = atomic_load(&w->called);
        dismissed = called ? 0 : dismissed + 1;
        if (k >= LOOKS || !called) thrd_yield();
    }
}

/* Waits for a round after `seen`, and begins with it. Returns false when the pool ends. */
static bool begin_round(pinch_workers *w, unsigned *seen)
{
    for (;;) {
        look_out(w, *seen);
        mtx_lock(&w->lock);
        if (atomic_load(&w->round) == *seen && !w->stop) cnd_wait(&w->begins, &w->lock);
        bool stop = w->stop, begins = !stop && w->open && atomic_load(&w->round) != *seen;
        *seen = atomic_load(&w->round);
        atomic_fetch_add(&w->running, begins);
        mtx_unlock(&w->lock);
        if (begins || stop) return begins;
    }
}

static int run_worker(void *data)
{
    pinch_workers *w = data;
    int number = 1 + atomic_fetch_add(&w->numbers, 1); /* the caller is worker 0 */
    for (unsigned seen = 0; begin_round(w, &seen);) {
        work(w, number);
        mtx_lock(&w->lock);
        if (atomic_fetch_sub(&w->running, 1) == 1) cnd_signal(&w->ends);
        mtx_unlock(&w->lock);
    }
    return 0;
}

pinch_workers *pinch_workers_create(int threads)
{
    pinch_workers *w = calloc(1, sizeof *w + (size_t)(threads - 1) * sizeof(thrd_t));
    if (!w) return NULL;
    w->shares = calloc((size_t)threads, sizeof *w->shares);
    if (!w->shares) {
        free(w);
        return NULL;
    }
    mtx_init(&w->lock, mtx_plain);
    cnd_init(&w->begins);
    cnd_init(&w->ends);
    for (w->threads = 1; w->threads < threads; w->threads++)
        if (thrd_create(&w->thread[w->threads - 1], run_worker, w) != thrd_success) {
            pinch_workers_destroy(w);
            return NULL;
        }
    return w;
}

void pinch_workers_destroy(pinch_workers *w)
{
    if (!w) return;
    mtx_lock(&w->lock);
    w->stop = true;
    cnd_broadcast(&w->begins);
    mtx_unlock(&w->lock);
    for (int k = 0; k < w->threads - 1; k++) thrd_join(w->thread[k], NULL);
    cnd_destroy(&w->begins);
    cnd_destroy(&w->ends);
    mtx_destroy(&w->lock);
    free(w->shares);
    free(w);
}

void pinch_workers_call(pinch_workers *w)
{
    if (!w || atomic_load(&w->called)) return;
    mtx_lock(&w->lock);
    atomic_store(&w->called, true);
    cnd_broadcast(&w->begins);
    mtx_unlock(&w->lock);
}

void pinch_workers_dismiss(pinch_workers *w)
{
    if (w) atomic_store(&w->called, false);
}

/* Waits for the workers that have begun with the round. Who has not begun by now, because its core is taken or it has
 * not woken up yet, has nothing left to do. */
static void end_round(pinch_workers *w)
{
    mtx_lock(&w->lock);
    w->open = false;
    mtx_unlock(&w->lock);
    for (int k = 0; k < LOOKS + YIELDS && atomic_load(&w->running) > 0; k++)
        if (k >= LOOKS) thrd_yield();
    mtx_lock(&w->lock);
    while (atomic_load(&w->running) > 0) cnd_wait(&w->ends, &w->lock);
    mtx_unlock(&w->lock);
}

void pinch_workers_run(pinch_workers *w, pinch_task *task, void *context, int count, int grain)
{
    if (!w || count <= grain) {
        if (count > 0) task(context, 0, 0, count);
        return;
    }
    mtx_lock(&w->lock);
    w->task = task;
    w->context = context;
    w->grain = grain;
    share_out(w, count);
    w->open = true;
    atomic_fetch_add(&w->round, 1);
    cnd_broadcast(&w->begins);
    mtx_unlock(&w->lock);
    work(w, 0);
    end_round(w);
}
