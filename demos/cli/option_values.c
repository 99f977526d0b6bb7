/* Reading the values of options. */
#include "option_values.h"
#include "options.h"

#include "scenes/world/simulation.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double MOST_RATIO = 10;

/* strtod also reads blanks, hexadecimal numbers, inf and nan, none of which is meant here. */
static bool parse_number(const char *text, double *value)
{
    char *end;
    if (!*text || text[strspn(text, "0123456789+-.eE")]) return false;
    *value = strtod(text, &end);
    return *end == '\0' && isfinite(*value);
}

static bool parse_seed(const char *text, uint64_t *value)
{
    char *end;
    if (!*text || text[strspn(text, "0123456789")]) return false;
    errno = 0;
    unsigned long long parsed = strtoull(text, &end, 10);
    *value = parsed;
    return *end == '\0' && errno == 0 && parsed <= UINT64_MAX;
}

/* The field becomes the place of `text` among the names. */
static bool store_name(const char *text, const char *const *list, int *field)
{
    for (int i = 0; list[i]; i++)
        if (strcmp(text, list[i]) == 0) {
            *field = i;
            return true;
        }
    return false;
}

static bool parse_counts(const char *text, option_counts *list)
{
    option_counts parsed = {0};
    for (;; text++) {
        char *end;
        long value = *text >= '0' && *text <= '9' ? strtol(text, &end, 10) : 0;
        if (value < 1 || value > 1000000 || parsed.count == OPTION_MOST_COUNTS) return false;
        for (int i = 0; i < parsed.count; i++)
            if (parsed.values[i] == value) return false;
        parsed.values[parsed.count++] = (int)value;
        text = end;
        if (!*text) break;
        if (*text != ',') return false;
    }
    *list = parsed;
    return true;
}

static bool parse_events(const char *text, unsigned *set)
{
    *set = 0;
    for (;;) {
        size_t length = strcspn(text, ",");
        int event = EVENT_COUNT;
        for (int i = 0; i < EVENT_COUNT; i++) {
            const char *name = simulation_event_name((simulation_event_type)i);
            if (strlen(name) == length && strncmp(text, name, length) == 0) event = i;
        }
        if (event == EVENT_COUNT) return false;
        *set |= 1u << event;
        if (!text[length]) return true;
        text += length + 1;
    }
}

static bool store_integer(const option_row *op, const char *text, int *field)
{
    double number;
    if (!parse_number(text, &number) || number != floor(number) || !(number >= op->minimum && number <= op->maximum))
        return false;
    *field = (int)number;
    return true;
}

static bool store_number(value_kind kind, const char *text, double *field)
{
    double number;
    if (!parse_number(text, &number) || number < 0 || (number == 0 && kind != VALUE_NOT_NEGATIVE)) return false;
    *field = number;
    return true;
}

static bool store_text(const char *text, const char **field)
{
    *field = text;
    return *text != '\0';
}

bool option_store(const option_row *op, const char *text, void *field)
{
    switch (op->kind) {
    case VALUE_FLAG:
        *(bool *)field = true;
        return true;
    case VALUE_POSITIVE:
    case VALUE_NOT_NEGATIVE:
        return store_number(op->kind, text, field);
    case VALUE_RATIO:
        return store_number(op->kind, text, field) && *(double *)field <= MOST_RATIO;
    case VALUE_INTEGER:
        return store_integer(op, text, field);
    case VALUE_SEED:
        return parse_seed(text, field);
    case VALUE_TEXT:
    case VALUE_INPUT:
    case VALUE_FOLDER:
    case VALUE_STREAM:
        return store_text(text, field);
    case VALUE_OUTPUT:
        return strcmp(text, "-") != 0 && store_text(text, field);
    case VALUE_SOLVER:
        return pinch_solver_from_name(text, field) == PINCH_OK;
    case VALUE_FORMULATION:
        return scene_formulation_from_name(text, field);
    case VALUE_NAME:
        return store_name(text, op->names, field);
    case VALUE_COUNTS:
        return parse_counts(text, field);
    case VALUE_EVENTS:
        return parse_events(text, field);
    }
    return false;
}

const char *option_word(const option_row *op, int i)
{
    switch (op->kind) {
    case VALUE_SOLVER:
        return i < PINCH_SOLVER_COUNT ? pinch_solver_name((pinch_solver)i) : NULL;
    case VALUE_FORMULATION:
        return i < SCENE_FORMULATION_COUNT ? scene_formulation_name((scene_formulation)i) : NULL;
    case VALUE_EVENTS:
        return i < EVENT_COUNT ? simulation_event_name((simulation_event_type)i) : NULL;
    case VALUE_NAME:
        return op->names[i];
    default:
        return NULL;
    }
}

void option_expected(const option_row *op, char *text, size_t size)
{
    switch (op->kind) {
    case VALUE_POSITIVE:
        snprintf(text, size, "a number > 0");
        return;
    case VALUE_NOT_NEGATIVE:
        snprintf(text, size, "a number >= 0");
        return;
    case VALUE_RATIO:
        snprintf(text, size, "a number > 0 and <= %g", MOST_RATIO);
        return;
    case VALUE_INTEGER:
        snprintf(text, size, "a whole number from %d to %d", op->minimum, op->maximum);
        return;
    case VALUE_SEED:
        snprintf(text, size, "a whole number from 0 to 18446744073709551615");
        return;
    case VALUE_TEXT:
    case VALUE_INPUT:
    case VALUE_FOLDER:
    case VALUE_STREAM:
        snprintf(text, size, "a name");
        return;
    case VALUE_OUTPUT:
        snprintf(text, size, "the name of a file (/dev/stdout for standard output)");
        return;
    case VALUE_EVENTS:
        snprintf(text, size, "crush, slip, dropped or limit, or several with commas between");
        return;
    case VALUE_COUNTS:
        snprintf(text, size, "up to %d different whole numbers from 1 to 1000000, commas between", OPTION_MOST_COUNTS);
        return;
    default:
        snprintf(text, size, "%s", op->help);
    }
}
