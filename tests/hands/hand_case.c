#include "hand_case.h"

#include "support/cmocka_all.h"
#include "support/program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

hand *hand_from_text(const char *folder, const char *name, const char *text)
{
    char *path = program_write_file(folder, name, text);
    hand *h;
    hand_error error;
    if (hand_load(path, NULL, 0, &h, &error) != HAND_OK) fail_msg("%s", error.text);
    free(path);
    return h;
}

static int line_of(const char *text, const char *what)
{
    const char *at = strstr(text, what);
    if (!at) fail_msg("no \"%s\" in the text", what);
    int line = 1;
    for (const char *c = text; c < at; c++) line += *c == '\n';
    return line;
}

void hand_faults_are_named(const char *name, const hand_fault *faults, size_t count)
{
    char *folder = program_make_folder();
    for (size_t i = 0; i < count; i++) {
        const hand_fault *f = &faults[i];
        char *path = program_write_file(folder, name, f->text);
        char start[512];
        hand *h;
        hand_error error;
        if (hand_load(path, NULL, 0, &h, &error) != HAND_BAD_INPUT) fail_msg("case %zu is taken: %s", i, f->says);
        assert_null(h);
        if (f->line_of)
            snprintf(start, sizeof start, "%s:%d: <", path, line_of(f->text, f->line_of));
        else
            snprintf(start, sizeof start, "%s", path);
        if (strncmp(error.text, start, strlen(start)) != 0 || !strstr(error.text, f->says) || strchr(error.text, '\n'))
            fail_msg("case %zu: expected %s...%s, got %s", i, start, f->says, error.text);
        free(path);
    }
    program_remove_folder(folder);
}

void assert_numbers(const double *a, const double *b, int count, double tolerance)
{
    for (int i = 0; i < count; i++)
        if (!(fabs(a[i] - b[i]) <= tolerance)) fail_msg("number %d: %.17g and %.17g", i, a[i], b[i]);
}

void assert_orientation(const double a[4], const double b[4], double tolerance)
{
    double inner = 0;
    for (int i = 0; i < 4; i++) inner += a[i] * b[i];
    for (int i = 0; i < 4; i++)
        if (!(fabs(a[i] - (inner < 0 ? -b[i] : b[i])) <= tolerance))
            fail_msg("(%g, %g, %g, %g) and (%g, %g, %g, %g)", a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]);
}
