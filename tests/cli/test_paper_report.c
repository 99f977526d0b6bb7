/* Runs `pinch bench paper --report --json`: the page has no number that the document lacks, and published values are
 * compared as assets/reference/paper.json says. */
#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/program.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static json_t *document;
static char *page;

static int set_up(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512];
    snprintf(file, sizeof file, "%s/paper.html", folder);
    /* all of it takes half a minute: random grasps and runs, and 4 to 16 faces */
    bool all = getenv("PINCH_TEST_FULL") != NULL;
    program_result r =
        PINCH(NULL, "bench", "paper", "--report", file, "--json", all ? NULL : "--faces", "5", "--budget", "0.01");
    assert_int_equal(r.status, 0);
    document = json_loads(r.out, 0, NULL);
    assert_non_null(document);
    page = program_read_file(file);
    assert_non_null(page);
    program_free(&r);
    program_remove_folder(folder);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    json_decref(document);
    free(page);
    return 0;
}

/* Is there such a number, or a string with such a text, in the document? */
static bool has_number(const json_t *value, double wanted)
{
    const char *key;
    json_t *part;
    size_t i;
    if (json_is_number(value)) return json_number_value(value) == wanted;
    if (json_is_object(value))
        json_object_foreach((json_t *)value, key, part) if (has_number(part, wanted)) return true;
    if (json_is_array(value)) json_array_foreach(value, i, part) if (has_number(part, wanted)) return true;
    return false;
}

static bool has_text(const json_t *value, const char *wanted)
{
    const char *key;
    json_t *part;
    size_t i;
    if (json_is_string(value)) return strstr(json_string_value(value), wanted);
    if (json_is_object(value)) json_object_foreach((json_t *)value, key, part) if (has_text(part, wanted)) return true;
    if (json_is_array(value)) json_array_foreach(value, i, part) if (has_text(part, wanted)) return true;
    return false;
}

static void every_number_of_the_page_is_in_the_document(void **state)
{
    (void)state;
    static const char mark[] = "<data value=\"";
    int count = 0;
    for (const char *at = page; (at = strstr(at, mark)); count++) {
        at += sizeof mark - 1;
        char *end;
        double value = strtod(at, &end);
        assert_true(*end == '"');
        if (!has_number(document, value)) fail_msg("%.17g is on the page alone", value);
    }
    assert_true(count > 400);
}

/* Blanks an element with all that is in it. */
static void leave_out(char *text, const char *open, const char *close)
{
    for (char *from = text; (from = strstr(from, open));) {
        char *to = strstr(from, close);
        assert_non_null(to);
        memset(from, ' ', (size_t)(to - from));
    }
}

/* Numbers stand in <data> elements. What other text has digits quotes the document. */
static void other_texts_with_digits_are_quoted(void **state)
{
    (void)state;
    char *text = malloc(strlen(page) + 1), word[256];
    assert_non_null(text);
    strcpy(text, page);
    leave_out(text, "<style", "</style>");
    leave_out(text, "<svg", "</svg>");
    leave_out(text, "<data", "</data>");
    leave_out(text, "<", ">");
    for (char *at = text; *at;) {
        size_t length = strcspn(at, " \n>,;:()=");
        bool digits = false;
        for (size_t i = 0; i < length; i++) digits = digits || isdigit((unsigned char)at[i]);
        if (digits) {
            assert_true(length < sizeof word);
            memcpy(word, at, length);
            word[length] = '\0';
            if (word[length - 1] == '.') word[length - 1] = '\0'; /* the end of a sentence of the page's */
            if (!has_text(document, word)) fail_msg("\"%s\" is on the page alone", word);
        }
        at += length + (at[length] != '\0');
    }
    free(text);
}

static void the_page_needs_no_network(void **state)
{
    (void)state;
    static const char *const wrong[] = {"http:", "https:", " src=", "url(", "@import", "<link rel=\"style", "<script"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (strstr(page, wrong[i])) fail_msg("the page has %s", wrong[i]);
    assert_non_null(strstr(page, "width=device-width"));
    assert_non_null(strstr(page, "@media print"));
}

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

/* What does not depend on time is as expected: within the tolerance, or a miss that is explained. */
static void published_values_are_compared(void **state)
{
    (void)state;
    size_t i;
    json_t *v;
    int compared = 0;
    json_array_foreach(json_object_get(document, "comparison"), i, v)
    {
        const json_t *within = json_object_get(v, "within_tolerance");
        const char *expected = text_of(v, "expected");
        if (json_is_null(within)) continue;
        if (json_is_false(within))
            print_message("misses: Example %s, %s, %s %s: %g published, %g here\n", text_of(v, "example"),
                          text_of(v, "method"), text_of(v, "finger"), text_of(v, "quantity"),
                          json_number_value(json_object_get(v, "value")),
                          json_number_value(json_object_get(v, "ours")));
        if (!*expected) continue;
        compared++;
        assert_string_equal(json_is_true(within) ? "within" : "misses", expected);
        assert_true(json_is_true(within) || *text_of(v, "explanation"));
    }
    assert_int_equal(compared, 16);
}

/* The published forces of Example 2 are off by more than the tolerance, ours by less than a tenth of it. */
static void example_2_is_nearer_to_the_exact_answer_than_published(void **state)
{
    (void)state;
    size_t i;
    json_t *v;
    int forces = 0;
    json_array_foreach(json_object_get(document, "comparison"), i, v)
    {
        if (strcmp(text_of(v, "method"), "nsnmgk") != 0 || !*text_of(v, "finger")) continue;
        double exact = strcmp(text_of(v, "quantity"), "normal_force") == 0 ? 4.0 * sqrt(2.0) : sqrt(2.0);
        double tolerance = json_number_value(json_object_get(v, "tolerance"));
        assert_true(tolerance < 0.0028);
        assert_true(fabs(json_number_value(json_object_get(v, "value")) - exact) > tolerance);
        assert_close(json_number_value(json_object_get(v, "ours")), exact, 0.1 * tolerance);
        forces++;
    }
    assert_int_equal(forces, 4);
}

static void every_solver_is_in_the_table(void **state)
{
    (void)state;
    static const char *const solvers[] = {"default", "nsngrk", "nsnmgk", "newton", "lemke", "pgs", "modulus", "admm"};
    size_t i, k;
    json_t *of, *r;
    json_array_foreach(json_object_get(document, "solvers"), i, of)
    {
        int found = 0;
        json_array_foreach(json_object_get(of, "results"), k, r) for (size_t s = 0;
                                                                      s < sizeof solvers / sizeof *solvers; s++)
        {
            if (strcmp(text_of(r, "solver"), solvers[s]) != 0) continue;
            found |= 1 << s;
            /* two methods that share no code find the same forces of the exact cone */
            if (strcmp(solvers[s], "admm") != 0) continue;
            assert_string_equal(text_of(r, "status"), "converged");
            assert_true(json_number_value(json_object_get(r, "force_error_N")) <= 1e-3);
        }
        assert_int_equal(found, 0xff);
    }
    assert_int_equal(i, 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_number_of_the_page_is_in_the_document),
        cmocka_unit_test(other_texts_with_digits_are_quoted),
        cmocka_unit_test(the_page_needs_no_network),
        cmocka_unit_test(published_values_are_compared),
        cmocka_unit_test(example_2_is_nearer_to_the_exact_answer_than_published),
        cmocka_unit_test(every_solver_is_in_the_table),
    };
    return cmocka_run_group_tests_name("pinch bench paper --report", tests, set_up, tear_down);
}
