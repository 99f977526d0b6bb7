#ifndef PINCH_COMMON_CSV_H
#define PINCH_COMMON_CSV_H

#include <stdio.h>

/* Writes a text field, followed by `suffix` in the same field. The field is quoted as RFC 4180 demands where the text
 * needs it. */
void csv_text(const char *text, const char *suffix, FILE *stream);

#endif
