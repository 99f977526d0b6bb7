/*
 * Runs the real `pinch solve`, `pinch lcp` and `pinch bench paper`, and checks documents, exit statuses and refusals.
 */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/sanitized.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *text(const json_t *document, const char *key)
{
    const char *value = json_string_value(json_object_get(document, key));
    assert_non_null(value);
    return value;
}

static double number(const json_t *document, const char *key)
{
    const json_t *value = json_object_get(document, key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

static void paper_scene(char path[512], const char *name)
{
    snprintf(path, 512, "%s/assets/scenes/paper/example-%s.json", PINCH_SOURCE_DIR, name);
}

static void every_key_is_there(void **state)
{
    (void)state;
    static const char *const keys[] = {"command", "scene",         "status",      "solver",       "formulation",
                                       "size",    "iterations",    "projections", "newton_steps", "residual",
                                       "time_s",  "load_fraction", "equilibrium", "verification", "fingers",
                                       "object",  "grasp"};
    static const char *const finger_keys[] = {
        "name",  "state", "normal_force",        "tangential_force",        "torsional_moment",
        "force", "slip",  "normal_displacement", "tangential_displacement", "slip_margin"};
    static char *const examples[] = {"1", "1b", "2", "3", "4"};
    static char *const formulations[] = {"lcp", "coulomb"};
    for (int e = 0; e < 5; e++)
        for (int m = 0; m < 2; m++) {
            char path[512];
            paper_scene(path, examples[e]);
            program_result r = PINCH(NULL, "solve", path, "--json", "--formulation", formulations[m]);
            assert_int_equal(r.status, 0);
            json_t *d = cli_document(&r);
            for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) assert_non_null(json_object_get(d, keys[k]));
            assert_string_equal(text(d, "status"), "converged");
            assert_string_equal(text(d, "formulation"), formulations[m]);
            assert_true(json_is_true(json_object_get(json_object_get(d, "verification"), "passed")));
            assert_true(number(d, "load_fraction") == 1.0);
            assert_int_equal(json_array_size(json_object_get(json_object_get(d, "grasp"), "stiffness")), 6);
            const json_t *fingers = json_object_get(d, "fingers");
            for (size_t i = 0; i < json_array_size(fingers); i++)
                for (size_t k = 0; k < sizeof finger_keys / sizeof *finger_keys; k++)
                    assert_non_null(json_object_get(json_array_get(fingers, i), finger_keys[k]));
            if (e <= 1) assert_close(number(json_array_get(fingers, 0), "normal_force"), 19.0 / 3.0, 1e-10);
            if (e == 2) assert_close(number(json_array_get(fingers, 1), "normal_force"), 4.0 * sqrt(2.0), 1e-8);
            json_decref(d);
            program_free(&r);
        }
}

static const char LEFT_OUT[] =
    "{\"format\": \"pinch-scene/1\", \"objects\": [{\"name\": \"held\", \"shape\": {\"type\": \"sphere\", \"radius\": "
    "0.03}, \"mass\": 0.1}, {\"name\": \"other\", \"shape\": {\"type\": \"sphere\", \"radius\": 0.01}, \"mass\": 0.1, "
    "\"position\": [0, 0, 1]}], \"environment\": [{\"shape\": {\"type\": \"box\", \"size\": [1, 1, 0.1]}, "
    "\"position\": "
    "[0, 0, -1], \"stiffness\": {\"normal\": 1e5}, \"friction\": 0.5}], \"fingers\": [{\"point\": [-0.03, 0, 0], "
    "\"normal\": [1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 1e4, \"hertz\": 1e6}, \"friction\": 0.5, "
    "\"closing\": 5e-4}, {\"point\": [0.03, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": "
    "{\"normal\": 1e4}, \"friction\": 0.5, \"closing\": 5e-4, \"tip\": {\"type\": \"box\", \"size\": [0.01, 0.01, "
    "0.01]}}]}";

static void what_is_left_out_is_said(void **state)
{
    (void)state;
    static const char *const expected[] = {"Hertz", "pads", "other objects", "environment"};
    char *folder = program_make_folder(), *scene = program_write_file(folder, "left-out.json", LEFT_OUT);
    program_result r = PINCH(NULL, "solve", scene, "--json"), table = PINCH(NULL, "solve", scene);
    json_t *d = cli_document(&r);
    const json_t *said = json_object_get(d, "not_expressed");
    assert_int_equal(json_array_size(said), 4);
    for (size_t k = 0; k < 4; k++) {
        assert_non_null(strstr(json_string_value(json_array_get(said, k)), expected[k]));
        assert_non_null(strstr(table.out, json_string_value(json_array_get(said, k))));
    }
    json_decref(d);
    program_free(&r);
    program_free(&table);
    char path[512];
    paper_scene(path, "1");
    r = PINCH(NULL, "solve", path, "--json");
    d = cli_document(&r);
    assert_int_equal(json_array_size(json_object_get(d, "not_expressed")), 0);
    json_decref(d);
    program_free(&r);
    free(scene);
    program_remove_folder(folder);
}

/* Fingers so soft that the weight of the box takes it far: 9.81 N on 2 * 2/3 * 100 N/m. */
static void large_displacements_are_remarked(void **state)
{
    (void)state;
    static const char *const masses[] = {"1", "0.01"};
    for (int light = 0; light < 2; light++) {
        char text[768], *folder = program_make_folder();
        snprintf(
            text, sizeof text,
            "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, "
            "0.04]}, \"mass\": %s}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": "
            "\"hard\", \"stiffness\": {\"normal\": 100}, \"friction\": 0.5, \"closing\": 0.3}, {\"point\": [0.02, 0, "
            "0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 100}, \"friction\": 0.5, "
            "\"closing\": 0.3}]}",
            masses[light]);
        free(program_write_file(folder, "soft.json", text));
        program_result r = PINCH(folder, "solve", "soft.json", "--json", "--quiet");
        assert_string_equal(r.err, "");
        json_t *d = cli_document(&r);
        const json_t *remarks = json_object_get(d, "remarks");
        assert_int_equal(json_array_size(remarks), light ? 0 : 1);
        if (!light) assert_non_null(strstr(json_string_value(json_array_get(remarks, 0)), "the statics are linear"));
        json_decref(d);
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* A box between two fingers: on its faces with the left normal tilted by so much, or at an edge. */
static json_t *not_expressed(const char *command, double x, double z, double tilt)
{
    char text[1024], *folder = program_make_folder();
    snprintf(
        text, sizeof text,
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.06, 0.04, 0.1]},"
        " \"mass\": 0.1}, \"simulation\": {\"duration\": 0.01}, \"fingers\": [{\"name\": \"left\", \"point\": [%g, 0,"
        " %g], \"normal\": [%.17g, 0, %.17g], \"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5,"
        " \"closing\": 1e-3}, {\"point\": [0.03, 0, %g], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\":"
        " {\"normal\": 1e4}, \"friction\": 0.5, \"closing\": 1e-3}]}",
        x, z, cos(tilt), sin(tilt), z);
    char *scene = program_write_file(folder, "tilted.json", text);
    program_result r = PINCH(NULL, command, scene, "--json");
    json_t *d = cli_document(&r), *said = json_incref(json_object_get(d, "not_expressed"));
    json_decref(d);
    program_free(&r);
    free(scene);
    program_remove_folder(folder);
    return said;
}

/* The statics go by a finger's normal, a run by the surface: where they differ it is said, with the angle. At an edge
 * the normal may be any between those of the faces. */
static void normals_off_the_surface_are_said(void **state)
{
    (void)state;
    static const char *const commands[] = {"solve", "run"};
    static const char *const texts[] = {
        "the object's surface at left, as the finger's normal is 10 degrees off the surface's",
        "left: its contact's direction, as the finger's normal is 10 degrees off the surface's"};
    for (int k = 0; k < 2; k++) {
        json_t *flat = not_expressed(commands[k], -0.03, 0.01, 0),
               *edge = not_expressed(commands[k], -0.03, -0.05, 0.6);
        json_t *tilted = not_expressed(commands[k], -0.03, 0.01, 0.17453292519943295);
        assert_int_equal(json_array_size(flat) + json_array_size(edge), 0);
        assert_int_equal(json_array_size(tilted), 1);
        assert_string_equal(json_string_value(json_array_get(tilted, 0)), texts[k]);
        json_decref(flat);
        json_decref(edge);
        json_decref(tilted);
    }
}

/* A drive that presses a tip with more than that bears comes to rest nowhere, which the statics do not show. */
static void yielding_tips_are_said(void **state)
{
    (void)state;
    static const char *const presses[] = {"\"normal_force\": 10", "\"normal_force\": 4",
                                          "\"drive\": {\"type\": \"slider\", \"mass\": 0.1, \"force\": 10}"};
    for (int k = 0; k < 3; k++) {
        char text[1024], *folder = program_make_folder();
        snprintf(
            text, sizeof text,
            "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.03}, "
            "\"mass\":"
            " 0.1}, \"gravity\": [0, 0, 0], \"fingers\": [{\"name\": \"left\", \"point\": [-0.03, 0, 0], \"normal\":"
            " [1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5, \"max_force\": 5,"
            " %s}, {\"point\": [0.03, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\":"
            " 1e4}, \"friction\": 0.5}]}",
            presses[k]);
        char *scene = program_write_file(folder, "yields.json", text);
        program_result r = PINCH(NULL, "solve", scene, "--json");
        json_t *d = cli_document(&r);
        const json_t *said = json_object_get(d, "not_expressed");
        assert_int_equal(json_array_size(said), k != 1);
        if (k != 1)
            assert_string_equal(json_string_value(json_array_get(said, 0)),
                                "how left goes on, pressed with 10 N where its tip yields at 5 N");
        json_decref(d);
        program_free(&r);
        free(scene);
        program_remove_folder(folder);
    }
}

/* The forces that the statics find for the end of the schedule are those that the run ends with. */
static void compare_ends(const char *folder, const char *scene)
{
    program_result solved = PINCH(folder, "solve", scene, "--at-end", "--no-reserves", "--json");
    program_result run = PINCH(folder, "run", scene, "--json");
    assert_int_equal(solved.status, 0);
    assert_int_equal(run.status, 0);
    json_t *a = cli_document(&solved), *b = cli_document(&run);
    assert_true(number(a, "moment_s") == number(b, "time_s"));
    assert_true(json_is_null(cli_at(a, "grasp.smallest_friction")));
    assert_true(json_is_null(cli_at(a, "grasp.least_closing")));
    const json_t *expected = json_object_get(a, "fingers"), *fingers = json_object_get(b, "fingers");
    assert_true(json_array_size(fingers) >= 2);
    for (size_t k = 0; k < json_array_size(fingers); k++)
        for (size_t j = 0; j < 3; j++) {
            const json_t *x = json_object_get(json_array_get(expected, k), "force");
            const json_t *y = json_object_get(json_array_get(fingers, k), "force");
            /* the fingers of the run have rolled a little */
            assert_close(json_number_value(json_array_get(y, j)), json_number_value(json_array_get(x, j)),
                         0.02 * number(json_array_get(expected, 0), "normal_force"));
        }
    json_decref(a);
    json_decref(b);
    program_free(&solved);
    program_free(&run);
}

static void the_end_of_a_schedule_is_solved(void **state)
{
    (void)state;
    static const char *const scenes[] = {SCENE("egg.json"), SCENE("cube-spheres.json"), SCENE("mug.json"),
                                         SCENE("pads-reorient.json"), SCENE("example-4.json")};
    for (int i = 0; i < 5; i++) compare_ends(NULL, scenes[i]);
    /* in a hand that has carried the object along and turned it, the weight loads the fingers in another way */
    json_t *turned = json_load_file(SCENE("cube-spheres.json"), 0, NULL);
    assert_int_equal(json_array_append_new(json_object_get(turned, "schedule"),
                                           json_pack("{s:f, s:{s:[f, f, f], s:[f, f, f]}}", "time", 3.0, "hand",
                                                     "translation", 0.1, 0.0, 0.2, "rotation", 0.7, 0.3, 0.0)),
                     0);
    char *folder = program_make_folder(), *document = json_dumps(turned, 0);
    free(program_write_file(folder, "turned.json", document));
    compare_ends(folder, "turned.json");
    program_remove_folder(folder);
    free(document);
    json_decref(turned);
    program_result r = PINCH(NULL, "solve", SCENE("egg.json"), "--time", "0", "--json");
    json_t *d = cli_document(&r);
    assert_true(number(d, "moment_s") == 0);
    json_decref(d);
    program_free(&r);
    cli_refused(PINCH(NULL, "solve", SCENE("egg.json"), "--time", "1", "--at-end"), 2, "expected one of them");
    cli_refused(PINCH(NULL, "solve", SCENE("egg.json"), "--time", "-1"), 2, "--time");
    cli_refused(PINCH(NULL, "solve", SCENE("roll.json"), "--at-end"), 2, "along its path");
}

static void every_legal_pair_solves_example_3(void **state)
{
    (void)state;
    static char *const pairs[][2] = {{"nsnmgk", "lcp"}, {"nsngrk", "lcp"},     {"newton", "lcp"},
                                     {"lemke", "lcp"},  {"nsnmgk", "coulomb"}, {"newton", "coulomb"}};
    char path[512];
    paper_scene(path, "3");
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        program_result r = PINCH(NULL, "solve", path, "--json", "--solver", pairs[i][0], "--formulation", pairs[i][1]);
        json_t *d = cli_document(&r);
        /* the Kaczmarz method alone crawls towards 1e-10 and may say so */
        if (i != 1) assert_int_equal(r.status, 0);
        assert_int_equal(r.status == 0, strcmp(text(d, "status"), "converged") == 0);
        assert_string_equal(text(d, "solver"), pairs[i][0]);
        json_decref(d);
        program_free(&r);
    }
    program_result r = PINCH(NULL, "solve", path, "--json", "--faithful", "--solver", "nsngrk", "--seed", "7");
    assert_int_equal(r.status, 1); /* what is as good as the paper asks for does not pass the verification */
    json_t *d = cli_document(&r);
    assert_true(number(d, "residual") <= 1e-4 && number(d, "residual") > 1e-6);
    assert_true(number(d, "newton_steps") == 0.0);
    json_decref(d);
    program_free(&r);
}

