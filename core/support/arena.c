#include "support/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = PINCH_ARENA_ALIGNMENT, FIRST_BLOCK = 1 << 11 };

#ifdef PINCH_ARENA_APART /* for a test: each array gets a block of its own, whose ends are seen and which can fail alone */
enum { APART = true };
#else
enum { APART = false };
#endif

/* The blocks from `first` on, up to `last`, which stays. */
static void free_blocks(pinch_arena_block *first, const pinch_arena_block *last)
{
    while (first != last) {
        pinch_arena_block *next = first->next;
        free(first);
        first = next;
    }
}

static void free_spill(pinch_arena *arena)
{
    free_blocks(arena->spill, NULL);
    arena->spill = NULL;
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

static void note_peak(pinch_arena *arena)
{
    size_t now = arena->used + arena->spilled;
    arena->high_water = pinch_arena_high_water(arena);
    if (now > arena->peak) arena->peak = now;
}

pinch_arena_mark pinch_arena_here(const pinch_arena *arena)
{
    pinch_arena_mark mark = {.used = arena->used, .spilled = arena->spilled, .spill = arena->spill};
    if (mark.spill) mark.head = *mark.spill;
    return mark;
}

bool pinch_arena_is_at(const pinch_arena *arena, const pinch_arena_mark *mark)
{
    return arena->used == mark->used && arena->spilled == mark->spilled && arena->spill == mark->spill;
}

void *pinch_arena_rewind_but(pinch_arena *arena, const pinch_arena_mark *mark, const void *array, size_t bytes)
{
    pinch_arena_block *newer = arena->spill;
    note_peak(arena);
    arena->used = mark->used;
    arena->spilled = mark->spilled;
    arena->spill = mark->spill;
    if (mark->spill) *mark->spill = mark->head;
    void *place = bytes > 0 ? pinch_arena_get(arena, bytes) : NULL;
    if (place) memmove(place, array, bytes);
    free_blocks(newer, mark->spill); /* not one that the array has just gone to */
    return place;
}

void pinch_arena_rewind(pinch_arena *arena, const pinch_arena_mark *mark)
{
    (void)pinch_arena_rewind_but(arena, mark, NULL, 0);
}

size_t pinch_arena_held(const pinch_arena *arena)
{
    size_t sum = arena->size;
    for (const pinch_arena_block *block = arena->spill; block; block = block->next) sum += block->bytes;
    return sum;
}

static void replace_base(pinch_arena *arena, size_t size)
{
    free(arena->base);
    arena->base = malloc(size);
    arena->size = arena->base && !APART ? size : 0;
}

/* A little more than the most that was in use since it was last trimmed: an island that gains a few contacts goes on
 * without asking. */
static size_t wanted(const pinch_arena *arena)
{
    enum { PART = 64, LEAST = 1 << 9 };
    size_t more = arena->peak / PART, size = arena->peak + (more < LEAST ? LEAST : more);
    return size < FIRST_BLOCK ? FIRST_BLOCK : size;
}

void pinch_arena_reset(pinch_arena *arena)
{
    free_spill(arena);
    note_peak(arena);
    if (arena->peak > arena->size || !arena->base) replace_base(arena, wanted(arena));
    arena->used = 0;
    arena->spilled = 0;
    arena->failed = false;
}

void pinch_arena_trim(pinch_arena *arena, size_t least)
{
    pinch_arena_reset(arena);
    size_t size = wanted(arena);
    if (size < least) size = least;
    if (size < arena->size - arena->size / 4) replace_base(arena, size);
    arena->peak = 0;
}

/* A block for `bytes` at least in front of the spill. Returns false when memory runs out. */
static bool add_spill(pinch_arena *arena, size_t bytes)
{
    enum { HEAD = (sizeof(pinch_arena_block) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT, PART = 4, LEAST = 1 << 12 };
    size_t room = APART ? 0 : (arena->size + arena->spilled) / PART & ~(size_t)(ALIGNMENT - 1);
    if (room < LEAST && !APART) room = LEAST;
    if (room < bytes) room = bytes;
    if (bytes > SIZE_MAX - HEAD) return false;
    pinch_arena_block *block = malloc(HEAD + room);
    if (!block) return false;
    block->next = arena->spill;
    block->bytes = HEAD + room;
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
