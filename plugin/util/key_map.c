#include "util/key_map.h"

#include <stdlib.h>
#include <string.h>

static size_t slot_of(const pinch_key_map *map, uint64_t key)
{
    uint64_t h = key * 0x9E3779B97F4A7C15u; /* 2^64 over the golden ratio: spreads consecutive keys */
    size_t slot = (size_t)(h ^ (h >> 29)) & (map->capacity - 1);
    while (map->keys[slot] != 0 && map->keys[slot] != key) slot = (slot + 1) & (map->capacity - 1);
    return slot;
}

void pinch_key_map_free(pinch_key_map *map)
{
    free(map->keys);
    free(map->values);
    memset(map, 0, sizeof *map);
}

void pinch_key_map_clear(pinch_key_map *map)
{
    if (map->used) memset(map->keys, 0, map->capacity * sizeof *map->keys);
    map->used = 0;
}

int pinch_key_map_get(const pinch_key_map *map, uint64_t key)
{
    if (map->capacity == 0) return -1;
    size_t slot = slot_of(map, key);
    return map->keys[slot] == key ? map->values[slot] : -1;
}

static bool grow(pinch_key_map *map)
{
    pinch_key_map bigger = {.capacity = map->capacity ? 2 * map->capacity : 64};
    bigger.keys = calloc(bigger.capacity, sizeof *bigger.keys);
    bigger.values = malloc(bigger.capacity * sizeof *bigger.values);
    if (!bigger.keys || !bigger.values) {
        pinch_key_map_free(&bigger);
        return false;
    }
    for (size_t i = 0; i < map->capacity; i++) {
        if (map->keys[i] == 0) continue;
        size_t slot = slot_of(&bigger, map->keys[i]);
        bigger.keys[slot] = map->keys[i];
        bigger.values[slot] = map->values[i];
    }
    bigger.used = map->used;
    pinch_key_map_free(map);
    *map = bigger;
    return true;
}

bool pinch_key_map_add(pinch_key_map *map, uint64_t key, int value)
{
    if (2 * (map->used + 1) > map->capacity && !grow(map)) return false;
    size_t slot = slot_of(map, key);
    map->keys[slot] = key;
    map->values[slot] = value;
    map->used++;
    return true;
}
