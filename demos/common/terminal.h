#ifndef PINCH_COMMON_TERMINAL_H
#define PINCH_COMMON_TERMINAL_H

#include <stdbool.h>
#include <stdio.h>

/* What people read on a terminal. Names come from files and command lines, and a terminal obeys the control characters
 * in them. So each byte of a control character, of one that turns the direction of the text, and of what is no UTF-8 is
 * written as \xNN, and all other characters as they are. */

/* Writes a text, which has no line of its own: a line feed in it is a control character, too. */
void terminal_text(const char *text, FILE *stream);
/* Is every character of a text written as it is? */
bool terminal_shows(const char *text);

/* Writes as fprintf does, and each text of a %s as terminal_text does. Width and precision of a %s count characters.
 * What stands in the format itself is written as it is. The conversions are those of integers (of type int, long, long
 * long and size_t), double, char and text. */
void terminal_print(FILE *stream, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
