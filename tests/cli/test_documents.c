/* Every JSON document of the command is as its schema says: of answers, of failures, and of interrupted or empty runs.
 */
#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/program.h"
#include "support/schema.h"

#include <stdio.h>
#include <string.h>

static json_t *schema_of(const char *name)
{
    char path[512];
    json_error_t error;
    snprintf(path, sizeof path, PINCH_SOURCE_DIR "/assets/schema/pinch-%s-1.json", name);
    json_t *schema = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    if (!schema) fail_msg("%s:%d: %s", path, error.line, error.text);
    return schema;
}

/* Runs the command, whatever its exit status, and checks the document that it prints. */
static void follows(const char *name, const char *const words[])
{
    json_t *schema = schema_of(name);
    program_result r = command_run(NULL, words);
    json_t *document = json_loads(r.out, JSON_REJECT_DUPLICATES, NULL);
    if (!document) fail_msg("%s: no document: %s", words[0], r.err);
    assert_int_equal(schema_faults(schema, document), 0);
    assert_int_equal(json_object_del(document, json_object_get(document, "rows") ? "rows" : "status"), 0);
    assert_true(schema_faults(schema, document) > 0); /* the schema asks for what matters */
    json_decref(document);
    json_decref(schema);
    program_free(&r);
}

#define FOLLOWS(name, ...) follows(name, (const char *const[]){__VA_ARGS__, "--json", NULL})

static void test_run(void **state)
{
    (void)state;
    FOLLOWS("run", "run", SCENE("lift.json"), "--duration", "0.2");
    FOLLOWS("run", "run", SCENE("example-4.json"), "--duration", "0.1");
    FOLLOWS("run", "run", SCENE("egg.json"), "--duration", "0");
    FOLLOWS("run", "run", SCENE("twist.json"), "--duration", "0.1", "--contact-solver", "quickstep");
    FOLLOWS("run", "run", SCENE("example-3.json"), "--duration", "0.1", "--max-iterations", "1");
}

static void test_solve(void **state)
{
    (void)state;
    FOLLOWS("solve", "solve", SCENE("example-3.json"), "--at-end");
    FOLLOWS("solve", "solve", SCENE("example-3.json"), "--formulation", "lcp", "--solver", "pgs", "--max-iterations",
            "3");
    FOLLOWS("solve", "solve", SCENE("paper/example-2.json"), "--faithful", "--no-reserves");
}

static void test_lcp(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512];
    static const char *const texts[] = {"{\"M\": [[2, 1], [1, 2]], \"q\": [-1, -1]}",
                                        "{\"M\": [[0, -1], [1, 0]], \"q\": [-1, -1]}"};
    for (int i = 0; i < 2; i++) {
        snprintf(file, sizeof file, "%s/lcp.json", folder);
        FILE *stream = fopen(file, "w");
        assert_non_null(stream);
        assert_true(fputs(texts[i], stream) >= 0 && fclose(stream) == 0);
        FOLLOWS("lcp", "lcp", file, "--solver", "lemke");
    }
    program_remove_folder(folder);
}

static void test_bench(void **state)
{
    (void)state;
    FOLLOWS("bench", "bench", "paper", "--faithful", "--faces", "4");
    FOLLOWS("bench", "bench", "step", "--max-size", "2", "--budget", "0.02");
    FOLLOWS("bench", "bench", "collide", "--budget", "0.02");
}

static void test_stats(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512], *program = exec_program("stack");
    snprintf(file, sizeof file, "%s/stats.json", folder);
    program_result r = PINCH(NULL, "exec", "--stats", file, "--", program, "--steps", "20");
    assert_int_equal(r.status, 0);
    program_free(&r);
    json_t *schema = schema_of("stats"), *document = json_load_file(file, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(document);
    assert_int_equal(schema_faults(schema, document), 0);
    json_decref(document);
    json_decref(schema);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_run),   cmocka_unit_test(test_solve), cmocka_unit_test(test_lcp),
        cmocka_unit_test(test_bench), cmocka_unit_test(test_stats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
