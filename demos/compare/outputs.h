#ifndef PINCH_COMPARE_OUTPUTS_H
#define PINCH_COMPARE_OUTPUTS_H

#include "command.h"

#include <jansson.h>

/* The files of `pinch compare`: --csv, --save, --report, and the baseline of --check. */

/* Before anything runs: reads the baseline (NULL without --check); COMMAND_BAD_INPUT after a message. */
command_status outputs_check_first(const options *o, json_t **baseline);

/* Writes the files that were asked for, each whole or not at all. complete: does every scene have its result? A
 * baseline is not saved otherwise. */
command_status outputs_write(const options *o, const json_t *document, bool complete);

#endif
