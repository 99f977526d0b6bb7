#ifndef PINCH_COMPARE_REPORT_H
#define PINCH_COMPARE_REPORT_H

#include "view/page.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/* page.c */

/* Writes a comparison's JSON document, with films, as a page for people: one HTML file that needs no network. */
void report_write(const json_t *document, const page_libraries *libraries, FILE *stream);

/* charts.c: line charts as inline SVG. */

enum { CHART_MOST_SERIES = 12 };

typedef struct chart_series {
    const char *run;     /* the style class, from picture_run_class */
    const json_t *x, *y; /* lists of the same length; a null breaks the line */
    bool sets_range;     /* must the vertical range show all of it? */
} chart_series;

typedef struct chart {
    const char *title;            /* the caption, plain text */
    const char *x_label, *y_unit; /* "m" is shown as um or mm where that is shorter */
    double least; /* of y_unit: the smallest range of a linear plot, so that rounding is not magnified */
    bool log_x, log_y;
    double floor; /* log_y: smaller values count as this */
    int count;
    chart_series series[CHART_MOST_SERIES];
} chart;

/* Writes the chart into an SVG picture, which needs a clip path named `plot`. Writes nothing where there is no number
 * to show. */
void chart_draw(const chart *c, FILE *stream);

/* picture.c */

/* The style class of the scene's run number k, which gives its colour and dashes. */
const char *picture_run_class(size_t run);
/* Writes the scene as a small SVG element, from the side that shows most of the forces. Writes nothing where no step
 * was drawn. */
void picture_write_thumbnail(const json_t *of_scene, FILE *stream);
/* Writes a small SVG file: the scene with contact forces and friction cones, and beside it how far the object turns
 * with Pinch and with the first of ODE's runs. It is readable on light and on dark pages. */
void picture_write_file(const json_t *of_scene, FILE *stream);

#endif
