#ifndef PINCH_STUDY_REPORT_PARTS_H
#define PINCH_STUDY_REPORT_PARTS_H

#include "report.h"

/* The parts of the report. */

/* ---- report_quantities.c ---- */

enum { REPORT_COLUMNS = 256, REPORT_LABELS = 16 };

typedef struct report_column {
    char *name;
    bool is_input;
    double *values; /* NaN for null; a text counts as the place of its label */
    size_t label_count;
    char *labels[REPORT_LABELS];
} report_column;

typedef struct report_trials {
    size_t count, room, column_count;
    report_column columns[REPORT_COLUMNS];
    double *index;
    bool *success;
    bool failed; /* memory ran out */
} report_trials;

report_trials *report_trials_read(results *r, results_error *error); /* NULL after a failure */
void report_trials_free(report_trials *t);                           /* NULL is fine */

/* Draws the success rates over a quantity; nothing where it has a single value. */
void report_quantity(const report_trials *t, const report_column *c, FILE *stream);

/* ---- report_films.c ---- */

/* Runs chosen failures again, and trials on which results beside these differ, writes their pictures, and returns what
 * the page plays (view/page/study.js). `command` is the start of a command. NULL after a failure. */
json_t *report_films(results *r, const study *s, const char *command, bool beside, FILE *stream, results_error *error);

#endif
