#ifndef PINCH_COMPARE_REPORT_H
#define PINCH_COMPARE_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

/* page.c */

/* Writes a comparison's JSON document as a page for people: one HTML file that needs no network. */
void report_write(const json_t *document, FILE *stream);

/* html.c: texts, numbers and judgements in plain language. */

/* Writes a text as HTML and SVG show it: & < > " ' are escaped, control characters left out. */
void html_text(const char *text, FILE *stream);

/* Writes a number with three digits and powers of ten as people write them ("4.2e-5" becomes 4.2 x 10^-5); a dash for
 * NaN. */
void html_number(double value, FILE *stream);

/* The style class of the scene's run number k, which gives its colour and dashes. */
const char *html_run_class(size_t run);

typedef enum verdict { VERDICT_EXACT = 0, VERDICT_CLOSE, VERDICT_OFF, VERDICT_DROPPED, VERDICT_UNKNOWN } verdict;

/* exact: forces to 1e-9; close: to 1 %; off: worse; dropped; unknown: no step was sampled. */
verdict verdict_of(const json_t *run);
/* "exact", "close", ... */
const char *verdict_word(verdict v);

/* Writes one sentence on a run of the scene, as HTML. */
void verdict_write(const json_t *of_scene, const json_t *run, FILE *stream);

/* charts.c: line charts and bars as inline SVG, each a <figure>. */

enum { CHART_MOST_SERIES = 12 };

typedef struct chart_series {
    const char *run;     /* the style class, from html_run_class */
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

/* Writes a <figure>, which says so where there is no number to show. */
void chart_write(const chart *c, FILE *stream);
/* Writes its inside alone, which needs a clip path named `plot`. */
void chart_draw(const chart *c, FILE *stream);

/* The cost of a step with each run. */
void bars_cost(const json_t *of_scene, FILE *stream);
/* How many contacts of the sampled steps have a force error of which size. */
void bars_errors(const json_t *of_scene, FILE *stream);

/* picture.c */

/* Writes the scene from two sides with contact forces and friction cones, as two <figure>s. Writes nothing where no
 * step was drawn. */
void picture_write(const json_t *of_scene, FILE *stream);
/* Writes a small SVG file: the scene with contact forces and friction cones, and beside it how far the object turns
 * with Pinch and with the first of ODE's runs. It is readable on light and on dark pages. */
void picture_write_file(const json_t *of_scene, FILE *stream);

#endif
