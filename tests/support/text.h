#ifndef PINCH_TEST_TEXT_H
#define PINCH_TEST_TEXT_H

#include "support/cmocka_all.h"

#include <stdarg.h>
#include <stdio.h>

/* A text that is written piece by piece, for example a scene. It is empty when all is zero. */
typedef struct text {
    char bytes[16384];
    size_t used;
} text;

static inline void add(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline void add(text *t, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(t->bytes + t->used, sizeof t->bytes - t->used, format, arguments);
    va_end(arguments);
    assert_true(n > 0 && t->used + (size_t)n < sizeof t->bytes);
    t->used += (size_t)n;
}

#endif
