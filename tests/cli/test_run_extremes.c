/*
 * Takes `pinch run` to the edges of what a scene may say: numbers that overflow, runs without steps, force control that
 * moves.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/program.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A 100 mm cube between two force-controlled and two closing fingers; %s: mass, how A and B press, what follows. */
static const char *const SCENE_TEXT =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0],\n"
    "\"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, \"mass\": %s},\n"
    "\"fingers\": [\n"
    "{\"name\": \"A\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], \"model\": \"%s\", \"normal_force\": 10,\n"
    " \"stiffness\": {\"normal\": 20000, \"torsional\": 1}, \"damping\": {\"normal\": 20, \"tangential\": 10},\n"
    " \"friction\": 0.8, \"torsional_friction\": 0},\n"
    "{\"name\": \"B\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"normal_force\": %s,\n"
    " \"stiffness\": {\"normal\": 20000}, \"damping\": {\"normal\": 20, \"tangential\": 10}, \"friction\": 0.8}],\n"
    "%s \"simulation\": {\"duration\": %s}}\n";

static program_result run_scene(const char *mass, const char *model, const char *force, const char *more,
                                const char *duration)
{
    char text[4096], executable[] = PINCH_EXECUTABLE, command[] = "run", name[] = "scene.json", json[] = "--json";
    snprintf(text, sizeof text, SCENE_TEXT, mass, model, force, more, duration);
    char *folder = program_make_folder(), *path = program_write_file(folder, name, text);
    char *argv[] = {executable, command, name, json, NULL};
    program_result r = program_run(folder, argv);
    free(path);
    program_remove_folder(folder);
    return r;
}

static json_t *document_of(const program_result *r)
{
    json_t *document = json_loads(r->out, 0, NULL);
    assert_non_null(document);
    return document;
}

static double number(const json_t *d, const char *list, size_t index)
{
    return json_number_value(json_array_get(json_object_get(json_object_get(d, "object"), list), index));
}

static program_result run_egg(double mass, double torque)
{
    json_t *scene = json_load_file(PINCH_SOURCE_DIR "/assets/scenes/egg.json", 0, NULL);
    json_t *object = json_object_get(scene, "object");
    assert_int_equal(json_object_set_new(object, "mass", json_real(mass)), 0);
    assert_int_equal(json_object_set_new(object, "torque", json_pack("[f,f,f]", torque, torque / 10, torque / 100)), 0);
    char *text = json_dumps(scene, 0), *folder = program_make_folder();
    free(program_write_file(folder, "scene.json", text));
    char executable[] = PINCH_EXECUTABLE, command[] = "run", name[] = "scene.json", json[] = "--json";
    program_result r = program_run(folder, (char *const[]){executable, command, name, json, NULL});
    program_remove_folder(folder);
    free(text);
    json_decref(scene);
    return r;
}

/* An egg of a nanogram is spun so fast that its numbers overflow, although each number of its scene is in its range.
 * The run ends before ODE would abort, says so, and claims nothing. */
static void test_overflow_ends_the_run(void **state)
{
    (void)state;
    static const double torques[] = {1e10, 3e11, 1e12};
    for (int i = 0; i < 3; i++) {
        program_result r = run_egg(1e-12, torques[i]);
        assert_int_equal(r.status, 1);
        json_t *d = document_of(&r);
        assert_string_equal(json_string_value(json_object_get(d, "status")), "diverged");
        assert_false(json_is_true(json_object_get(json_object_get(d, "verification"), "passed")));
        json_decref(d);
        program_free(&r);
    }
}

