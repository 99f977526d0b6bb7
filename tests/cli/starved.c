/* A library that is preloaded into `pinch`: the allocation whose number is in PINCH_TEST_FAIL_ALLOCATION fails. The
 * numbers start from 1, and those of the dynamic loader count as well. */
#define _GNU_SOURCE

#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>

/* What glibc calls its own functions; unlike dlsym, they can be called before anything is set up. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);

static atomic_long count;

/* Reads the number on every call, because the first calls come before the environment can be kept. */
static int fails(void)
{
    const char *text = getenv("PINCH_TEST_FAIL_ALLOCATION");
    if (!text || atomic_fetch_add(&count, 1) + 1 != atol(text)) return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size)
{
    return fails() ? NULL : __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
    return fails() ? NULL : __libc_calloc(number, size);
}

void *realloc(void *memory, size_t size)
{
    return fails() ? NULL : __libc_realloc(memory, size);
}
