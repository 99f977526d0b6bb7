/*
 * Islands that `pinch run` and `pinch exec` record are solved again by `pinch replay`, with the same bits; and files
 * that are no recordings are refused.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/schema.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void path_of(const char *folder, int number, char path[512])
{
    snprintf(path, 512, "%s/island-%06d.json", folder, number);
}

static json_t *load(const char *path)
{
    json_error_t error;
    json_t *document = json_load_file(path, 0, &error);
    assert_non_null(document);
    return document;
}

/* Replays a file, which has to end with `status`. */
static json_t *replay(const char *path, int status)
{
    program_result r = PINCH(NULL, "replay", path, "--json");
    if (r.status != status) print_error("%s: %d %s\n", path, r.status, r.err);
    assert_int_equal(r.status, status);
    json_t *document = cli_document(&r);
    program_free(&r);
    return document;
}

/* Every recording in the folder follows the schema, and ends when it is replayed as it ended then. Returns how many of
 * them had a memory. */
static int all_replay(const char *folder, int count)
{
    json_t *schema = load(PINCH_SOURCE_DIR "/assets/schema/pinch-island-1.json");
    int memories = 0;
    for (int i = 1; i <= count; i++) {
        char path[512];
        path_of(folder, i, path);
        json_t *recorded = load(path);
        assert_int_equal(schema_faults(schema, recorded), 0);
        memories += json_is_object(cli_at(recorded, "problem.memory"));
        const char *status = json_string_value(cli_at(recorded, "ended.status"));
        json_t *document = replay(path, strcmp(status, "converged") == 0 ? 0 : 1);
        if (!json_is_true(cli_at(document, "same_bits"))) print_error("%s: other bits\n", path);
        assert_true(json_is_true(cli_at(document, "same_bits")));
        assert_string_equal(json_string_value(cli_at(document, "status")), status);
        json_decref(document);
        json_decref(recorded);
    }
    json_decref(schema);
    return memories;
}

/* A solver that may take one iteration fails in every step that takes more, as often as the island is tried. */
static void failed_islands_of_a_scene(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--max-iterations", "1", "--duration", "0.3",
                             "--record", folder, "--quiet");
    program_free(&r);
    int count = program_count_entries(folder);
    assert_true(count >= 5);
    (void)all_replay(folder, count);

    /* the forces that the solver ended with are there, and with enough iterations it finds the answer */
    path_of(folder, 1, path);
    json_t *document = replay(path, 1);
    const json_t *contacts = cli_at(document, "contacts");
    double largest = 0;
    for (size_t i = 0; i < json_array_size(contacts); i++) {
        const json_t *force = json_array_get(json_object_get(json_array_get(contacts, i), "force"), 0);
        assert_true(json_is_real(force));
        largest = fmax(largest, json_real_value(force));
    }
    assert_true(json_array_size(contacts) > 0 && largest > 0);
    assert_true(json_is_false(cli_at(document, "verified")));
    json_decref(document);
    r = PINCH(NULL, "replay", path, "--json", "--max-iterations", "200");
    assert_int_equal(r.status, 0);
    document = cli_document(&r);
    assert_true(json_is_true(cli_at(document, "verified")) && json_is_null(cli_at(document, "same_bits")));
    assert_string_equal(json_string_value(cli_at(document, "recorded.status")), "max_iterations");
    json_decref(document);
    program_free(&r);
    program_remove_folder(folder);
}

static void solves_of_a_scene(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    program_result r = PINCH(NULL, "run", SCENE("hands/parallel-gripper-lift.json"), "--duration", "0.5", "--record",
                             folder, "--record-all", "--quiet");
    assert_int_equal(r.status, 0);
    program_free(&r);
    int count = program_count_entries(folder);
    assert_int_equal(count, 100);                /* and no more */
    assert_true(all_replay(folder, count) > 20); /* what is remembered from step to step is recorded, too */
    /* which solvers a hand's island has, as the help says */
    static const char *const solvers[] = {"nsnmgk", "newton", "nsngrk", "lemke", "pgs"};
    char last[512];
    path_of(folder, count, last);
    for (int i = 0; i < 5; i++) {
        r = PINCH(NULL, "replay", last, "--solver", solvers[i]);
        assert_int_equal(r.status, i < 2 ? 0 : 2);
        program_free(&r);
    }
    r = PINCH(NULL, "replay", "--help");
    assert_non_null(strstr(r.out, "nsnmgk and newton do every island. nsngrk does not do some of hands"));
    program_free(&r);
    program_remove_folder(folder);
}

/* Contacts by surface parameters, joints, motors: what another program's islands have. */
static void islands_of_a_program(void **state)
{
    (void)state;
    static char steps[] = "--steps", forty[] = "40";
    static char *const names[] = {"spheres", "ragdoll", "gripper"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *folder = program_make_folder();
        program_result r = EXEC("--record", folder, "--record-all", "--", exec_program(names[i]), steps, forty);
        assert_int_equal(r.status, 0);
        program_free(&r);
        int count = program_count_entries(folder);
        assert_true(count > 0);
        (void)all_replay(folder, count);
        program_remove_folder(folder);
    }
}

