#include "util/block_pool.h"

#include <stdlib.h>
#include <string.h>

/* A chunk or a block given back begins with the address of the next one. */
static void *next_of(const void *block)
{
    void *next;
    memcpy(&next, block, sizeof next);
    return next;
}

static void chain(void *block, void **list)
{
    memcpy(block, list, sizeof *list);
    *list = block;
}

static int class_of(int items)
{
    int class = 0;
    while (1 << class < items) class ++;
    return class;
}

/* Each chunk is an eighth of all before it, so that little is held in vain and large scenes ask seldom. */
static bool add_chunk(pinch_block_pool *pool, size_t least)
{
    enum { HEAD = 16, FEWEST = 16 };
    size_t items = FEWEST + pool->bytes / 8 / pool->item_size;
    if (items < least) items = least;
    size_t bytes = HEAD + items * pool->item_size;
    unsigned char *chunk = malloc(bytes);
    if (!chunk) return false;
    chain(chunk, &pool->chunks);
    pool->next = chunk + HEAD;
    pool->end = chunk + bytes;
    pool->bytes += bytes;
    return true;
}

void *pinch_block_take(pinch_block_pool *pool, int items, int *room)
{
    int class = class_of(items);
    *room = 1 << class;
    void *block = pool->given_back[class];
    if (block) {
        pool->given_back[class] = next_of(block);
        return block;
    }
    size_t bytes = (size_t)*room * pool->item_size;
    if ((size_t)(pool->end - pool->next) < bytes) {
        for (; pool->end > pool->next; pool->next += pool->item_size) /* the rest, as blocks of one */
            chain(pool->next, &pool->given_back[0]);
        if (!add_chunk(pool, (size_t)*room)) {
            *room = 0;
            return NULL;
        }
    }
    block = pool->next;
    pool->next += bytes;
    return block;
}

void pinch_block_give(pinch_block_pool *pool, void *block, int room)
{
    if (block) chain(block, &pool->given_back[class_of(room)]);
}

void pinch_block_pool_free(pinch_block_pool *pool)
{
    while (pool->chunks) {
        void *chunk = pool->chunks;
        pool->chunks = next_of(chunk);
        free(chunk);
    }
}
