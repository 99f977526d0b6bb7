#ifndef PINCH_COMPARE_DRAWING_H
#define PINCH_COMPARE_DRAWING_H

#include "sample.h"

#include <jansson.h>

/*
 * The scene at the start of a sampled step as outlines, seen from two sides: {"time", "views": [{"axes": [2],
 * "centre": [2], "size", "outlines": [{"kind": "object|finger|environment", "name", "points": [[..2]..]}]}]}, in m.
 * NULL: no memory.
 */
json_t *drawing_document(const world *w, const sample *s);

#endif
