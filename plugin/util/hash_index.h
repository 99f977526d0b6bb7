/*
 * A hash map from 64-bit keys to the places of items in a list, which have their keys themselves: the map keeps the
 * places alone. Grows, never shrinks; order plays no role.
 */
#ifndef PINCH_PLUGIN_ITEM_INDEX_H
#define PINCH_PLUGIN_ITEM_INDEX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct pinch_item_index {
    uint32_t *places; /* place + 1, 0: empty */
    size_t capacity, used;
} pinch_item_index;

/* Where the items of a list have their keys: 8 bytes each, a pointer as a rule. */
typedef struct pinch_item_keys {
    const void *items;
    size_t size, offset; /* bytes: of an item, of the key in it */
} pinch_item_keys;
#define PINCH_ITEM_KEYS(list, type, member) ((pinch_item_keys){(list).items, sizeof(type), offsetof(type, member)})

static inline uint64_t pinch_key_of_pointer(const void *pointer)
{
    return (uint64_t)(uintptr_t)pointer;
}

void pinch_item_index_free(pinch_item_index *index);
void pinch_item_index_clear(pinch_item_index *index);
static inline size_t pinch_item_index_bytes(const pinch_item_index *index)
{
    return index->capacity * sizeof *index->places;
}
/* The place of the item with `key`, -1: there is none. */
int pinch_item_index_get(const pinch_item_index *index, pinch_item_keys keys, uint64_t key);
/* False when memory ran out. No item has `key` yet; the one at `place` must before the index is used again. */
bool pinch_item_index_add(pinch_item_index *index, pinch_item_keys keys, uint64_t key, int place);

#endif
