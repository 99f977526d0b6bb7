#ifndef PINCH_OPTION_VALUES_H
#define PINCH_OPTION_VALUES_H

#include <stdbool.h>
#include <stddef.h>

/* What the value of an option may be, and the type of its field. */
typedef enum value_kind {
    VALUE_FLAG = 0,
    VALUE_POSITIVE,     /* double > 0 */
    VALUE_NOT_NEGATIVE, /* double >= 0 */
    VALUE_INTEGER,      /* int, minimum..maximum */
    VALUE_SEED,         /* uint64_t */
    VALUE_TEXT,         /* a text that is not empty */
    VALUE_INPUT,        /* the name of a file that is read */
    VALUE_FOLDER,       /* the name of a folder */
    VALUE_OUTPUT,       /* the name of a file that is written, not - */
    VALUE_STREAM,       /* the name of a file that is written, or - */
    VALUE_SOLVER,
    VALUE_FORMULATION,
    VALUE_NAME,   /* the place in the row's list of names, as an enum */
    VALUE_COUNTS, /* whole numbers from 1 to 1000000, separated by commas */
    VALUE_RATIO,  /* double > 0 and <= 10 */
    VALUE_EVENTS  /* names of events, separated by commas, as a set of bits */
} value_kind;

/* A row of the table of options. */
typedef struct option_row {
    const char *name; /* without the dashes */
    value_kind kind;
    size_t offset; /* of its field in `options` */
    const char *value;
    const char *help;
    int minimum, maximum;     /* VALUE_INTEGER only */
    const char *const *names; /* VALUE_NAME only; NULL is the last */
} option_row;

/* Reads `text` into the option's field, which has the kind's type. Returns false where the text is no such value. */
bool option_store(const option_row *row, const char *text, void *field);

/* Returns the i-th of the names that a value can be, or a part of it; NULL after the last, and where it is no name. */
const char *option_word(const option_row *row, int i);

/* Writes for a message what the value should have been. */
void option_expected(const option_row *row, char *text, size_t size);

#endif
