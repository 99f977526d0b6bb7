/*
 * Asking for memory before it is needed.
 *
 * Bodies, joints and pairs of many islands do not fit into the caches, and what a step does with an island at rest is
 * little beside waiting for them, one after the other. Nor do those of a heap, whose pairs lie in the order in which
 * they came. Asked for ahead they come together. Results do not depend on it.
 */
#ifndef PINCH_UTIL_PREFETCH_H
#define PINCH_UTIL_PREFETCH_H

#include <stddef.h>

enum { PINCH_CACHE_LINE = 64 };

/* Asks for memory that is to be read soon. It need not be there. */
static inline void pinch_prefetch(const void *start, size_t bytes)
{
    enum { INTO_L2 = 2 };
    __asm__ volatile(""); /* otherwise compilers take a function that only calls this one for one that does nothing */
    for (size_t at = 0; at < bytes; at += PINCH_CACHE_LINE) __builtin_prefetch((const char *)start + at, 0, INTO_L2);
    __builtin_prefetch((const char *)start + bytes - 1, 0, INTO_L2); /* `start` lies anywhere in its line */
}

/* Asks for memory that is to be read and written soon: what another thread has it in its cache gives it up at once. */
static inline void pinch_prefetch_to_write(const void *start, size_t bytes)
{
    enum { INTO_L2 = 2 };
    __asm__ volatile("");
    for (size_t at = 0; at < bytes; at += PINCH_CACHE_LINE) __builtin_prefetch((const char *)start + at, 1, INTO_L2);
    __builtin_prefetch((const char *)start + bytes - 1, 1, INTO_L2);
}

#endif
