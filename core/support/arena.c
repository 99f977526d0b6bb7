#include "support/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = PINCH_ARENA_ALIGNMENT, FIRST_BLOCK = 1 << 11 };

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

size_t pinch_arena_high_water(const pinch_arena *arena)
{
    size_t now = arena->used + arena->spilled;
    return now > arena->high_water ? now : arena->high_water;
}

void pinch_arena_reset(pinch_arena *arena)
{
    free_spill(arena);
    arena->high_water = pinch_arena_high_water(arena);
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

/* A block for `bytes` at least in front of the spill; false: no memory. */
static bool add_spill(pinch_arena *arena, size_t bytes)
{
    enum { HEAD = (sizeof(pinch_arena_block) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT, PART = 4, LEAST = 1 << 12 };
    size_t room = (arena->size + arena->spilled) / PART & ~(size_t)(ALIGNMENT - 1);
    if (room < LEAST) room = LEAST;
    if (room < bytes) room = bytes;
    if (bytes > SIZE_MAX - HEAD) return false;
    pinch_arena_block *block = malloc(HEAD + room);
    if (!block) return false;
    block->next = arena->spill;
    block->left = room;
    block->place = (unsigned char *)block + HEAD;
    arena->spill = block;
    return true;
}

void *pinch_arena_spill(pinch_arena *arena, size_t bytes)
{
    if (!(arena->spill && bytes <= arena->spill->left) && !add_spill(arena, bytes)) {
        arena->failed = true;
        return NULL;
    }
    void *place = arena->spill->place;
    arena->spill->place += bytes;
    arena->spill->left -= bytes;
    arena->spilled += bytes;
    return place;
}
