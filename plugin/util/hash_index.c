#include "util/hash_index.h"

#include <stdlib.h>
#include <string.h>

static uint64_t key_at(pinch_item_keys keys, size_t place)
{
    uint64_t key;
    memcpy(&key, (const unsigned char *)keys.items + place * keys.size + keys.offset, sizeof key);
    return key;
}

/* The upper bits of the product, which all bits of the key move, as a part of the capacity. */
static size_t first_slot(const pinch_item_index *index, uint64_t key)
{
    uint64_t spread = key * 0x9E3779B97F4A7C15u; /* 2^64 over the golden ratio */
    return (size_t)((spread >> 32) * index->capacity >> 32);
}

static size_t next_slot(const pinch_item_index *index, size_t slot)
{
    return slot + 1 < index->capacity ? slot + 1 : 0;
}

void pinch_item_index_free(pinch_item_index *index)
{
    free(index->places);
    memset(index, 0, sizeof *index);
}

void pinch_item_index_clear(pinch_item_index *index)
{
    if (index->used) memset(index->places, 0, index->capacity * sizeof *index->places);
    index->used = 0;
}

int pinch_item_index_get(const pinch_item_index *index, pinch_item_keys keys, uint64_t key)
{
    if (index->used == 0) return -1;
    for (size_t slot = first_slot(index, key); index->places[slot] != 0; slot = next_slot(index, slot))
        if (key_at(keys, index->places[slot] - 1) == key) return (int)(index->places[slot] - 1);
    return -1;
}

/* To the first empty slot from where the key belongs. */
static void put(pinch_item_index *index, uint64_t key, uint32_t place_and_1)
{
    size_t slot = first_slot(index, key);
    while (index->places[slot] != 0) slot = next_slot(index, slot);
    index->places[slot] = place_and_1;
    index->used++;
}

static bool grow(pinch_item_index *index, pinch_item_keys keys)
{
    enum { FEWEST = 16 };
    pinch_item_index bigger = {.capacity = index->capacity ? index->capacity + index->capacity / 2 : FEWEST};
    bigger.places = calloc(bigger.capacity, sizeof *bigger.places);
    if (!bigger.places) return false;
    for (size_t i = 0; i < index->capacity; i++)
        if (index->places[i] != 0) put(&bigger, key_at(keys, index->places[i] - 1), index->places[i]);
    free(index->places);
    *index = bigger;
    return true;
}

bool pinch_item_index_add(pinch_item_index *index, pinch_item_keys keys, uint64_t key, int place)
{
    if (4 * (index->used + 1) > 3 * index->capacity && !grow(index, keys)) return false;
    put(index, key, (uint32_t)place + 1);
    return true;
}
