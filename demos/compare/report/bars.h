#ifndef PINCH_COMPARE_BARS_H
#define PINCH_COMPARE_BARS_H

#include <jansson.h>
#include <stdio.h>

/* Bars as inline SVG, a row for each run: <figure>s. */

/* What a step costs. */
void bars_cost(const json_t *of_scene, FILE *stream);
/* How many contacts of the sampled steps have a force error of which size. */
void bars_errors(const json_t *of_scene, FILE *stream);

#endif
