/*
 * Compares the shipped scenes with assets/reference/compare.json, and checks that the comparison notices what is broken
 * on purpose.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/sanitized.h"
#include "support/schema.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* All scenes and all runs; with sanitizers some scenes, and Pinch alone. */
static void test_as_it_was(void **state)
{
    (void)state;
    static const char *const some[] = {"--contact-solver",
                                       "pinch",
                                       COMPARE_SCENE("egg.json"),
                                       COMPARE_SCENE("example-2.json"),
                                       COMPARE_SCENE("pinched-capsule.json"),
                                       COMPARE_SCENE("twist.json"),
                                       NULL};
    const char *arguments[80] = {"compare", "--check", COMPARE_GOLDEN, "--quiet"};
    const char *const *more = SANITIZED ? some : shipped_scenes();
    for (int i = 0; more[i]; i++) arguments[4 + i] = more[i];
    program_result r = command_run(NULL, arguments);
    if (r.status != 0) fail_msg("%s", r.err);
    assert_string_equal(r.err, "");
    program_free(&r);
}

/* The baseline has every shipped scene, with every run, and says how it was made. */
static void test_has_all_scenes(void **state)
{
    (void)state;
    json_error_t error;
    json_t *golden = json_load_file(COMPARE_GOLDEN, 0, &error);
    assert_non_null(golden);
    const char *const *shipped = shipped_scenes();
    assert_non_null(strstr(json_string_value(json_object_get(golden, "made")), "pinch compare --save"));
    for (int i = 0; shipped[i]; i++) {
        const json_t *known = json_object_get(json_object_get(golden, "scenes"), file_name(shipped[i]));
        if (!known) fail_msg("no %s", shipped[i]);
        assert_int_equal(json_object_size(json_object_get(known, "runs")), 5);
        const json_t *pinch = json_object_get(json_object_get(known, "runs"), "pinch");
        assert_true(json_number_value(json_object_get(pinch, "force_error_max")) <= 1e-9);
    }
    json_decref(golden);
}

/* Expects exit status 1, and that `metric` of `name` is among what moved, by more than its limit. */
static void expect_moved(json_t *d, const char *name, const char *metric)
{
    const json_t *check = json_object_get(d, "check"), *moves = json_object_get(check, "moved");
    bool found = false;
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-compare-1.json", 0, NULL);
    assert_non_null(schema);
    assert_int_equal(schema_faults(schema, d), 0);
    json_decref(schema);
    assert_true(json_is_false(json_object_get(check, "passed")));
    for (size_t i = 0; i < json_array_size(moves); i++) {
        const json_t *move = json_array_get(moves, i);
        if (strcmp(json_string_value(json_object_get(move, "scene")), name) != 0) continue;
        if (strcmp(json_string_value(json_object_get(move, "metric")), metric) != 0) continue;
        double by = json_number_value(json_object_get(move, "by"));
        assert_true(fabs(by) > json_number_value(json_object_get(move, "limit")));
        found = true;
    }
    if (!found) fail_msg("%s: %s is not among what moved", name, metric);
    json_decref(d);
}

/* A shipped scene with all fingers' `key` times `factor`; stiffnesses are an object of several. */
static char *scaled_scene(const char *folder, const char *name, const char *key, double factor)
{
    char path[512];
    json_error_t error;
    snprintf(path, sizeof path, COMPARE_SCENE("%s"), name);
    json_t *scene = json_load_file(path, 0, &error);
    assert_non_null(scene);
    size_t i;
    const char *part;
    json_t *finger, *member;
    json_array_foreach(json_object_get(scene, "fingers"), i, finger)
    {
        json_t *value = json_object_get(finger, key);
        assert_non_null(value);
        if (json_is_number(value))
            json_object_set_new(finger, key, json_real(factor * json_number_value(value)));
        else
            json_object_foreach(value, part, member)
                json_object_set_new(value, part, json_real(factor * json_number_value(member)));
    }
    char *text = json_dumps(scene, JSON_INDENT(1));
    char *written = program_write_file(folder, name, text);
    free(text);
    json_decref(scene);
    return written;
}

