#ifndef PINCH_STUDY_REPORT_H
#define PINCH_STUDY_REPORT_H

#include "results.h"
#include "view/page.h"

#include <stdio.h>

typedef struct report_settings {
    const page_libraries *libraries;
    const char *command;  /* the start of a command that runs a trial again */
    const json_t *beside; /* as beside_document; NULL: none. Results are attached where it is given */
} report_settings;

/* Writes the results as a page for people: one HTML file that needs no network. It shows the success rate with Wilson's
 * intervals, over each varied quantity, which quantities predict success, the hardest directions, the slowest and the
 * unsolved trials with the commands that run them again, and, run again for it, chosen failures in the viewer. */
bool study_report(results *r, const study *s, const report_settings *settings, FILE *stream, results_error *error);

/* statistics.c */

/* Wilson's interval (1927) of a success rate: the rates from which `succeeded` of `count` are not farther than 1.96
 * standard deviations. It stays within 0..1, and is right for rates near its ends. 0 to 1 for a count of 0. */
void wilson_interval(size_t succeeded, size_t count, double *low, double *high);

/* The area under the ROC curve: how likely a random success has a larger value than a random failure, ties counting one
 * half. 0.5 predicts nothing, 1 and 0 predict everything. Values that are NaN are left out. NaN without a success or
 * without a failure, or when memory runs out. */
double area_under_roc(const double *values, const bool *success, size_t count);

/* The area's interval of 1.96 standard errors, after Hanley and McNeil (1982), within 0..1. Returns of how many values
 * it is. */
size_t area_interval(const double *values, const bool *success, size_t count, double area, double *low, double *high);

#endif
