/* What the command says at the edges: numbers that do not exist, answers that were not verified, points off a surface.
 */
#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void assert_says(const char *text, const char *what)
{
    if (!strstr(text, what)) fail_msg("\"%s\" is not in: %s", what, text);
}

/* A number that does not exist is a dash, and an infinite one has a word. */
static void assert_no_nan(program_result r)
{
    for (const char *p = r.out; (p = strpbrk(p, "ni")); p++) {
        bool starts = p == r.out || strchr(" (-\n", p[-1]);
        if (starts && (strncmp(p, "nan", 3) == 0 || strncmp(p, "inf ", 4) == 0 || strncmp(p, "inf\n", 4) == 0))
            fail_msg("a number that is none is printed: %s", r.out);
    }
    program_free(&r);
}

static void failed_solves_are_told(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("twist.json"), "--max-iterations", "1", "--duration", "0.05");
    assert_int_equal(r.status, 1);
    assert_says(r.out, "verified: no");
    assert_says(r.out, "left to ODE's solver 49 times");
    assert_says(r.out, "--record DIR");
    program_free(&r);
}

static void numbers_for_people(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *lcp = program_write_file(folder, "lcp.json", "{\"M\": [[0, -1], [1, 0]], \"q\": [-1, -1]}");
    assert_no_nan(PINCH(NULL, "run", SCENE("egg.json"), "--duration", "0"));
    assert_no_nan(PINCH(NULL, "lcp", lcp, "--solver", "lemke"));
    assert_no_nan(PINCH(NULL, "solve", SCENE("pads-shake.json"), "--formulation", "lcp", "--solver", "pgs",
                        "--max-iterations", "3"));
    assert_no_nan(PINCH(NULL, "solve", SCENE("example-1.json"), "--at-end"));
    assert_no_nan(PINCH(NULL, "compare", SCENE("twist.json"), "--duration", "0", "--samples", "0"));
    assert_no_nan(PINCH(NULL, "bench", "pyramid", "--max-size", "55", "--budget", "0.02"));
    assert_no_nan(PINCH(NULL, "hand", PINCH_SOURCE_DIR "/assets/hands/robotiq-like.xml"));
    assert_no_nan(
        PINCH(NULL, "replay", PINCH_SOURCE_DIR "/tests/cli/recorded/jointed-stop.json", "--max-iterations", "1"));
    free(lcp);
    program_remove_folder(folder);
}

/* The paper's own procedure stops at 1e-4, which the verification does not take for an answer. */
static void faithful_is_not_verified(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "solve", SCENE("paper/example-2.json"), "--faithful", "--json");
    assert_int_equal(r.status, 1);
    json_t *document = json_loads(r.out, 0, NULL);
    assert_string_equal(json_string_value(cli_at(document, "status")), "converged");
    assert_true(json_is_false(cli_at(document, "verification.passed")));
    json_decref(document);
    program_free(&r);
    r = PINCH(NULL, "solve", SCENE("paper/example-2.json"), "--faithful");
    assert_says(r.out, "NOT verified");
    program_free(&r);
}

/* A method that ran out of iterations has shown nothing. */
static void no_escape_without_proof(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "solve", SCENE("pads-shake.json"), "--formulation", "lcp", "--solver", "pgs",
                             "--max-iterations", "3", "--json");
    assert_int_equal(r.status, 1);
    json_t *document = json_loads(r.out, 0, NULL);
    assert_string_equal(json_string_value(cli_at(document, "status")), "max_iterations");
    assert_true(json_is_null(cli_at(document, "twist")));
    json_decref(document);
    program_free(&r);
}

/* One finger's point stands `off` metres outside a box, or a ball, whose surface is at x = 0.05. */
static program_result validate(const char *shape, double off, const char *snap)
{
    static const char SCENE_TEXT[] =
        "{\"format\": \"pinch-scene/1\", \"name\": \"off\", \"object\": {\"shape\": %s, \"mass\": 1,"
        " \"position\": [0, 0, 1], \"orientation\": [0.9238795325112867, 0, 0, 0.3826834323650898]},"
        " \"fingers\": [{\"point\": [%.17g, %.17g, 1], \"normal\": [-0.7071067811865476, -0.7071067811865476, 0],"
        " \"model\": \"frictionless\", \"stiffness\": {\"normal\": 1000}%s}]}";
    char text[1024], *folder = program_make_folder();
    double at = (0.05 + off) * 0.70710678118654757; /* the object is turned by 45 degrees about z */
    snprintf(text, sizeof text, SCENE_TEXT, shape, at, at, snap);
    char *file = program_write_file(folder, "off.json", text);
    program_result r = PINCH(NULL, "validate", file, "--print");
    free(file);
    program_remove_folder(folder);
    return r;
}

