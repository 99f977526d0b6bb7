#ifndef PINCH_OPTION_VALUES_H
#define PINCH_OPTION_VALUES_H

#include "options.h"

/* What the value of an option may be, and reading it. */

typedef enum value_kind {
    VALUE_FLAG = 0,
    VALUE_POSITIVE,     /* double > 0 */
    VALUE_NOT_NEGATIVE, /* double >= 0 */
    VALUE_INTEGER,      /* int, minimum..maximum */
    VALUE_SEED,         /* uint64_t */
    VALUE_TEXT,         /* not empty */
    VALUE_SOLVER,
    VALUE_FORMULATION,
    VALUE_CONTACT_SOLVER,
    VALUE_ONLY,
    VALUE_CONTACTS,
    VALUE_COUNTS, /* whole numbers from 1 to 1000000, commas between */
    VALUE_RATIO   /* double > 0 and <= 10 */
} value_kind;

typedef struct value_range {
    value_kind kind;
    int minimum, maximum; /* VALUE_INTEGER only */
} value_range;

/* Reads `text` into the option's field, of the kind's type; false where it is not what it should be. */
bool option_value_store(const value_range *range, const char *text, void *field);
/* What it should be, for a message; help: for the kinds whose help says it. */
void option_value_expected(const value_range *range, const char *help, char *text, size_t size);

#endif
