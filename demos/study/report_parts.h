#ifndef PINCH_STUDY_REPORT_PARTS_H
#define PINCH_STUDY_REPORT_PARTS_H

#include "report.h"

/* The parts of the report. */

/* ---- report_quantities.c ---- */

enum { REPORT_COLUMNS = 256 };

typedef enum report_kind { REPORT_NUMBERS = 0, REPORT_TEXTS, REPORT_PARTS } report_kind; /* parts: lists, objects */

typedef struct report_column {
    char *name;
    bool is_input;
    report_kind kind; /* that of the value which has the last of them; parts that were recorded are not read */
    double *values;   /* NaN for null; but for numbers, the place of the value's text */
    json_t *texts;    /* each different text, with its place; NULL where there is none */
} report_column;

typedef struct report_trials {
    size_t count, room, column_count;
    report_column columns[REPORT_COLUMNS];
    json_t *kinds; /* of all quantities, by name */
    double *index;
    bool *success;
    bool failed; /* memory ran out */
} report_trials;

report_trials *report_trials_read(results *r, results_error *error); /* NULL after a failure */
void report_trials_free(report_trials *t);                           /* NULL is fine */

/* Draws the success rates over the quantities that are inputs, or over those that were recorded. Nothing is drawn of a
 * quantity with a single value; lists and objects that are not drawn are named. */
void report_quantities(const report_trials *t, bool inputs, FILE *stream);

/* What the verdict is made of. */
bool report_is_verdict(const char *name);

/* ---- report_films.c ---- */

/* Runs chosen failures again, and trials on which results beside these differ, writes their pictures, and returns what
 * the page plays (view/page/study.js). `command` is the start of a command. NULL after a failure. */
json_t *report_films(results *r, const study *s, const char *command, bool beside, FILE *stream, results_error *error);

#endif
