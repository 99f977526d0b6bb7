#ifndef PINCH_COMPARE_HTML_H
#define PINCH_COMPARE_HTML_H

#include <stdio.h>

/* Text as HTML and SVG show it: & < > " ' escaped, control characters left out. */
void html_text(const char *text, FILE *stream);

/* A number with three digits and powers of ten as people write them ("4.2e-5" becomes 4.2 x 10^-5); a dash for NaN. */
void html_number(double value, FILE *stream);

/* The class of run number k of a scene: its colour and dashes. */
const char *html_run_class(size_t run);

#endif
