/*
 * Loops over the contacts or bodies of an island, which the threads of the caller's crew may share where there are
 * many. Items go in chunks that do not depend on the crew: what a chunk finds is put together in the order of chunks,
 * and comes out the same to the bit whoever did it. Islands with a chunk alone have sums in one piece.
 */
#ifndef PINCH_SUPPORT_LOOP_H
#define PINCH_SUPPORT_LOOP_H

#include <pinch/problem.h>

enum { PINCH_CHUNK = 256 };

static inline int pinch_chunk_count(int count)
{
    return (count + PINCH_CHUNK - 1) / PINCH_CHUNK;
}

/* Does items 0 to count - 1 in chunks; crew NULL: in the caller's thread, one after the other. */
static inline void pinch_loop(const pinch_crew *crew, int count, pinch_loop_part *part, void *argument)
{
    if (count <= PINCH_CHUNK) {
        part(argument, 0, count);
        return;
    }
    if (crew) {
        crew->parallel_for(crew->context, count, PINCH_CHUNK, part, argument);
        return;
    }
    for (int first = 0; first < count; first += PINCH_CHUNK)
        part(argument, first, count - first < PINCH_CHUNK ? count : first + PINCH_CHUNK);
}

/* The same for items that nothing is summed up of. Threads take fewer at a time, so that all end at about the same
 * time. */
static inline void pinch_each(const pinch_crew *crew, int count, pinch_loop_part *part, void *argument)
{
    enum { AT_A_TIME = 64 };
    if (crew && count > PINCH_CHUNK)
        crew->parallel_for(crew->context, count, AT_A_TIME, part, argument);
    else
        part(argument, 0, count);
}

#endif
