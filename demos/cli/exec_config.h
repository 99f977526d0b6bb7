#ifndef PINCH_EXEC_CONFIG_H
#define PINCH_EXEC_CONFIG_H

#include "options.h"

#include "common/command_status.h"

#include <jansson.h>

/* Reads o->config, whose keys are options of the command; the command line goes before it. COMMAND_BAD_INPUT after one
 * message. The caller releases *document in either case, because texts of the options point into it. */
command_status exec_config_read(options *o, json_t **document);

#endif
