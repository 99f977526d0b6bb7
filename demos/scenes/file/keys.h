#ifndef PINCH_SCENE_KEYS_H
#define PINCH_SCENE_KEYS_H

#include <stdbool.h>
#include <stddef.h>

/* Which keys the objects of a scene file may and must have: what the reader checks, and the schema is tested against.
 */

typedef struct scene_key {
    const char *name;
    bool required;
} scene_key;

typedef struct scene_kind {
    const char *name; /* the definition's name in assets/schema/pinch-scene-1.json */
    size_t count;
    const scene_key *keys;
} scene_kind;

size_t scene_kind_count(void);
const scene_kind *scene_kind_at(size_t index);
const scene_kind *scene_kind_named(const char *name); /* NULL when there is none */

#endif
