#ifndef PINCH_SCENE_LOCATE_H
#define PINCH_SCENE_LOCATE_H

#include <stdbool.h>
#include <stddef.h>

/* Where values stand in a JSON text. Jansson keeps no positions of values, and for a syntax error it knows the place
 * but not the key. */

/* One step of a JSON path: a key of an object, or an index of an array, where key is NULL. */
typedef struct scene_step {
    const char *key;
    size_t index;
} scene_step;

/* The line (from 1) on which the value at the path begins; 1 when it is not there. The text must be valid JSON. */
int scene_locate_line(const char *text, size_t length, const scene_step *path, size_t depth);

/* The path of the value or key that byte `offset` belongs to. The text need only be valid up to there. */
void scene_locate_path(const char *text, size_t length, size_t offset, char *path, size_t size);

#endif