static void impossible_requests_are_usage_errors(void **state)
{
    (void)state;
    char path[512];
    paper_scene(path, "3");
    program_result r = PINCH(NULL, "solve", path, "--solver", "lemke", "--formulation", "coulomb");
    assert_int_equal(r.status, 2);
    assert_string_equal(r.out, "");
    assert_non_null(strstr(r.err, "lemke with lcp"));
    program_free(&r);
    r = PINCH(NULL, "solve", path, "--faithful", "--formulation", "coulomb");
    assert_int_equal(r.status, 2);
    program_free(&r);
    r = PINCH(NULL, "solve", "no-such-scene.json");
    assert_int_equal(r.status, 2);
    program_free(&r);
    r = PINCH(NULL, "lcp", ".");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, ".: cannot be read: Is a directory"));
    program_free(&r);
    r = PINCH(NULL, "bench", "step", "--min-size", "100", "--max-size", "3");
    assert_int_equal(r.status, 2);
    assert_string_equal(r.out, "");
    assert_non_null(strstr(r.err, "--max-size: expected at least the --min-size of 100, got 3"));
    program_free(&r);
    r = PINCH(NULL, "bench", "no-such-benchmark");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, "paper"));
    program_free(&r);
}

static const char TWO_FINGERS[] =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, %s], \"object\": {\"shape\": {\"type\": \"box\", \"size\": "
    "[0.1, 0.1, "
    "0.1]}, \"mass\": 1, \"torque\": [%s, 0, 0]}, \"fingers\": ["
    "{\"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 1000}, "
    "\"friction\": 0.5, \"closing\": 0.01},"
    "{\"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 1000}, "
    "\"friction\": 0.5, \"closing\": 0.01}]}";

