#ifndef PINCH_TEST_HAND_CASE_H
#define PINCH_TEST_HAND_CASE_H

#include "hands/hand.h"

/* Hands from texts. */

/* The hand that the text is; fails with the reader's message where it is none. Free it. `name` is the file's. */
hand *hand_from_text(const char *folder, const char *name, const char *text);

/* What is wrong with a text: the error starts with the file, the line of `line_of` in the text, and contains `says`. */
typedef struct hand_fault {
    const char *text;
    const char *line_of; /* NULL: no line */
    const char *says;
} hand_fault;
void hand_faults_are_named(const char *name, const hand_fault *faults, size_t count);

/* Lists of numbers, to `tolerance`. */
void assert_numbers(const double *a, const double *b, int count, double tolerance);
/* The same orientation: q or -q. */
void assert_orientation(const double a[4], const double b[4], double tolerance);

#endif
