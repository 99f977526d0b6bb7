#ifndef PINCH_COMPARE_REPORT_H
#define PINCH_COMPARE_REPORT_H

#include <jansson.h>
#include <stdio.h>

/* A comparison's JSON document as a page for people: one HTML file that needs no network. */
void report_write(const json_t *document, FILE *stream);

#endif