static void a_grasp_that_does_not_hold_says_why(void **state)
{
    (void)state;
    static const struct {
        const char *gravity, *torque, *status;
        double load_fraction;
    } cases[] = {{"-9.0", "0", "converged", 1.0}, {"-12.5", "0", "unstable", 0.8}, {"0", "0.1", "infeasible", 0.0}};
    char *folder = program_make_folder();
    for (int i = 0; i < 3; i++) {
        char scene[2048];
        snprintf(scene, sizeof scene, TWO_FINGERS, cases[i].gravity, cases[i].torque);
        char *file = program_write_file(folder, "scene.json", scene);
        program_result r = PINCH(NULL, "solve", file, "--json");
        assert_int_equal(r.status, i == 0 ? 0 : 1);
        json_t *d = cli_document(&r);
        assert_string_equal(text(d, "status"), cases[i].status);
        assert_close(number(d, "load_fraction"), cases[i].load_fraction, 1e-3);
        const json_t *finger = json_array_get(json_object_get(d, "fingers"), 0);
        assert_int_equal(json_is_null(json_object_get(finger, "normal_force")), i > 0);
        assert_int_equal(json_is_null(json_object_get(d, "twist")), i == 0);
        const json_t *limits = json_object_get(json_object_get(d, "grasp"), "limits");
        const json_t *most = json_object_get(limits, "largest_load_factor");
        if (i == 1) assert_close(number(most, "holds"), 0.8, 2e-6); /* what is missing, as a study says it */
        if (i == 0) {
            const json_t *grasp = json_object_get(d, "grasp");
            assert_close(number(grasp, "smallest_friction"), 0.9, 2e-6);
            assert_close(number(grasp, "largest_load_factor"), 10.0 / 9.0, 2e-6);
            assert_close(number(grasp, "least_closing"), 0.9, 2e-6);
            const json_t *friction = json_object_get(limits, "smallest_friction");
            const json_t *load = json_object_get(limits, "largest_load_factor");
            assert_string_equal(text(friction, "status"), "converged");
            assert_string_equal(text(load, "status"), "converged");
            assert_true(number(friction, "holds") == number(grasp, "smallest_friction"));
            assert_true(number(load, "holds") == number(grasp, "largest_load_factor"));
            assert_true(number(friction, "fails") < 0.9 && number(load, "fails") > 10.0 / 9.0);
        }
        json_decref(d);
        program_free(&r);
        free(file);
    }
    program_remove_folder(folder);
}

