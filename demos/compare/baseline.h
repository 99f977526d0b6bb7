#ifndef PINCH_COMPARE_BASELINE_H
#define PINCH_COMPARE_BASELINE_H

#include "common/command_status.h"

#include <jansson.h>

/*
 * Metrics to hold later ones against: {"format": "pinch-baseline/1", "made", "settings", "tolerances": {"pinch":
 * {METRIC:
 * {"absolute", "relative"}}, "ode": {...}}, "scenes": {NAME: {"steps", "step_s", "tolerances", "runs": {RUN: {METRIC:
 * value}}}}}. NAME is the scene's file without its folder. A metric has moved when it differs by more than absolute +
 * relative |value|; a scene's own tolerances go before the common ones; what has no tolerance is not checked.
 */

/* The baseline of a finished comparison, with the default tolerances. made: how. NULL: no memory. */
json_t *baseline_document(const json_t *document, const char *made);

/* Reads and checks a file, and that it has all the scenes. COMMAND_BAD_INPUT after one message. */
command_status baseline_load(const char *path, char *const *scenes, int count, json_t **baseline);

/* The file's name without its folder. */
const char *baseline_name(const char *path);

/*
 * What moved, as a list of {"scene", "run", "metric", "from", "to", "by", "limit", "unit"}; null for values that are
 * not there. NULL: no memory.
 */
json_t *baseline_check(const json_t *baseline, const json_t *document);

#endif
