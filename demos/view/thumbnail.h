#ifndef PINCH_VIEW_THUMBNAIL_H
#define PINCH_VIEW_THUMBNAIL_H

#include "film.h"

/* A frame of a film as a small drawing: what stands around the object's place, seen from above at a slant, with the
 * forces on it. Shapes are drawn as their outlines, the farther ones first. The classes `object`, `finger`,
 * `environment` and `arrow` give the colours. */
void thumbnail_write(const film *f, size_t frame, FILE *stream);

/* The last frame in which something pressed on the first object; the last of all where that is so from the start. */
size_t thumbnail_last_touch(const film *f);

#endif