/* A ball on one finger without friction, lifted by more than its weight, goes up, and so says the answer. */
static void the_motion_is_the_way_in_which_the_object_escapes(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *file = program_write_file(
        folder, "up.json",
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.05}, "
        "\"mass\": 0.5, \"force\": [0, 0, 10]}, \"fingers\": [{\"name\": \"below\", \"point\": [0, 0, -0.05], "
        "\"normal\": [0, 0, 1], \"model\": \"frictionless\", \"stiffness\": {\"normal\": 20000}}]}");
    program_result r = PINCH(NULL, "solve", file, "--json");
    json_t *d = cli_document(&r);
    assert_string_equal(text(d, "status"), "infeasible");
    for (size_t j = 0; j < 6; j++)
        assert_close(json_number_value(json_array_get(json_object_get(d, "twist"), j)), j == 2 ? 1.0 : 0.0, 1e-9);
    assert_null(strstr(r.out, "-0,"));
    json_decref(d);
    program_free(&r);
    r = PINCH(NULL, "solve", file);
    assert_non_null(strstr(r.out, "no finger can resist the motion (0, 0, 1) m, (0, 0, 0) rad"));
    program_free(&r);
    r = PINCH(NULL, "solve", file, "--json", "--no-reserves");
    d = cli_document(&r);
    assert_true(json_is_null(cli_at(d, "grasp.limits.least_closing.status"))); /* nobody has looked */
    json_decref(d);
    program_free(&r);
    free(file);
    program_remove_folder(folder);
}

