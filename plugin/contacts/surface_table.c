/*
 * The surface parameters in use, each kept once: most contacts of a scene share theirs with many others. What nobody
 * has any more goes when the list has grown by half.
 */
#include "plugin.h"

#include <string.h>

/* A key of its content; 0 is none. */
static uint64_t key_of(const pinch_surface *surface)
{
    uint64_t key = 0, word;
    _Static_assert(sizeof *surface % sizeof word == 0, "a surface is made of words");
    for (size_t at = 0; at < sizeof *surface; at += sizeof word) {
        memcpy(&word, (const unsigned char *)surface + at, sizeof word);
        key = (key ^ word) * 0x9E3779B97F4A7C15u; /* 2^64 over the golden ratio */
        key ^= key >> 32;
    }
    return key ? key : 1;
}

static bool same(const pinch_ode *p, int index, const pinch_surface *surface)
{
    return memcmp(&p->surfaces.items[index], surface, sizeof *surface) == 0;
}

/* Its index, -1: not in the list; *key: the one it has, or is to have. */
static int look_up(const pinch_ode *p, const pinch_surface *surface, uint64_t *key)
{
    int index;
    for (*key = key_of(surface); (index = pinch_key_map_get(&p->surface_index, *key)) >= 0;
         *key = *key + 1 ? *key + 1 : 1)
        if (same(p, index, surface)) return index;
    return -1;
}

/* Calls visit for every place where the index of a surface is kept. */
static void for_indices(pinch_ode *p, void (*visit)(int *index, int *place), int *place)
{
    int taken = p->taken.count > p->taken_before ? p->taken.count : p->taken_before;
    for (int i = 0; i < taken; i++)
        if (p->taken.items[i].surface >= 0) visit(&p->taken.items[i].surface, place);
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_manifold *manifold = &p->pairs.items[i].manifold;
        for (int k = 0; k < manifold->count; k++)
            if (manifold->point[k].own) visit(&manifold->point[k].own->surface, place);
    }
}

static void mark(int *index, int *place)
{
    place[*index] = 1;
}

static void follow(int *index, int *place)
{
    *index = place[*index];
}

/* False: no memory. */
static bool sweep(pinch_ode *p)
{
    int kept = 0, count = p->surfaces.count;
    if (!PINCH_RESERVE(p->order, count + 1)) return false;
    int *place = p->order.items;
    memset(place, 0, sizeof *place * (size_t)count);
    for_indices(p, mark, place);
    for (int i = 0; i < count; i++) {
        if (!place[i]) continue;
        p->surfaces.items[kept] = p->surfaces.items[i];
        place[i] = kept++;
    }
    for_indices(p, follow, place);
    p->surfaces.count = 0;
    pinch_key_map_clear(&p->surface_index);
    for (; p->surfaces.count < kept; p->surfaces.count++) { /* cannot fail: it has been larger */
        uint64_t key;
        (void)look_up(p, &p->surfaces.items[p->surfaces.count], &key);
        (void)pinch_key_map_add(&p->surface_index, key, p->surfaces.count);
    }
    p->last_surface = -1;
    return true;
}

int pinch_surface_index(pinch_ode *p, const pinch_surface *surface, int guess)
{
    enum { FEWEST = 16 };
    uint64_t key;
    if (guess >= 0 && same(p, guess, surface)) return guess;
    if (p->last_surface >= 0 && p->last_surface < p->surfaces.count && same(p, p->last_surface, surface))
        return p->last_surface;
    int index = look_up(p, surface, &key);
    if (index < 0) {
        if (p->surfaces.count >= FEWEST && p->surfaces.count >= p->surfaces_swept + p->surfaces_swept / 2) {
            if (!sweep(p)) return -1;
            p->surfaces_swept = p->surfaces.count > FEWEST ? p->surfaces.count : FEWEST;
            (void)look_up(p, surface, &key); /* others may have left its key */
        }
        index = p->surfaces.count;
        if (!PINCH_RESERVE(p->surfaces, index + 1) || !pinch_key_map_add(&p->surface_index, key, index)) return -1;
        p->surfaces.items[p->surfaces.count++] = *surface;
    }
    return p->last_surface = index;
}
