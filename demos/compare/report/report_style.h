#ifndef PINCH_COMPARE_REPORT_STYLE_H
#define PINCH_COMPARE_REPORT_STYLE_H

#include <stdio.h>

/* The page's style sheet: light and dark, screen and paper; runs are told apart by colour and by dashes. */
void report_style(FILE *stream);

#endif