/* A pinch along x by 10 N and 10 N with friction 0.5: 10 N along y or z is all that it holds, whichever way; along x
 * the fingers take it without friction. */
static void reserves_by_direction(void **state)
{
    (void)state;
    char scene[2048], *folder = program_make_folder();
    snprintf(scene, sizeof scene, TWO_FINGERS, "-4.0", "0");
    char *file = program_write_file(folder, "scene.json", scene);
    program_result r = PINCH(NULL, "solve", file, "--json", "--directions");
    assert_int_equal(r.status, 0);
    json_t *d = cli_document(&r);
    const json_t *grasp = json_object_get(d, "grasp"), *list = json_object_get(grasp, "directions");
    assert_int_equal(json_array_size(list), 6);
    for (size_t k = 0; k < 6; k++) {
        const json_t *one = json_array_get(list, k), *way = json_object_get(one, "direction");
        const json_t *least = json_object_get(one, "least_closing"),
                     *most = json_object_get(one, "largest_load_factor");
        assert_true(json_number_value(json_array_get(way, k / 2)) == (k % 2 ? -1.0 : 1.0));
        assert_string_equal(text(least, "status"), "converged");
        if (k / 2 == 0) continue;
        assert_close(number(least, "holds") * number(most, "holds"), 1.0, 4e-6);
        assert_close(number(json_object_get(one, "smallest_friction"), "holds"), number(least, "holds"), 1e-5);
    }
    /* the scene's own load is among them */
    assert_close(number(json_object_get(json_array_get(list, 5), "least_closing"), "holds"),
                 number(grasp, "least_closing"), 4e-6);
    json_decref(d);
    program_free(&r);
    r = PINCH(NULL, "solve", file, "--directions");
    assert_non_null(strstr(r.out, "least grip"));
    program_free(&r);
    free(file);
    program_remove_folder(folder);
}

