#include "support/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 16, FIRST_BLOCK = 1 << 14 };

static void free_spill(pinch_arena *arena)
{
    while (arena->spill) {
        pinch_arena_block *next = arena->spill->next;
        free(arena->spill);
        arena->spill = next;
    }
}

void pinch_arena_init(pinch_arena *arena)
{
    memset(arena, 0, sizeof *arena);
}

void pinch_arena_free(pinch_arena *arena)
{
    free_spill(arena);
    free(arena->base);
    pinch_arena_init(arena);
}

void pinch_arena_reset(pinch_arena *arena)
{
    free_spill(arena);
    if (arena->high_water > arena->size || !arena->base) {
        size_t size = arena->high_water + arena->high_water / 16;
        if (size < FIRST_BLOCK) size = FIRST_BLOCK;
        free(arena->base);
        arena->base = malloc(size);
        arena->size = arena->base ? size : 0;
    }
    arena->used = 0;
    arena->spilled = 0;
    arena->failed = false;
}

void *pinch_arena_get(pinch_arena *arena, size_t bytes)
{
    bytes = (bytes + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    if (bytes <= arena->size - arena->used) {
        void *place = arena->base + arena->used;
        arena->used += bytes;
        if (arena->used + arena->spilled > arena->high_water) arena->high_water = arena->used + arena->spilled;
        return place;
    }
    pinch_arena_block *block = malloc(ALIGNMENT + bytes);
    if (!block) {
        arena->failed = true;
        return NULL;
    }
    block->next = arena->spill;
    arena->spill = block;
    arena->spilled += bytes;
    if (arena->used + arena->spilled > arena->high_water) arena->high_water = arena->used + arena->spilled;
    return (unsigned char *)block + ALIGNMENT;
}