static void expect_scaled(const char *name, const char *key, double factor, const char *metric)
{
    char *folder = program_make_folder(), *path = scaled_scene(folder, name, key, factor);
    expect_moved(
        compare_document(COMPARE(NULL, path, "--check", COMPARE_GOLDEN, "--json", "--contact-solver", "pinch"), 1),
        name, metric);
    free(path);
    program_remove_folder(folder);
}

/* What does not slip moves as before: the margin tells. */
static void test_friction_coefficient(void **state)
{
    (void)state;
    expect_scaled("pinched-capsule.json", "friction", 1.1, "slip_margin");
    expect_scaled("egg.json", "friction", 0.95, "slip_margin");
}

static void test_stiffness(void **state)
{
    (void)state;
    expect_scaled("pinched-capsule.json", "stiffness", 1.01, "displacement");
    expect_scaled("egg.json", "stiffness", 0.99, "displacement");
}

static void test_manifold_point(void **state)
{
    (void)state;
    expect_moved(compare_document(COMPARE(NULL, COMPARE_SCENE("pads-shake.json"), "--check", COMPARE_GOLDEN, "--json",
                                          "--contact-solver", "pinch", "--points", "3"),
                                  1),
                 "pads-shake.json", "points");
}

static void test_warm_start(void **state)
{
    (void)state;
    expect_moved(compare_document(COMPARE(NULL, COMPARE_SCENE("pinched-capsule.json"), "--check", COMPARE_GOLDEN,
                                          "--json", "--contact-solver", "pinch", "--cold-start"),
                                  1),
                 "pinched-capsule.json", "start_residual");
}

static void write_json(const char *folder, const char *name, const json_t *document)
{
    char *text = json_dumps(document, JSON_INDENT(1));
    free(program_write_file(folder, name, text));
    free(text);
}

/* A saved baseline passes its own check; a number in it that is changed is named with scene, run, values and limit; a
 * tolerance of the scene's own goes before the common one. */
static void test_save_and_check(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    const char *egg = COMPARE_SCENE("egg.json");
    program_result r = COMPARE(folder, egg, "--duration", "0.5", "--quiet", "--save", "b.json");
    assert_int_equal(r.status, 0);
    program_free(&r);
    r = COMPARE(folder, egg, "--duration", "0.5", "--quiet", "--check", "b.json");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, "");
    program_free(&r);

    r = COMPARE(folder, egg, "--duration", "0.6", "--quiet", "--check", "b.json");
    assert_int_equal(r.status, 1);
    assert_non_null(strstr(r.err, "egg.json, all: steps moved from 500 to 600"));
    program_free(&r);

    snprintf(path, sizeof path, "%s/b.json", folder);
    json_t *b = json_load_file(path, 0, NULL);
    assert_non_null(b);
    json_t *entry = json_object_get(json_object_get(b, "scenes"), "egg.json");
    json_t *pinch = json_object_get(json_object_get(entry, "runs"), "pinch");
    json_object_set_new(pinch, "grip_force", json_real(1.01 * json_number_value(json_object_get(pinch, "grip_force"))));
    write_json(folder, "b.json", b);
    r = COMPARE(folder, egg, "--duration", "0.5", "--quiet", "--check", "b.json");
    assert_int_equal(r.status, 1);
    assert_non_null(strstr(r.err, "egg.json, pinch: grip_force moved from "));
    assert_non_null(strstr(r.err, " N, by -"));
    assert_non_null(strstr(r.err, "; the limit is "));
    program_free(&r);

    json_object_set_new(entry, "tolerances",
                        json_pack("{s:{s:{s:i, s:f}}}", "pinch", "grip_force", "absolute", 0, "relative", 0.02));
    write_json(folder, "b.json", b);
    r = COMPARE(folder, egg, "--duration", "0.5", "--quiet", "--check", "b.json");
    if (r.status != 0) fail_msg("%s", r.err);
    program_free(&r);
    json_decref(b);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_has_all_scenes),       cmocka_unit_test(test_as_it_was),
        cmocka_unit_test(test_friction_coefficient), cmocka_unit_test(test_stiffness),
        cmocka_unit_test(test_manifold_point),       cmocka_unit_test(test_warm_start),
        cmocka_unit_test(test_save_and_check),
    };
    return cmocka_run_group_tests_name("baselines", tests, NULL, NULL);
}