/*
 * Islands of random jointed worlds on which the solver has failed, for a reason each: torn loops and contacts beside
 * them; a stop that contradicts hinges said twice, whose force is large (jointed-stop); bounds that were changed in
 * circles (jointed-circle); a contact that jams a torn mechanism for one step of the iteration (jointed-far-step);
 * motors' rows that are wrong between their bounds and at one of them while contacts slip (jointed-slip and
 * jointed-toggle), so that one bound was changed back and forth until the budget was used up; contacts beside rows that
 * contradict each other, whose multipliers are so large that contacts missed their law by 4e-7 N for
 * rounding alone (jointed-contradiction); such a row that comes to its bound after its multiplier was put aside
 * (jointed-one-sided); a finger whose motors work against dry friction, before whose joints other bodies bear rounding
 * (hand-dry-friction).
 */
static void islands_that_have_failed(void **state)
{
    (void)state;
    static const char *const files[] = {
        "jointed-closed", "jointed-contacts", "jointed-stop",      "jointed-circle",        "jointed-far-step",
        "jointed-slip",   "jointed-toggle",   "hand-dry-friction", "jointed-contradiction", "jointed-one-sided"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/tests/cli/recorded/%s.json", PINCH_SOURCE_DIR, files[i]);
        json_t *document = replay(path, 0);
        const json_t *rows = cli_at(document, "joint_rows");
        assert_true(json_is_true(cli_at(document, "verified")));
        assert_true(json_array_size(rows) > 30);
        for (size_t k = 0; k < json_array_size(rows); k++)
            assert_true(json_is_number(json_object_get(json_array_get(rows, k), "force")));
        json_decref(document);
    }
}

/* One message with file, line, place and what was expected. */
static void refused(const char *path, const char *says)
{
    program_result r = PINCH(NULL, "replay", path);
    if (!strstr(r.err, says)) print_error("expected \"%s\", got %s", says, r.err);
    char *end = strchr(r.err, '\n');
    assert_true(end && !end[1]);
    cli_refused(r, 2, says);
}

static void broken_files(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to, *says;
    } cases[] = {
        {"pinch-island/1", "pinch-island/2", "format: expected pinch-island/1, got \"pinch-island/2\""},
        {"\"step\": 0.001", "\"step\": -1", "problem.step: expected a number > 0 (s), got -1"},
        {"\"mass\": ", "\"weight\": ", "problem.bodies[0].weight: expected a known key"},
        {"\"model\": \"", "\"model\": \"x", "problem.contacts[0].model: expected frictionless, hard, soft or rolling"},
        {"\"bodies\": [-1, ", "\"bodies\": [7, ",
         "problem.contacts[0].bodies[0]: expected the place of a body, 0 to 0"},
        {"\"depth\": ", "\"depth\": null, \"x\": ", "problem.contacts[0].x: expected a known key"},
        {"\"seed\": \"1\"", "\"seed\": 1", "solver.seed: expected a whole number as a text, got 1"},
        {"\"tolerance\": 1e-10", "\"tolerance\": 1e-20", "solver.goal: expected a number not above the tolerance"},
        {"\"normal\": [", "\"normal\": [2, ",
         "problem.contacts[0].normal: expected a list of 3 numbers, got a list of 4"},
        {"\"radius\": ", "\"radius\": -", "problem: expected values in the ranges"},
        {"\"velocities\": [", "\"velocities\": [[], ", "ended.velocities: expected a list of 1, got a list of 2"},
        {"}", "", "expected valid JSON"},
    };
    char *folder = program_make_folder(), path[512];
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--duration", "0.002", "--record", folder,
                             "--record-all", "--quiet");
    program_free(&r);
    path_of(folder, 1, path);
    char *text = program_read_file(path), *broken = malloc(strlen(text) + 64);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *at = strstr(text, cases[i].from);
        assert_non_null(at);
        sprintf(broken, "%.*s%s%s", (int)(at - text), text, cases[i].to, at + strlen(cases[i].from));
        char *file = program_write_file(folder, "broken.json", broken);
        refused(file, cases[i].says);
        free(file);
    }
    for (size_t length = 0; length < strlen(text); length += strlen(text) / 40 + 1) { /* cut short */
        sprintf(broken, "%.*s", (int)length, text);
        char *file = program_write_file(folder, "broken.json", broken);
        refused(file, "broken.json:");
        free(file);
    }
    refused("/no/such/file", "/no/such/file: expected a readable recorded island");
    cli_refused(PINCH(NULL, "run", SCENE("example-3.json"), "--record", "/dev/null"), 2, "--record: expected a folder");
    cli_refused(EXEC("--record", "/no/such/folder", "--", "/bin/true"), 2, "--record: expected a folder");
    free(broken);
    free(text);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failed_islands_of_a_scene),
        cmocka_unit_test(solves_of_a_scene),
        cmocka_unit_test(islands_of_a_program),
        cmocka_unit_test(islands_that_have_failed),
        cmocka_unit_test(broken_files),
    };
    return cmocka_run_group_tests_name("pinch replay", tests, NULL, NULL);
}
