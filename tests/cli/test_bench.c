/* The real `pinch bench` of steps: its documents, and what in them does not depend on the machine's speed. */
#include "support/cmocka_all.h"

#include "support/program.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ARGUMENTS = 9 };

static program_result pinch(char *const *arguments)
{
    char executable[] = PINCH_EXECUTABLE;
    char *argv[MOST_ARGUMENTS + 2] = {executable};
    for (int i = 0; i < MOST_ARGUMENTS && arguments[i]; i++) argv[i + 1] = arguments[i];
    return program_run(NULL, argv);
}

#define PINCH(...) pinch((char *[]){__VA_ARGS__, NULL})

static json_t *rows_of(const program_result *r, json_t **document)
{
    *document = json_loads(r->out, 0, NULL);
    assert_non_null(*document);
    assert_string_equal(json_string_value(json_object_get(*document, "command")), "bench");
    json_t *rows = json_object_get(*document, "rows");
    assert_true(json_is_array(rows));
    return rows;
}

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value)) print_error("%s is no number\n", key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* What every row must show: verified answers, forces on the law, nothing allocated, nobody left out. */
static void check_row(const json_t *row, double residual_N)
{
    const json_t *pinch = json_object_get(row, "pinch"), *quickstep = json_object_get(row, "quickstep");
    assert_true(number(row, "contacts") > 0);
    assert_true(number(row, "rounds") >= 7);
    assert_true(number(row, "ratio_quickstep") > 0);
    assert_true(number(row, "residual_max") <= 1e-10);
    assert_true(number(row, "unsolved_steps") == 0);
    assert_true(number(pinch, "step_us") > 0 && number(quickstep, "step_us") > 0);
    assert_true(number(pinch, "residual_N") <= residual_N);
    assert_true(number(pinch, "allocations_per_step") == 0);
    assert_true(number(row, "memory_per_contact_bytes") > 100);
}

static void grasps_are_solved_without_allocating(void **state)
{
    (void)state;
    char *const names[] = {"step", "hands", "carried", "slip", "cold"};
    const int rows_expected[] = {4, 2, 2, 2, 2}; /* up to size 10 */
    for (int k = 0; k < 5; k++) {
        program_result r = PINCH("bench", names[k], "--max-size", "10", "--budget", "0.05", "--json");
        assert_int_equal(r.status, 0);
        assert_string_equal(r.err, "");
        json_t *document, *rows = rows_of(&r, &document), *row;
        size_t i;
        assert_int_equal(json_array_size(rows), rows_expected[k]);
        json_array_foreach(rows, i, row) check_row(row, 1e-9);
        json_decref(document);
        program_free(&r);
    }
}

static void a_pile_at_rest_is_solved(void **state)
{
    (void)state;
    program_result r = PINCH("bench", "pile", "--max-size", "60", "--budget", "0.2", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i;
    assert_int_equal(json_array_size(rows), 3);
    json_array_foreach(rows, i, row)
    {
        assert_true(number(row, "residual_max") <= 1e-10);
        const json_t *pinch = json_object_get(row, "pinch");
        assert_true(number(pinch, "kinetic_energy_J") < 10); /* of 60 bodies of 1 to 10 kg */
        if (strcmp(json_string_value(json_object_get(row, "series")), "wall") != 0) continue;
        assert_true(json_is_true(json_object_get(pinch, "stands")));
        assert_true(number(pinch, "moved_m") < 1e-3);
        assert_true(number(pinch, "kinetic_energy_J") < 1e-18);
        assert_true(number(pinch, "iterations") < 1); /* most steps find that nothing has changed */
    }
    json_decref(document);
    program_free(&r);
}

static void sizes_out_of_range_are_refused(void **state)
{
    (void)state;
    char *const wrong[][2] = {{"--max-size", "0"}, {"--threads", "65"}, {"--threads", "none"}, {"--budget", "0"}};
    for (int k = 0; k < 4; k++) {
        program_result r = PINCH("bench", "step", wrong[k][0], wrong[k][1]);
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        assert_non_null(strstr(r.err, wrong[k][0]));
        program_free(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grasps_are_solved_without_allocating),
        cmocka_unit_test(a_pile_at_rest_is_solved),
        cmocka_unit_test(sizes_out_of_range_are_refused),
    };
    return cmocka_run_group_tests_name("pinch bench", tests, NULL, NULL);
}