static void points_off_the_surface(void **state)
{
    (void)state;
    static const char *const shapes[] = {"{\"type\": \"box\", \"size\": [0.1, 0.2, 0.1]}",
                                         "{\"type\": \"ellipsoid\", \"radii\": [0.05, 0.08, 0.03]}"};
    for (int i = 0; i < 2; i++) {
        program_result r = validate(shapes[i], 0.0005, "");
        assert_int_equal(r.status, 2);
        assert_says(r.err, "a gap of 0.0005 m outside it; the nearest point of the surface is [0.0353553391, "
                           "0.0353553391, 1]");
        program_free(&r);
        r = validate(shapes[i], 0.0005, ", \"snap\": true");
        assert_int_equal(r.status, 0);
        json_t *scene = json_loads(r.out, 0, NULL);
        assert_close(
            json_number_value(json_array_get(json_object_get(json_array_get(cli_at(scene, "fingers"), 0), "point"), 0)),
            0.035355339059327379, 1e-9);
        json_decref(scene);
        program_free(&r);
        r = validate(shapes[i], 0.01, ", \"snap\": true");
        assert_int_equal(r.status, 2);
        assert_says(r.err, "too far for \"snap\"");
        program_free(&r);
    }
    for (int on = 0; on < 2; on++) { /* the surface */
        program_result r = validate(shapes[0], on ? 0 : 0.0005, ", \"snap\": 1");
        assert_int_equal(r.status, 2);
        assert_says(r.err, "snap: expected true or false");
        program_free(&r);
    }
}

/* Runs the command on a terminal of its own, for two seconds at most, and returns what the terminal got. */
static program_result on_a_terminal(const char *command)
{
    char line[1024];
    snprintf(line, sizeof line, "exec timeout -s INT 2 '%s' %s", PINCH_EXECUTABLE, command);
    return program_run(NULL, (char *[]){"/usr/bin/script", "-qec", line, "/dev/null", NULL});
}

/* Long work tells how far it is after a second, on a terminal alone. */
static void long_work_tells_how_far_it_is(void **state)
{
    (void)state;
    static const struct {
        const char *command, *says;
    } cases[] = {
        {"compare --json --jobs 1 " SCENE("lift.json") " " SCENE("pads-shake.json"), " s simulated, "},
        {"bench hands --min-size 1000 --max-size 1000 --budget 3 --json", "hands, size 1000: "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        program_result r = on_a_terminal(cases[i].command);
        assert_says(r.out, cases[i].says);
        assert_says(r.out, " so far, about ");
        assert_says(r.out, " left\033[K");
        program_free(&r);
    }
}

/* An option that would do nothing is refused, with the one that it lacks. */
static void options_without_effect(void **state)
{
    (void)state;
    static const char egg[] = SCENE("egg.json"), hand[] = PINCH_SOURCE_DIR "/assets/studies/step-size.json";
    cli_refused(PINCH(NULL, "run", egg, "--fps", "30"), 2, "--fps: expected --view or --gltf with it");
    cli_refused(PINCH(NULL, "run", egg, "--record-all"), 2, "--record-all: expected --record with it");
    cli_refused(PINCH(NULL, "run", egg, "--every", "10"), 2, "--every: expected --checkpoint with it");
    cli_refused(PINCH(NULL, "exec", "--record-all", "--", "true"), 2, "--record-all: expected --record with it");
    cli_refused(PINCH(NULL, "solve", egg, "--unit"), 2, "--unit: expected --faithful with it");
    static const char *const of_pinch[][2] = {
        {"--solver", "nsnmgk"}, {"--formulation", "lcp"}, {"--tolerance", "1e-9"}, {"--max-iterations", "3"},
        {"--faces", "8"},       {"--record", "r"},        {"--no-newton", NULL}};
    for (size_t i = 0; i < sizeof of_pinch / sizeof *of_pinch; i++)
        cli_refused(PINCH(NULL, "run", egg, "--contact-solver", "quickstep", of_pinch[i][0], of_pinch[i][1]), 2,
                    "expected Pinch as contact solver");
    cli_refused(PINCH(NULL, "compare", egg, "--contact-solver", "worldstep", "--quickstep-iterations", "5"), 2,
                "--quickstep-iterations: expected --contact-solver quickstep");
    cli_refused(PINCH(NULL, "study", hand, "--out", "r.sqlite", "--fps", "30"), 2, "--fps: expected --view or --gltf");
    cli_refused(PINCH(NULL, "study", hand, "--out", "r.sqlite", "--view", "v.html"), 2, "--view: expected --trial K");
    cli_refused(PINCH(NULL, "study", hand, "--out", "r.sqlite", "--refine", "3"), 2, "--refine: expected --beside");
    cli_refused(PINCH(NULL, "study", hand, "--trial", "1", "--out", "r.sqlite"), 2, "--out: expected without --trial");
    cli_refused(PINCH(NULL, "study", hand, "--trial", "1", "--report", "r.html"), 2, "--report: expected without");
    cli_refused(PINCH(NULL, "study", hand, "--print", "--json"), 2, "--json: expected without --print");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failed_solves_are_told),        cmocka_unit_test(numbers_for_people),
        cmocka_unit_test(long_work_tells_how_far_it_is), cmocka_unit_test(faithful_is_not_verified),
        cmocka_unit_test(no_escape_without_proof),       cmocka_unit_test(points_off_the_surface),
        cmocka_unit_test(options_without_effect),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
