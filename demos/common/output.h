#ifndef PINCH_COMMON_OUTPUT_H
#define PINCH_COMMON_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* How every command writes JSON documents and CSV files. */

/* A JSON number; null where the value is not finite. */
json_t *json_number(double value);
/* A JSON string of a text that comes from the system, as the name of a file does: each byte of what is no UTF-8 becomes
 * the replacement character U+FFFD. NULL when memory runs out, or for NULL. */
json_t *json_text(const char *text);
/* A JSON list of numbers, each as json_number makes it. */
json_t *json_numbers(const double *values, size_t count);

/* Prints a document with indentation, lists of plain values on one line, and a line feed at the end. A number gets as
 * many of 17 significant digits as it takes to read the same double back. Write errors stay in the stream's error flag.
 */
void json_print(json_t *document, FILE *stream);

/* Prints the document and releases it. Returns false for NULL, which means that memory ran out. */
bool json_print_new(json_t *document, FILE *stream);

/* Appends a text to a JSON list, which is the context of a callback. */
void json_append_text(void *list, const char *text);

/* The text of a number as json_print writes it. */
void json_number_text(double value, char text[32]);

/* The text of a number in a table for people, by a format for one double: "-" where there is none, "unlimited" where it
 * is infinite. The width of the format counts for these, too. */
const char *number_for_people(const char *format, double value, char text[48]);

/* Writes a text field, followed by `suffix` in the same field. The field is quoted as RFC 4180 demands where the text
 * needs it. */
void csv_text(const char *text, const char *suffix, FILE *stream);
/* Writes numbers, each with a comma in front. */
void csv_numbers(FILE *stream, const double *values, int count);

#endif
