#include "option_values.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double MOST_RATIO = 10;

/* strtod also takes blanks, hexadecimal, inf and nan: none of them is meant here */
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

/* The place of `text` among the names. */
static bool parse_name(const char *text, const char *const *names, int count, int *value)
{
    for (int i = 0; i < count; i++)
        if (strcmp(text, names[i]) == 0) {
            *value = i;
            return true;
        }
    return false;
}

static bool parse_contact_solver(const char *text, option_contact_solver *value)
{
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    int place;
    if (!parse_name(text, names, 3, &place)) return false;
    *value = (option_contact_solver)place;
    return true;
}

static bool parse_only(const char *text, option_only *value)
{
    static const char *const names[] = {"all", "soft", "material"};
    int place;
    if (!parse_name(text, names, 3, &place)) return false;
    *value = (option_only)place;
    return true;
}

static bool parse_contacts(const char *text, option_contacts *value)
{
    static const char *const names[] = {"ode", "pinch"};
    int place;
    if (!parse_name(text, names, 2, &place)) return false;
    *value = (option_contacts)place;
    return true;
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

static bool store_integer(const value_range *range, const char *text, int *field)
{
    double number;
    if (!parse_number(text, &number) || number != floor(number) ||
        !(number >= range->minimum && number <= range->maximum))
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

bool option_value_store(const value_range *range, const char *text, void *field)
{
    switch (range->kind) {
    case VALUE_FLAG:
        *(bool *)field = true;
        return true;
    case VALUE_POSITIVE:
    case VALUE_NOT_NEGATIVE:
        return store_number(range->kind, text, field);
    case VALUE_RATIO:
        return store_number(range->kind, text, field) && *(double *)field <= MOST_RATIO;
    case VALUE_INTEGER:
        return store_integer(range, text, field);
    case VALUE_SEED:
        return parse_seed(text, field);
    case VALUE_TEXT:
        return store_text(text, field);
    case VALUE_SOLVER:
        return pinch_solver_from_name(text, field) == PINCH_OK;
    case VALUE_FORMULATION:
        return scene_formulation_from_name(text, field);
    case VALUE_CONTACT_SOLVER:
        return parse_contact_solver(text, field);
    case VALUE_ONLY:
        return parse_only(text, field);
    case VALUE_CONTACTS:
        return parse_contacts(text, field);
    case VALUE_COUNTS:
        return parse_counts(text, field);
    }
    return false;
}

void option_value_expected(const value_range *range, const char *help, char *text, size_t size)
{
    switch (range->kind) {
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
        snprintf(text, size, "a whole number from %d to %d", range->minimum, range->maximum);
        return;
    case VALUE_SEED:
        snprintf(text, size, "a whole number from 0 to 18446744073709551615");
        return;
    case VALUE_TEXT:
        snprintf(text, size, "a name");
        return;
    case VALUE_COUNTS:
        snprintf(text, size, "up to %d different whole numbers from 1 to 1000000, commas between", OPTION_MOST_COUNTS);
        return;
    default:
        snprintf(text, size, "%s", help);
    }
}
