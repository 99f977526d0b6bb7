/*
 * The scratch memory of a solve: bump allocation, released all at once. What does not fit spills into further blocks,
 * of a quarter of what there is at least, and the next reset replaces everything by one block of the high-water size:
 * after warm-up nothing is allocated, and one that grows asks for memory a few times, not for every array.
 */
#ifndef PINCH_SUPPORT_ARENA_H
#define PINCH_SUPPORT_ARENA_H

#include <stdbool.h>
#include <stddef.h>

typedef struct pinch_arena_block {
    struct pinch_arena_block *next;
    size_t bytes; /* all of it, this head included */
    size_t left;  /* at its end that nobody has */
    unsigned char *place;
} pinch_arena_block;

typedef struct pinch_arena {
    unsigned char *base;
    size_t size, used;
    pinch_arena_block *spill;
    size_t spilled;    /* bytes asked for beyond `size` since the last reset */
    size_t high_water; /* bytes, up to the last reset or rewind, */
    size_t peak;       /* and of that since it was last trimmed */
    bool failed;       /* an allocation since the last reset found no memory */
} pinch_arena;

void pinch_arena_init(pinch_arena *arena);
void pinch_arena_free(pinch_arena *arena);
void pinch_arena_reset(pinch_arena *arena);
size_t pinch_arena_high_water(const pinch_arena *arena); /* the most that was in use at a time, bytes */
size_t pinch_arena_held(const pinch_arena *arena);       /* bytes that it has of the system */
/* A reset, after which it holds no more than the most since the last call wanted, and `least` bytes, unless that is
 * three quarters of what it held. */
void pinch_arena_trim(pinch_arena *arena, size_t least);
void *pinch_arena_spill(pinch_arena *arena, size_t bytes);

/* A place in an arena, to come back to: what is allocated after it is scratch within the scratch. */
typedef struct pinch_arena_mark {
    size_t used, spilled;
    pinch_arena_block *spill, head; /* the newest block of the spill, and what it was like */
} pinch_arena_mark;

pinch_arena_mark pinch_arena_here(const pinch_arena *arena);
/* Tells whether nothing has been allocated since, or all of it has been released. */
bool pinch_arena_is_at(const pinch_arena *arena, const pinch_arena_mark *mark);
/* Releases what has been allocated since. */
void pinch_arena_rewind(pinch_arena *arena, const pinch_arena_mark *mark);
/* Does the same but keeps one array of `bytes`, which moves to the front of what was released. Returns its new place,
 * NULL as pinch_arena_get. */
void *pinch_arena_rewind_but(pinch_arena *arena, const pinch_arena_mark *mark, const void *array, size_t bytes);

enum { PINCH_ARENA_ALIGNMENT = 16 };

/* Aligned, not cleared; NULL (and `failed`) when the system has no memory. */
static inline void *pinch_arena_get(pinch_arena *arena, size_t bytes)
{
    bytes = (bytes + PINCH_ARENA_ALIGNMENT - 1) & ~(size_t)(PINCH_ARENA_ALIGNMENT - 1);
    if (bytes > arena->size - arena->used) return pinch_arena_spill(arena, bytes);
    void *place = arena->base + arena->used;
    arena->used += bytes;
    return place;
}

#define PINCH_ARENA_ARRAY(arena, type, count) ((type *)pinch_arena_get((arena), (size_t)(count) * sizeof(type)))

#endif
