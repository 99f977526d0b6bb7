/* C11's threads by those of POSIX, for ThreadSanitizer, which knows these alone: a thread that thrd_create starts crashes
 * under it. This folder goes before the system's in the include path. Only what Pinch uses is here. */
#ifndef PINCH_TEST_THREADS_H
#define PINCH_TEST_THREADS_H

#include <pthread.h>
#include <sched.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

typedef pthread_t thrd_t;
typedef pthread_mutex_t mtx_t;
typedef pthread_cond_t cnd_t;
typedef int (*thrd_start_t)(void *);

enum { thrd_success = 0, thrd_error = 2 };
enum { mtx_plain = 0 };

struct pinch_thread_start {
    thrd_start_t function;
    void *data;
};

static inline void *pinch_thread_run(void *start)
{
    struct pinch_thread_start s = *(struct pinch_thread_start *)start;
    free(start);
    return (void *)(intptr_t)s.function(s.data);
}

static inline int thrd_create(thrd_t *thread, thrd_start_t function, void *data)
{
    struct pinch_thread_start *start = malloc(sizeof *start);
    if (!start) return thrd_error;
    start->function = function;
    start->data = data;
    if (pthread_create(thread, NULL, pinch_thread_run, start) == 0) return thrd_success;
    free(start);
    return thrd_error;
}

static inline int thrd_join(thrd_t thread, int *result)
{
    void *end;
    if (pthread_join(thread, &end) != 0) return thrd_error;
    if (result) *result = (int)(intptr_t)end;
    return thrd_success;
}

static inline void thrd_yield(void)
{
    (void)sched_yield();
}

static inline int mtx_init(mtx_t *lock, int kind)
{
    (void)kind;
    return pthread_mutex_init(lock, NULL) == 0 ? thrd_success : thrd_error;
}

static inline int mtx_lock(mtx_t *lock)
{
    return pthread_mutex_lock(lock) == 0 ? thrd_success : thrd_error;
}

static inline int mtx_unlock(mtx_t *lock)
{
    return pthread_mutex_unlock(lock) == 0 ? thrd_success : thrd_error;
}

static inline void mtx_destroy(mtx_t *lock)
{
    (void)pthread_mutex_destroy(lock);
}

static inline int cnd_init(cnd_t *condition)
{
    return pthread_cond_init(condition, NULL) == 0 ? thrd_success : thrd_error;
}

static inline int cnd_wait(cnd_t *condition, mtx_t *lock)
{
    return pthread_cond_wait(condition, lock) == 0 ? thrd_success : thrd_error;
}

static inline int cnd_signal(cnd_t *condition)
{
    return pthread_cond_signal(condition) == 0 ? thrd_success : thrd_error;
}

static inline int cnd_broadcast(cnd_t *condition)
{
    return pthread_cond_broadcast(condition) == 0 ? thrd_success : thrd_error;
}

static inline void cnd_destroy(cnd_t *condition)
{
    (void)pthread_cond_destroy(condition);
}

typedef pthread_once_t once_flag;
#define ONCE_FLAG_INIT PTHREAD_ONCE_INIT

static inline void call_once(once_flag *flag, void (*function)(void))
{
    pthread_once(flag, function);
}

#endif