/* Numbers that no hand or object has are refused by their place, before anything is run. */
static void test_magnitudes_have_ranges(void **state)
{
    (void)state;
    static const struct {
        const char *mass, *force, *more, *says;
    } cases[] = {
        {"1e-20", "10", "", "scene.json:2: object.mass: expected a number from 1e-12 to 1e+09 (kg), got 1e-20"},
        {"1e200", "10", "", "object.mass: expected a number from 1e-12 to 1e+09 (kg)"},
        {"0.5", "1e28", "", "fingers[1].normal_force: expected a number from 0 to 1e+12 (N)"},
        {"0.5", "10", "\"schedule\": [{\"time\": 0, \"force\": [-1e13, 0, 0]}],",
         "schedule[0].force[0]: expected a number from -1e+12 to 1e+12 (N)"},
        {"0.5", "10", "\"schedule\": [{\"time\": 0, \"gravity\": [0, 0, -1e10]}],",
         "schedule[0].gravity[2]: expected a number from -1e+09 to 1e+09 (m/s^2)"},
        {"0.5", "10", "\"schedule\": [{\"time\": 0, \"hand\": {\"rotation\": [0, 2e6, 0]}}],",
         "schedule[0].hand.rotation[1]: expected a number from -1e+06 to 1e+06 (rad)"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        program_result r = run_scene(cases[i].mass, "hard", cases[i].force, cases[i].more, "0.05");
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        if (!strstr(r.err, cases[i].says)) fail_msg("%s does not say \"%s\"", r.err, cases[i].says);
        program_free(&r);
    }
}

static void test_a_run_needs_steps(void **state)
{
    (void)state;
    static const char *const durations[] = {"1e30", "1e-9"};
    for (int i = 0; i < 2; i++) {
        program_result r = run_scene("0.5", "hard", "10", "", durations[i]);
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        assert_non_null(strstr(r.err, "steps"));
        program_free(&r);
    }
}

/* A soft finger may have no torsional friction at all. */
static void test_soft_without_torsional_friction(void **state)
{
    (void)state;
    program_result r = run_scene("0.5", "soft", "10", "", "0.2");
    assert_int_equal(r.status, 0);
    program_free(&r);
}

/* A grip that is twisted while it falls, with these coefficients. */
static void expect_verified(const char *model, double friction, double torsional_friction)
{
    char *folder = program_make_folder(), text[2048], of_finger[256];
    snprintf(of_finger, sizeof of_finger,
             "\"model\": \"%s\", \"stiffness\": {\"normal\": 1e4, \"torsional\": 1}, \"friction\": %g, "
             "\"torsional_friction\": %g, \"closing\": 0.0005}",
             model, friction, torsional_friction);
    snprintf(
        text, sizeof text,
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.05, 0.05, 0.05]}, "
        "\"mass\": 0.1, \"torque\": [0.001, 0, 0]}, \"fingers\": ["
        "{\"name\": \"l\", \"point\": [-0.025, 0, 0], \"normal\": [1, 0, 0], %s,"
        "{\"name\": \"r\", \"point\": [0.025, 0, 0], \"normal\": [-1, 0, 0], %s],"
        "\"simulation\": {\"duration\": 0.1}}",
        of_finger, of_finger);
    free(program_write_file(folder, "scene.json", text));
    program_result r = program_run(folder, (char *const[]){PINCH_EXECUTABLE, "run", "scene.json", "--json", NULL});
    json_t *d = document_of(&r);
    bool good = r.status == 0 && json_integer_value(json_object_get(d, "unconverged_steps")) == 0;
    if (!good) fail_msg("%s, friction %g, torsional %g: status %d", model, friction, torsional_friction, r.status);
    json_decref(d);
    program_free(&r);
    program_remove_folder(folder);
}

/* Coefficients whose squares and quotients leave double precision are as good as none. */
static void test_next_to_no_friction(void **state)
{
    (void)state;
    for (double tiny = 1e-40; tiny > 1e-305; tiny *= 1e-20) {
        expect_verified("hard", tiny, 0);
        expect_verified("soft", tiny, tiny);
        expect_verified("soft", tiny, 0.002);
        expect_verified("soft", 0.5, tiny);
    }
}

/* The hand turns by 2 rad: so does what force-controlled fingers hold, and they press with exactly their force. */
static void test_force_control_turns_with_the_hand(void **state)
{
    (void)state;
    program_result r = run_scene("0.5", "hard", "10",
                                 "\"schedule\": [{\"time\": 0.1, \"hand\": {\"rotation\": [0, 0, 0]}},"
                                 "{\"time\": 1.1, \"hand\": {\"rotation\": [0, 0, 2]}}],",
                                 "2");
    assert_int_equal(r.status, 0);
    json_t *d = document_of(&r);
    double turned = 2 * atan2(number(d, "orientation", 3), number(d, "orientation", 0));
    assert_close(turned, 2, 1e-6); /* what the common turn leaves of shear, a micrometre over the half size */
    const json_t *finger = json_array_get(json_object_get(d, "fingers"), 0);
    assert_close(json_number_value(json_object_get(finger, "normal_force")), 10, 1e-9);
    json_decref(d);
    program_free(&r);
}

/* The stronger finger pushes the cube and the weaker one until that one's tip meets a wall, 20 mm away, and no farther.
 */
static void test_a_wall_stops_a_force_controlled_tip(void **state)
{
    (void)state;
    program_result r =
        run_scene("0.5", "hard", "5",
                  "\"environment\": [{\"name\": \"wall\", \"shape\": {\"type\": \"box\", \"size\": [0.02, 0.1, 0.1]},"
                  "\"position\": [0.0973205080756888, 0, 0], \"stiffness\": {\"normal\": 1e5},"
                  "\"damping\": {\"normal\": 100}, \"friction\": 0.5}],",
                  "1");
    json_t *d = document_of(&r);
    /* tip radius: a tenth of the bounding radius, 8.66 mm; gap 20 mm; pressed in by far less than a millimetre */
    double travel = number(d, "position", 0);
    assert_true(travel > 0.019 && travel < 0.0215);
    json_decref(d);
    program_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_overflow_ends_the_run),
        cmocka_unit_test(test_magnitudes_have_ranges),
        cmocka_unit_test(test_a_run_needs_steps),
        cmocka_unit_test(test_soft_without_torsional_friction),
        cmocka_unit_test(test_next_to_no_friction),
        cmocka_unit_test(test_force_control_turns_with_the_hand),
        cmocka_unit_test(test_a_wall_stops_a_force_controlled_tip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
