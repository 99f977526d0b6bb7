#ifndef PINCH_VIEW_CANVAS_H
#define PINCH_VIEW_CANVAS_H

#include <stdbool.h>
#include <stdio.h>

/* Lines and texts as an SVG or a PNG picture, with the same calls for both. x goes right and y down, in units of a
 * pixel of a screen. A PNG has CANVAS_SCALE pixels for each, and letters of straight strokes, so that no font is
 * needed. */

#define CANVAS_SCALE 1.5

typedef struct canvas canvas;

typedef struct canvas_pen {
    const char *colour; /* #rrggbb */
    double width;       /* > 0 */
    double dash, gap;   /* lengths; a dash of 0 is a solid line */
} canvas_pen;

typedef enum canvas_anchor { CANVAS_START = 0, CANVAS_MIDDLE, CANVAS_END } canvas_anchor;

typedef struct canvas_type {
    const char *colour; /* #rrggbb */
    double size;        /* height of the line; capitals have 0.7 of it */
    canvas_anchor anchor;
    bool upwards; /* turned to read from bottom to top */
    bool bold;
} canvas_type;

/* Both write to the stream; NULL when memory runs out. The ground is white. */
canvas *canvas_svg(FILE *stream, int width, int height, const char *title);
canvas *canvas_png(FILE *stream, int width, int height);
/* A line through the points. Its corners are round. */
void canvas_path(canvas *c, const double (*points)[2], int count, const canvas_pen *pen);
/* ASCII. What follows a ^ is raised. y is the base line. */
void canvas_text(canvas *c, double x, double y, const char *text, const canvas_type *type);
/* Writes what is left to write. Returns false when memory ran out; write errors stay in the stream's error flag. */
bool canvas_close(canvas *c);

#endif
