#include "util/list.h"

#include <stdlib.h>
#include <string.h>

bool pinch_list_reserve(void **items, int *room, int count, size_t item_size)
{
    enum { FEWEST = 4, LARGE = 1 << 14 /* bytes */ };
    if (count <= *room) return true;
    /* A small list grows by a quarter, as it is soon outgrown. A large one grows by a sixteenth: what it holds in vain
     * counts. */
    int part = (size_t)*room * item_size < LARGE ? 4 : 16, bigger = *room + *room / part;
    if (bigger < count) bigger = count;
    if (bigger < FEWEST) bigger = FEWEST;
    void *moved = realloc(*items, (size_t)bigger * item_size);
    if (!moved) return false;
    *items = moved;
    *room = bigger;
    return true;
}

static uint64_t key_at(pinch_item_keys keys, size_t place)
{
    uint64_t key;
    memcpy(&key, (const unsigned char *)keys.items + place * keys.size + keys.offset, sizeof key);
    return key;
}

/* All bits of the key move the upper bits of the product, which are taken as a fraction of the capacity. */
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

int pinch_item_index_get(const pinch_item_index *index, pinch_item_keys keys, const void *wanted)
{
    uint64_t key;
    if (index->used == 0) return -1;
    memcpy(&key, wanted, sizeof key);
    for (size_t slot = first_slot(index, key); index->places[slot] != 0; slot = next_slot(index, slot))
        if (key_at(keys, index->places[slot] - 1) == key) return (int)(index->places[slot] - 1);
    return -1;
}

/* Puts the place into the first empty slot from where the key belongs. */
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

bool pinch_item_index_add(pinch_item_index *index, pinch_item_keys keys, const void *added, int place)
{
    uint64_t key;
    memcpy(&key, added, sizeof key);
    /* A slot that is taken by another key costs a look at its item, which is elsewhere: half of them stay empty. */
    if (2 * (index->used + 1) > index->capacity && !grow(index, keys)) return false;
    put(index, key, (uint32_t)place + 1);
    return true;
}

bool pinch_item_index_rebuild(pinch_item_index *index, pinch_item_keys keys, int count)
{
    const unsigned char *items = keys.items; /* NULL where there are none */
    pinch_item_index_clear(index);
    for (int place = 0; place < count; place++)
        if (!pinch_item_index_add(index, keys, items + (size_t)place * keys.size + keys.offset, place)) return false;
    return true;
}