static json_t *lcp(const char *folder, const char *problem, char *solver, int status)
{
    char *file = program_write_file(folder, "problem.json", problem);
    program_result r = PINCH(NULL, "lcp", file, "--json", "--solver", solver, "--max-iterations", "2000");
    assert_int_equal(r.status, status);
    json_t *d = cli_document(&r);
    program_free(&r);
    free(file);
    return d;
}

static void a_bare_lcp_by_every_solver(void **state)
{
    (void)state;
    static char *const solvers[] = {"nsnmgk", "nsngrk", "newton", "lemke", "pgs"};
    char *folder = program_make_folder();
    for (int s = 0; s < 5; s++) {
        json_t *d = lcp(folder, "{\"M\": [[2, 1], [1, 2]], \"q\": [-5, -6]}", solvers[s], 0);
        const json_t *z = json_object_get(d, "z");
        assert_close(json_number_value(json_array_get(z, 0)), 4.0 / 3.0, 1e-9);
        assert_close(json_number_value(json_array_get(z, 1)), 7.0 / 3.0, 1e-9);
        assert_string_equal(text(d, "solver"), solvers[s]);
        json_decref(d);

        /* no z makes -z - 1 >= 0 */
        d = lcp(folder, "{\"M\": [[-1]], \"q\": [-1]}", solvers[s], 1);
        assert_string_equal(text(d, "status"), "infeasible");
        assert_true(json_is_null(json_array_get(json_object_get(d, "z"), 0)));
        json_decref(d);

        /* feasible, without a complementary solution */
        d = lcp(folder, "{\"M\": [[0, 1], [0, 0]], \"q\": [-1, 1]}", solvers[s], 1);
        if (s == 3) assert_string_equal(text(d, "status"), "ray");
        assert_string_not_equal(text(d, "status"), "converged");
        assert_string_not_equal(text(d, "status"), "infeasible");
        json_decref(d);
    }
    program_remove_folder(folder);
}

static void broken_problems_are_refused(void **state)
{
    (void)state;
    static const char *const problems[] = {"",
                                           "{",
                                           "[]",
                                           "{\"M\": [[1]]}",
                                           "{\"q\": [1]}",
                                           "{\"M\": [[1]], \"q\": []}",
                                           "{\"M\": [[1, 2]], \"q\": [1]}",
                                           "{\"M\": [[1], [2]], \"q\": [1]}",
                                           "{\"M\": [[\"1\"]], \"q\": [1]}",
                                           "{\"M\": [[1]], \"q\": [null]}",
                                           "{\"M\": 1, \"q\": [1]}",
                                           "{\"M\": [[1]], \"q\": [1], \"x\": 0}",
                                           "{\"M\": [[1e999]], \"q\": [1]}"};
    char *folder = program_make_folder();
    for (size_t i = 0; i < sizeof problems / sizeof *problems; i++) {
        char *file = program_write_file(folder, "problem.json", problems[i]);
        program_result r = PINCH(NULL, "lcp", file, "--json");
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        assert_non_null(strstr(r.err, "problem.json"));
        assert_non_null(strstr(r.err, "expected"));
        program_free(&r);
        free(file);
    }
    program_result r = PINCH(NULL, "lcp", "no-such-file.json");
    assert_int_equal(r.status, 2);
    program_free(&r);
    program_remove_folder(folder);
}

