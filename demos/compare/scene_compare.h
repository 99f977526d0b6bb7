#ifndef PINCH_COMPARE_SCENE_COMPARE_H
#define PINCH_COMPARE_SCENE_COMPARE_H

#include "cli/command.h"
#include "settings.h"

#include <jansson.h>

/*
 * Compares one scene; ODE must have been initialized. COMMAND_DONE or, where Pinch's answers were not verified or
 * differ from the exact ones, COMMAND_FAILED; messages go to standard error. *document is NULL only where there is no
 * result.
 */
command_status scene_compare(const scene *s, const compare_settings *settings, json_t **document);

#endif
