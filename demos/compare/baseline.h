#ifndef PINCH_COMPARE_BASELINE_H
#define PINCH_COMPARE_BASELINE_H

#include "common/command_status.h"

#include <jansson.h>

/* A baseline holds the metrics that later ones are compared with: {"format": "pinch-baseline/1", "made", "settings",
 * "tolerances": {"pinch": {METRIC: {"absolute", "relative"}}, "ode": {...}}, "scenes": {NAME: {"steps", "step_s",
 * "tolerances", "runs": {RUN: {METRIC: value}}}}}. NAME is the scene's file name without its folder. A metric has moved
 * when it differs by more than absolute + relative |value|. A scene's own tolerances go before the common ones, and a
 * metric without a tolerance is not checked. */

/* Makes the baseline of a finished comparison with the default tolerances. `made` is the command line that made it.
 * NULL when memory runs out. */
json_t *baseline_document(const json_t *document, const char *made);

/* Reads a baseline, checks it, and checks that it has all the scenes. COMMAND_BAD_INPUT after one message. */
command_status baseline_load(const char *path, char *const *scenes, int count, json_t **baseline);

/* The name of a file without its folder. */
const char *baseline_name(const char *path);

/* What has moved, as a list of {"scene", "run", "metric", "from", "to", "by", "limit", "unit"}. Values that do not
 * exist are null. NULL when memory runs out. */
json_t *baseline_check(const json_t *baseline, const json_t *document);

#endif
