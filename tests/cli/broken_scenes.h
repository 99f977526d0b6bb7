#ifndef PINCH_TEST_BROKEN_SCENES_H
#define PINCH_TEST_BROKEN_SCENES_H

#include <stddef.h>

/* Ways to break a good scene file, and what must be said about each. */
typedef struct broken_scene {
    const char *kind;
    const char *base;        /* a good scene */
    const char *find;        /* first occurrence in it is replaced ... */
    const char *replacement; /* ... by this */
    const char *line_of; /* the message must name the line on which this stands in the broken text (first occurrence) */
    const char *path;    /* the JSON path that must be named */
    const char *expectation; /* what must be said to have been expected */
} broken_scene;

extern const char good_scene[];
extern const char good_plane[];
extern const broken_scene broken_scenes[];
extern const size_t broken_scene_count;

#endif
