/* A map from 64-bit keys to numbers, for a caller whose items do not hold their keys themselves. */
#ifndef PINCH_PLUGIN_KEY_MAP_H
#define PINCH_PLUGIN_KEY_MAP_H

#include "util/list.h"

#include <stdlib.h>
#include <string.h>

typedef struct pinch_key_entry {
    uint64_t key;
    int value;
} pinch_key_entry;

typedef struct pinch_key_map {
    PINCH_LIST(pinch_key_entry) entries;
    pinch_item_index index;
} pinch_key_map;

static inline void pinch_key_map_free(pinch_key_map *map)
{
    free(map->entries.items);
    pinch_item_index_free(&map->index);
    memset(map, 0, sizeof *map);
}

static inline void pinch_key_map_clear(pinch_key_map *map)
{
    map->entries.count = 0;
    pinch_item_index_clear(&map->index);
}

/* Returns the value of `key`, -1 where there is none. */
static inline int pinch_key_map_get(const pinch_key_map *map, uint64_t key)
{
    int place = pinch_item_index_get(&map->index, PINCH_ITEM_KEYS(map->entries, pinch_key_entry, key), &key);
    return place < 0 ? -1 : map->entries.items[place].value;
}

/* Adds a key that is not there yet. Returns false when memory runs out. */
static inline bool pinch_key_map_add(pinch_key_map *map, uint64_t key, int value)
{
    int place = map->entries.count;
    if (!PINCH_RESERVE(map->entries, place + 1) ||
        !pinch_item_index_add(&map->index, PINCH_ITEM_KEYS(map->entries, pinch_key_entry, key), &key, place))
        return false;
    map->entries.items[map->entries.count++] = (pinch_key_entry){key, value};
    return true;
}

/* Gives a key a value, whether it is there or not. Returns false when memory runs out. */
static inline bool pinch_key_map_set(pinch_key_map *map, uint64_t key, int value)
{
    int place = pinch_item_index_get(&map->index, PINCH_ITEM_KEYS(map->entries, pinch_key_entry, key), &key);
    if (place < 0) return pinch_key_map_add(map, key, value);
    map->entries.items[place].value = value;
    return true;
}

#endif
