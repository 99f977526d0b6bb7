#ifndef PINCH_COMMON_UTF8_H
#define PINCH_COMMON_UTF8_H

#include <stdbool.h>

/* Names of files are bytes, and those of scenes and documents characters. */

/* The number of bytes of the character that a text begins with, and the character; 0 where it begins with none: at its
 * end, or with bytes that are no UTF-8. */
int utf8_read(const char *text, unsigned long *character);

/* Is all of a text UTF-8? */
bool utf8_is(const char *text);

/* A copy, in which the replacement character U+FFFD stands for each byte of what is no UTF-8; NULL when memory runs
 * out. The caller frees it. */
char *utf8_copy(const char *text);

#endif
