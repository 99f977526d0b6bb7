/* A hash map from 64-bit keys (pointers, pairs of numbers) to indices. Grows, never shrinks; order plays no role. */
#ifndef PINCH_PLUGIN_KEY_MAP_H
#define PINCH_PLUGIN_KEY_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct pinch_key_map {
    uint64_t *keys; /* 0: empty; keys are never 0 */
    int *values;
    size_t capacity; /* a power of two, or 0 */
    size_t used;
} pinch_key_map;

void pinch_key_map_free(pinch_key_map *map);
void pinch_key_map_clear(pinch_key_map *map);
/* The value of `key`, -1 where there is none. */
int pinch_key_map_get(const pinch_key_map *map, uint64_t key);
/* False when memory ran out. `key` must not be 0 and not be there yet. */
bool pinch_key_map_add(pinch_key_map *map, uint64_t key, int value);

#endif
