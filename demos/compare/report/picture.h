#ifndef PINCH_COMPARE_PICTURE_H
#define PINCH_COMPARE_PICTURE_H

#include <jansson.h>
#include <stdio.h>

/* The scene from two sides with contact forces and friction cones, as two <figure>s; nothing where no step was drawn.
 */
void picture_write(const json_t *of_scene, FILE *stream);

#endif
