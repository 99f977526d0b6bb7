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

/* Returns the slot of the item at `place`, which is there. */
static size_t slot_of(const pinch_item_index *index, pinch_item_keys keys, int place)
{
    size_t slot = first_slot(index, key_at(keys, (size_t)place));
    while (index->places[slot] != (uint32_t)place + 1) slot = next_slot(index, slot);
    return slot;
}

/* Returns how many slots `to` is behind `from`, around the end. */
static size_t slots_between(const pinch_item_index *index, size_t from, size_t to)
{
    return to >= from ? to - from : to + index->capacity - from;
}

void pinch_item_index_remove(pinch_item_index *index, pinch_item_keys keys, int place, int last)
{
    size_t hole = slot_of(index, keys, place);
    /* a search ends at an empty slot: what was put behind the hole for want of one before it moves up */
    for (size_t slot = next_slot(index, hole); index->places[slot] != 0; slot = next_slot(index, slot)) {
        size_t wanted = first_slot(index, key_at(keys, index->places[slot] - 1));
        if (slots_between(index, wanted, slot) < slots_between(index, hole, slot)) continue;
        index->places[hole] = index->places[slot];
        hole = slot;
    }
    index->places[hole] = 0;
    index->used--;
    if (place != last) index->places[slot_of(index, keys, last)] = (uint32_t)place + 1;
}

bool pinch_item_index_rebuild(pinch_item_index *index, pinch_item_keys keys, int count)
{
    const unsigned char *items = keys.items; /* NULL where there are none */
    pinch_item_index_clear(index);
    for (int place = 0; place < count; place++)
        if (!pinch_item_index_add(index, keys, items + (size_t)place * keys.size + keys.offset, place)) return false;
    return true;
}
