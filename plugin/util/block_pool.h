/* A pool of blocks of 1, 2, 4, ... or 64 items of one size, which are taken and given back while a scene runs. What is
 * given back is taken again, so that a scene that has been running asks the system for nothing. Blocks do not move. */
#ifndef PINCH_UTIL_BLOCK_POOL_H
#define PINCH_UTIL_BLOCK_POOL_H

#include <stdbool.h>
#include <stddef.h>

enum { PINCH_BLOCK_SIZES = 7, PINCH_BLOCK_MOST = 1 << (PINCH_BLOCK_SIZES - 1) };

typedef struct pinch_block_pool {
    size_t item_size; /* bytes, a multiple of 8; set once, everything else starts as 0 */
    void *chunks;
    unsigned char *next, *end; /* what is left of the newest chunk */
    void *given_back[PINCH_BLOCK_SIZES];
    size_t bytes; /* in all chunks */
} pinch_block_pool;

/* Returns a block with room for 1 <= items <= PINCH_BLOCK_MOST, for *room of them in fact. It is not cleared. Returns
 * NULL when memory runs out. */
void *pinch_block_take(pinch_block_pool *pool, int items, int *room);
/* room is that of the block when it was taken. A block of NULL is allowed. */
void pinch_block_give(pinch_block_pool *pool, void *block, int room);
void pinch_block_pool_free(pinch_block_pool *pool);

#endif
