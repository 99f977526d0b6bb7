/* The search for the least value of a quantity: what it says was tried, and the trial alone is that of its row. */
#include "support/cmocka_all.h"

#include "study/trial.h"
#include "support/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Gravity of 9.81 m/s^2 on 0.5 kg, and each finger presses with 10 N: the least friction that holds is 0.24525. */
#define FINGER(name, x, n, friction)                                                                                   \
    "{\"name\": \"" name "\", \"point\": [" x ", 0, 0], \"normal\": [" n ", 0, 0], \"model\": \"soft\", "              \
    "\"stiffness\": {\"normal\": 20000, \"torsional\": 1}, \"damping\": {\"normal\": 20, \"tangential\": 13}, "        \
    "\"friction\": " friction ", \"torsional_friction\": 0.002, \"closing\": 0.0005, \"ramp\": 0.2}"
#define SCENE_TEXT(friction)                                                                                           \
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, "         \
    "\"mass\": 0.5}, \"fingers\": [" FINGER("left", "-0.05", "1", friction) ", " FINGER(                               \
        "right", "0.05", "-1", friction) "],"                                                                          \
                                         " \"schedule\": [{\"time\": 0.2, \"gravity\": [0, 0, 0]}, {\"time\": 0.4, "   \
                                         "\"gravity\": [0, 0, -9.81]}],"                                               \
                                         " \"simulation\": {\"duration\": 1}}"
static const double LEAST = 4.905 / 20;

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    free(program_write_file(folder, "cube.json", SCENE_TEXT("0.6")));
    free(program_write_file(folder, "kinetic.json", SCENE_TEXT("{\"static\": 0.6, \"kinetic\": 0.05}")));
    dInitODE2(0);
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    world_close_ode();
    program_remove_folder(folder);
    return 0;
}

static study *load(const char *scene_file, const char *rest)
{
    char text[2048];
    study *s;
    scene_error error;
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-study/1\", \"scene\": \"%s\", \"success\": {\"displacement\": 0.001},\n%s}",
             scene_file, rest);
    char *path = program_write_file(folder, "study.json", text);
    if (study_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    if (trial_check(s, &error) != SCENE_OK) fail_msg("%s", error.text);
    free(path);
    return s;
}

#define ONE "\"trials\": {\"samples\": 1}, "

/* A member of what the trial has recorded; NaN where it is null. */
static double recorded(const json_t *trial, const char *name)
{
    const json_t *value = json_object_get(json_object_get(trial, "recorded"), name);
    if (!value) fail_msg("%s is not recorded", name);
    return json_is_null(value) ? NAN : json_number_value(value);
}

static void expect_bracket(const json_t *trial, bool success, double holds, double fails)
{
    assert_int_equal(json_is_true(json_object_get(trial, "success")), success);
    double is_holds = recorded(trial, "least.holds"), is_fails = recorded(trial, "least.fails");
    assert_true(isnan(holds) ? isnan(is_holds) : is_holds == holds);
    assert_true(isnan(fails) ? isnan(is_fails) : is_fails == fails);
}

/* Where the lower end holds nothing has failed, and where the upper one fails nothing has held. */
static void what_is_recorded_was_tried(void **state)
{
    (void)state;
    study *s = load("cube.json", ONE "\"least\": {\"path\": \"/fingers/*/friction\", \"from\": 0.4, \"to\": 1}");
    json_t *trial = trial_run(s, 0);
    expect_bracket(trial, true, 0.4, NAN);
    json_decref(trial);
    study_free(s);
    s = load("cube.json", ONE "\"least\": {\"path\": \"/fingers/*/friction\", \"from\": 0.01, \"to\": 0.1}");
    trial = trial_run(s, 0);
    expect_bracket(trial, false, NAN, 0.1);
    json_decref(trial);
    study_free(s);
}

/* A friction below the kinetic one is no legal scene, and no friction that fails. */
static void an_illegal_value_is_a_bad_draw(void **state)
{
    (void)state;
    study *s = load("kinetic.json",
                    "\"trials\": {\"design\": \"grid\"}, \"vary\": [{\"path\": \"/fingers/*/friction/kinetic\", "
                    "\"values\": [0.2, 0.05], \"common\": true}], \"least\": {\"path\": "
                    "\"/fingers/*/friction/static\", \"from\": 0.1, \"to\": 1, \"precision\": 0.05}");
    json_t *trial = trial_run(s, 0);
    assert_string_equal(json_string_value(json_object_get(trial, "status")), "bad_draw");
    assert_int_equal(json_integer_value(json_object_get(trial, "exit")), 2);
    assert_null(json_object_get(json_object_get(trial, "recorded"), "least.fails"));
    const json_t *fault = json_array_get(json_object_get(trial, "errors"), 0);
    assert_non_null(strstr(json_string_value(json_object_get(fault, "message")), "friction"));
    json_decref(trial);
    trial = trial_run(s, 1);
    assert_in_range((unsigned)(1000 * recorded(trial, "least.holds")), 245, 258);
    json_decref(trial);
    study_free(s);
}

/* The random method needs some projections in the first steps of this scene, and there is no half of one. */
static void whole_numbers_are_halved_as_such(void **state)
{
    (void)state;
    study *s = load(SCENE("example-3.json"),
                    ONE "\"vary\": [{\"path\": \"/solver/name\", \"values\": [\"nsngrk\"]}, {\"path\": "
                        "\"/simulation/duration\", \"values\": [0.05]}], "
                        "\"least\": {\"path\": \"/solver/max_iterations\", \"from\": 1, \"to\": 1000}");
    json_t *trial = trial_run(s, 0);
    double holds = recorded(trial, "least.holds");
    assert_string_equal(json_string_value(json_object_get(trial, "status")), "converged");
    assert_true(holds > 1 && holds < 1000 && holds == floor(holds));
    expect_bracket(trial, true, holds, holds - 1);
    json_decref(trial);
    study_free(s);
}

/* The inputs of the trial alone are those of the row, and so are the quality of the grasp and the run. */
static void the_trial_alone_is_the_row(void **state)
{
    (void)state;
    study *s = load("cube.json", ONE "\"least\": {\"path\": \"/fingers/*/friction\", \"from\": 0.01, \"to\": 1}, "
                                     "\"record\": [\"grasp.smallest_friction\"]");
    json_t *trial = trial_run(s, 0), *inputs = trial_inputs(s, 0, NULL);
    double holds = recorded(trial, "least.holds");
    assert_close(holds, LEAST, 2e-3 * LEAST);
    assert_close(json_number_value(json_object_get(inputs, "/fingers/1/friction")), holds, 0);
    assert_close(recorded(trial, "grasp.smallest_friction") * holds, LEAST, 1e-5);
    program_result r = PINCH(folder, "study", "study.json", "--trial", "0", "--json", "--quiet");
    json_t *alone = cli_document(&r);
    assert_string_equal(json_string_value(json_object_get(alone, "hash")),
                        json_string_value(json_object_get(trial, "hash")));
    program_free(&r);
    r = PINCH(folder, "study", "study.json", "--trial", "0", "--print");
    json_t *printed = cli_document(&r);
    assert_close(json_number_value(json_object_get(json_array_get(json_object_get(printed, "fingers"), 0), "friction")),
                 holds, 0);
    program_free(&r);
    json_decref(printed);
    json_decref(alone);
    json_decref(inputs);
    json_decref(trial);
    study_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_recorded_was_tried),
        cmocka_unit_test(an_illegal_value_is_a_bad_draw),
        cmocka_unit_test(whole_numbers_are_halved_as_such),
        cmocka_unit_test(the_trial_alone_is_the_row),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
