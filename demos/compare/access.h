#ifndef PINCH_COMPARE_ACCESS_H
#define PINCH_COMPARE_ACCESS_H

#include "metrics.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

/* Short ways into the JSON document of a comparison. */

/* NAN where there is no number. Yes is 1 and no is 0. */
static inline double access_value(const json_t *value)
{
    if (json_is_boolean(value)) return json_is_true(value);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static inline double access_number(const json_t *object, const char *key)
{
    return access_value(json_object_get(object, key));
}

/* The text of a key; "" where there is none. */
static inline const char *access_text(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static inline double access_metric(const json_t *run, metric m)
{
    return access_number(json_object_get(run, "metrics"), metric_about(m)->key);
}

/* The scene's run of this name; NULL where there is none. */
static inline const json_t *access_run(const json_t *of_scene, const char *name)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    for (size_t k = 0; k < json_array_size(runs); k++)
        if (strcmp(access_text(json_array_get(runs, k), "run"), name) == 0) return json_array_get(runs, k);
    return NULL;
}

#endif
