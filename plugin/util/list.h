/*
 * Growing lists, and the hash index that finds the items of a list by a key.
 *
 * An index maps 64-bit keys, pointers as a rule, to the places of items in a list. The items hold their keys
 * themselves, so the index stores the places alone. Lists and indices grow and never shrink. The order of an index
 * plays no role for results.
 */
#ifndef PINCH_UTIL_LIST_H
#define PINCH_UTIL_LIST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A growing array: its items, how many are in use, and how many there is room for. Everything starts as 0. */
#define PINCH_LIST(type)                                                                                               \
    struct {                                                                                                           \
        type *items;                                                                                                   \
        int count, room;                                                                                               \
    }

/* Makes room for `count` items in all. Returns false when memory runs out. */
bool pinch_list_reserve(void **items, int *room, int count, size_t item_size);
#define PINCH_RESERVE(list, n) pinch_list_reserve((void **)&(list).items, &(list).room, (n), sizeof *(list).items)
#define PINCH_LIST_BYTES(list) ((size_t)(list).room * sizeof *(list).items)

/* A run of neighbours in a list. */
typedef struct pinch_range {
    int first, count;
} pinch_range;

typedef struct pinch_item_index {
    uint32_t *places; /* place + 1; 0 is an empty slot */
    size_t capacity, used;
} pinch_item_index;

/* Where the items of a list hold their keys of 8 bytes. */
typedef struct pinch_item_keys {
    const void *items;
    size_t size, offset; /* bytes: of an item, of the key in it */
} pinch_item_keys;
#define PINCH_ITEM_KEYS(list, type, member) ((pinch_item_keys){(list).items, sizeof(type), offsetof(type, member)})

static inline size_t pinch_item_index_bytes(const pinch_item_index *index)
{
    return index->capacity * sizeof *index->places;
}

void pinch_item_index_free(pinch_item_index *index);
void pinch_item_index_clear(pinch_item_index *index);
/* Returns the place of the item with the key of 8 bytes at `key`, -1 where there is none. */
int pinch_item_index_get(const pinch_item_index *index, pinch_item_keys keys, const void *key);
/* As pinch_item_index_get, but looks first at the place *hint, where the caller found the item before or expects it,
 * and keeps there where it is. Any number is a hint. */
static inline int pinch_item_index_find(const pinch_item_index *index, pinch_item_keys keys, const void *key, int *hint)
{
    size_t place = (size_t)*hint;
    if (place < index->used &&
        memcmp((const unsigned char *)keys.items + place * keys.size + keys.offset, key, sizeof(uint64_t)) == 0)
        return *hint;
    int found = pinch_item_index_get(index, keys, key);
    if (found >= 0) *hint = found;
    return found;
}
/* Adds a key that no item has yet. The item at `place` must hold it before the index is used again. Returns false when
 * memory runs out. */
bool pinch_item_index_add(pinch_item_index *index, pinch_item_keys keys, const void *key, int place);
/* Takes out the item at `place`, which the last item, at `last`, is about to replace there. Both still hold their keys;
 * `place` may be `last`. */
void pinch_item_index_remove(pinch_item_index *index, pinch_item_keys keys, int place, int last);
/* Indexes the first `count` items anew after some have moved or gone. It needs no memory where the index has held as
 * many before; otherwise it returns false when memory runs out. */
bool pinch_item_index_rebuild(pinch_item_index *index, pinch_item_keys keys, int count);

#endif
