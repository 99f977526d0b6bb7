#ifndef PINCH_COMPARE_CHART_H
#define PINCH_COMPARE_CHART_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/* Line charts as inline SVG. */

enum { CHART_MOST_SERIES = 12 };

typedef struct chart_series {
    const char *run;     /* class: html_run_class; NULL ends nothing, it is left out */
    const json_t *x, *y; /* lists of the same length; null points break the line */
    bool sets_range;     /* does the vertical range have to show all of it? */
} chart_series;

typedef struct chart {
    const char *title;            /* the caption, plain text */
    const char *x_label, *y_unit; /* "m" is shown as um or mm where that is shorter */
    double least; /* of y_unit: a linear plot shows no less than this, so that rounding is not blown up */
    bool log_x, log_y;
    double floor; /* log_y: what is smaller counts as this */
    int count;
    chart_series series[CHART_MOST_SERIES];
} chart;

/* A <figure>. Charts without a number say so. */
void chart_write(const chart *c, FILE *stream);

#endif