/* Five figures, each as SVG, PNG and numbers. An SVG figure is XML whose labels are those of the curves; a PNG figure
 * has the size that its head says, ink on it, and ends as it should. */
static void check_figures(const char *folder)
{
    char path[600];
    assert_int_equal(program_count_entries(folder), 15);
    snprintf(path, sizeof path, "%s/example-4-8-faces.svg", folder);
    char *text = program_read_file(path);
    assert_true(strncmp(text, "<svg ", 5) == 0 && strstr(text, "</svg>\n"));
    assert_non_null(strstr(text, ">NSNMGK</text>"));
    assert_non_null(strstr(text, ">NSNGRK (seed 1)</text>"));
    assert_non_null(strstr(text, ">10<tspan")); /* powers of ten are raised */
    assert_null(strstr(text, "nan"));
    free(text);
    static const unsigned char head[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0,  13, 'I',
                                         'H',  'D', 'R', 0,   0,  5,  10, 0,  0, 3, 12, 8,  2};
    unsigned char bytes[sizeof head];
    snprintf(path, sizeof path, "%s/example-4-8-faces.png", folder);
    FILE *stream = fopen(path, "rb");
    assert_non_null(stream);
    assert_int_equal(fread(bytes, 1, sizeof bytes, stream), sizeof bytes);
    assert_memory_equal(bytes, head, sizeof head); /* 1290 by 780 */
    assert_int_equal(fseek(stream, -8, SEEK_END), 0);
    assert_true(ftell(stream) > 8000);
    assert_int_equal(fread(bytes, 1, 8, stream), 8);
    assert_memory_equal(bytes, "IEND\xae\x42\x60\x82", 8);
    fclose(stream);
}

/* test_paper solves the problems with other numbers of faces. */
static void the_paper_s_benchmark_has_a_row_for_every_problem(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *const faces[] = {"4", "8"};
    for (int k = 0; k < (SANITIZED ? 1 : 2); k++) {
        program_result r =
            PINCH(NULL, "bench", "paper", "--json", "--budget", "0.01", "--faces", faces[k], "--plot", folder);
        assert_int_equal(r.status, 0);
        json_t *d = cli_document(&r);
        const json_t *rows = json_object_get(d, "rows");
        assert_int_equal(json_array_size(rows), 5);
        for (size_t i = 0; i < json_array_size(rows); i++) {
            const json_t *row = json_array_get(rows, i), *nsngrk = json_object_get(row, "nsngrk");
            const json_t *nsnmgk = json_object_get(row, "nsnmgk"), *standard = json_object_get(row, "default");
            assert_true(number(nsnmgk, "iterations") < number(nsngrk, "iterations"));
            assert_true(number(nsnmgk, "residual") <= 1e-4 && number(nsngrk, "residual") <= 1e-4);
            assert_true(number(standard, "residual") <= 1e-12);
            assert_true(number(nsnmgk, "time_s") > 0.0 && number(row, "speedup") > 0.0);
            assert_non_null(json_object_get(row, "lemke"));
        }
        json_decref(d);
        program_free(&r);
    }
    check_figures(folder);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_is_there),
        cmocka_unit_test(what_is_left_out_is_said),
        cmocka_unit_test(large_displacements_are_remarked),
        cmocka_unit_test(normals_off_the_surface_are_said),
        cmocka_unit_test(yielding_tips_are_said),
        cmocka_unit_test(the_end_of_a_schedule_is_solved),
        cmocka_unit_test(every_legal_pair_solves_example_3),
        cmocka_unit_test(impossible_requests_are_usage_errors),
        cmocka_unit_test(a_grasp_that_does_not_hold_says_why),
        cmocka_unit_test(the_motion_is_the_way_in_which_the_object_escapes),
        cmocka_unit_test(reserves_by_direction),
        cmocka_unit_test(a_bare_lcp_by_every_solver),
        cmocka_unit_test(broken_problems_are_refused),
        cmocka_unit_test(the_paper_s_benchmark_has_a_row_for_every_problem),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
