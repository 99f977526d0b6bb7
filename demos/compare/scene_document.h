#ifndef PINCH_COMPARE_SCENE_DOCUMENT_H
#define PINCH_COMPARE_SCENE_DOCUMENT_H

#include "contender.h"
#include "sample.h"

#include <jansson.h>

/* The finished comparison of one scene. */
typedef struct scene_comparison {
    const scene *s;
    const compare_settings *settings;
    int contender_count;
    contender *contenders;
    int sample_count;
    sample *samples;
} scene_comparison;

/* As an entry of the JSON document's "scenes"; assets/schema/pinch-compare-1.json describes it. NULL: no memory. */
json_t *scene_comparison_document(const scene_comparison *c);

#endif
