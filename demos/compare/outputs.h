#ifndef PINCH_COMPARE_OUTPUTS_H
#define PINCH_COMPARE_OUTPUTS_H

#include "cli/command.h"

#include <jansson.h>

/* The files of `pinch compare`, each written as a whole or not at all. Messages on standard error. */

/* --csv, --report and, where `complete` (every scene has its result), --save. */
command_status outputs_write(const options *o, const json_t *document, bool complete);

/* --check: names what moved, adds it to the document as "check", COMMAND_FAILED where something did. */
command_status outputs_check(const options *o, const json_t *baseline, json_t *document);

#endif
