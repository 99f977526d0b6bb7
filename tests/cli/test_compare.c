/*
 * Runs the real `pinch compare`: its documents and files are right, bad requests are refused, and nothing depends on
 * how many processes run.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/schema.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* "quickstep-20" etc. in their order */
static const char *const run_names[] = {"pinch", "quickstep-20", "quickstep-50", "quickstep-200", "worldstep"};
enum { RUNS = sizeof run_names / sizeof *run_names };

static json_t *load_schema(void)
{
    json_error_t error;
    json_t *schema =
        json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-compare-1.json", JSON_REJECT_DUPLICATES, &error);
    if (!schema) fail_msg("line %d: %s", error.line, error.text);
    return schema;
}

/* In space and in the plane, force control, a slider; the document is as its schema says, and holds what it should. */
static void test_document(void **state)
{
    (void)state;
    json_t *schema = load_schema();
    json_t *d = compare_document(COMPARE(NULL, COMPARE_SCENE("example-2.json"), COMPARE_SCENE("example-1.json"),
                                         COMPARE_SCENE("pads-shake.json"), "--json", "--duration", "0.4"),
                                 0);
    assert_int_equal(schema_faults(schema, d), 0);
    const json_t *scenes = json_object_get(d, "scenes");
    assert_int_equal(json_array_size(scenes), 3);
    for (size_t i = 0; i < 3; i++) {
        const json_t *entry = json_array_get(scenes, i), *runs = json_object_get(entry, "runs");
        assert_int_equal(json_array_size(runs), RUNS);
        for (int k = 0; k < RUNS; k++) {
            const json_t *run = compare_find(entry, run_names[k]);
            assert_true(compare_metric(run, "cost") > 0);
            assert_true(compare_metric(run, "deterministic") == 1);
            assert_true(compare_metric(run, "momentum_error") <= 1e-9);
            assert_true(compare_metric(run, "force_error_median") >= 0);
        }
        const json_t *pinch = compare_find(entry, "pinch");
        assert_true(compare_metric(pinch, "force_error_max") <= 1e-9);
        assert_true(compare_metric(pinch, "verified") == 1);
        assert_true(json_array_size(json_object_get(entry, "samples")) >= 12);
    }
    json_decref(d);
    /* what a document is checked for can fail */
    d = json_pack("{s:s, s:s}", "command", "run", "more", "than is known");
    assert_true(schema_faults(schema, d) > 0);
    json_decref(d);
    json_decref(schema);
}

/* Without what differs from run to run: times. */
static void drop_costs(json_t *d)
{
    size_t i, k;
    json_t *entry, *run;
    json_array_foreach(json_object_get(d, "scenes"), i, entry)
    {
        json_object_del(entry, "cost_ratio");
        json_array_foreach(json_object_get(entry, "runs"), k, run)
            json_object_del(json_object_get(run, "metrics"), "cost");
        json_array_foreach(json_object_get(entry, "contact_solvers"), k, run) json_object_del(run, "step_us");
    }
}

static void test_same_again_whatever_the_jobs(void **state)
{
    (void)state;
    static const char *const jobs[] = {"1", "3", "1"};
    json_t *first = NULL;
    for (int i = 0; i < 3; i++) {
        json_t *d =
            compare_document(COMPARE(NULL, COMPARE_SCENE("pinched-capsule.json"), COMPARE_SCENE("twist.json"),
                                     COMPARE_SCENE("example-3.json"), "--json", "--duration", "0.5", "--jobs", jobs[i]),
                             0);
        drop_costs(d);
        if (!first) {
            first = d;
            continue;
        }
        assert_true(json_equal(first, d));
        json_decref(d);
    }
    json_decref(first);
}

/* Who else runs makes no difference to a run, though ODE has one generator of random numbers for all. */
static void test_runs_are_independent(void **state)
{
    (void)state;
    json_t *some = compare_document(COMPARE(NULL, COMPARE_SCENE("example-3.json"), "--json", "--duration", "0.3",
                                            "--contact-solver", "quickstep", "--quickstep-iterations", "50"),
                                    0);
    json_t *all = compare_document(COMPARE(NULL, COMPARE_SCENE("example-3.json"), "--json", "--duration", "0.3"), 0);
    const json_t *one = json_array_get(json_object_get(some, "scenes"), 0);
    assert_int_equal(json_array_size(json_object_get(one, "runs")), 2);
    for (int k = 0; k < 2; k++) {
        const char *name = k ? "quickstep-50" : "pinch";
        const json_t *other = compare_find(json_array_get(json_object_get(all, "scenes"), 0), name);
        assert_true(json_equal(json_object_get(compare_find(one, name), "hash"), json_object_get(other, "hash")));
    }
    json_decref(some);
    json_decref(all);
}

/* With the points of Pinch's manifolds ODE's exact solver holds the capsule that it drops with its collider's. */
static void test_contacts(void **state)
{
    (void)state;
    static const char *const whose[] = {"ode", "pinch"};
    for (int i = 0; i < 2; i++) {
        json_t *d = compare_document(COMPARE(NULL, COMPARE_SCENE("pinched-capsule.json"), "--json", "--duration", "2",
                                             "--contacts", whose[i], "--contact-solver", "worldstep", "--samples", "4"),
                                     0);
        const json_t *run = compare_find(json_array_get(json_object_get(d, "scenes"), 0), "worldstep");
        double creep = compare_metric(run, "creep"); /* 6 mm/s and 6e-12 m/s */
        assert_true(i == 0 ? creep > 1e-3 : creep < 1e-9);
        json_decref(d);
    }
}

/* ODE's probes are of the same step: where it can say all there is (the frictionless fingers of the plane's examples),
 * its exact solver gives the exact forces too. */
static void test_probes(void **state)
{
    (void)state;
    json_t *d = compare_document(COMPARE(NULL, COMPARE_SCENE("example-1.json"), "--json", "--duration", "1"), 0);
    const json_t *entry = json_array_get(json_object_get(d, "scenes"), 0);
    assert_true(compare_metric(compare_find(entry, "worldstep"), "force_error_max") <= 1e-9);
    double few = compare_metric(compare_find(entry, "quickstep-20"), "force_error_max"),
           many = compare_metric(compare_find(entry, "quickstep-200"), "force_error_max");
    assert_true(many < few);
    json_decref(d);
}

static void test_table(void **state)
{
    (void)state;
    program_result r = COMPARE(NULL, COMPARE_SCENE("example-3.json"), COMPARE_SCENE("egg.json"), "--duration", "0.2");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, ""); /* no progress bar in a pipe */
    for (int k = 0; k < RUNS; k++) assert_non_null(strstr(r.out, run_names[k]));
    assert_non_null(strstr(r.out, "largest force error"));
    program_free(&r);
}

/* Every number of the CSV file is the document's. */
static void test_csv(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512], *line;
    json_t *d = compare_document(
        COMPARE(folder, COMPARE_SCENE("example-3.json"), "--json", "--duration", "0.2", "--csv", "table.csv"), 0);
    const json_t *entry = json_array_get(json_object_get(d, "scenes"), 0);
    snprintf(path, sizeof path, "%s/table.csv", folder);
    char *table = program_read_file(path), *rest;
    line = strtok_r(table, "\n", &rest);
    assert_string_equal(line, "scene,run,metric,value,unit");
    size_t rows = 0;
    while ((line = strtok_r(NULL, "\n", &rest))) {
        char run[64], key[64], value[64];
        const char *fields = strchr(line, ',');
        assert_non_null(fields);
        if (sscanf(fields, ",%63[^,],%63[^,],%63[^,],", run, key, value) == 3)
            assert_true(strtod(value, NULL) == compare_metric(compare_find(entry, run), key));
        else
            assert_true(isnan(compare_metric(compare_find(entry, run), key)));
        rows++;
    }
    assert_int_equal(rows, RUNS * json_object_size(json_object_get(compare_find(entry, "pinch"), "metrics")));
    free(table);
    json_decref(d);
    assert_int_equal(program_count_entries(folder), 1); /* nothing half-written beside it */
    program_remove_folder(folder);
}

static void refused(program_result r, const char *says)
{
    int lines = 0;
    for (const char *c = r.err; *c; c++) lines += *c == '\n';
    if (r.status != 2 || *r.out || !strstr(r.err, says) || lines != 1)
        fail_msg("status %d, said \"%s\" (wanted \"%s\"), printed \"%s\"", r.status, r.err, says, r.out);
    program_free(&r);
}

static void test_bad_options(void **state)
{
    (void)state;
    const char *egg = COMPARE_SCENE("egg.json");
    refused(COMPARE(NULL, egg, "--quickstep-iterations", "20,"), "--quickstep-iterations");
    refused(COMPARE(NULL, egg, "--quickstep-iterations", "0"), "--quickstep-iterations");
    refused(COMPARE(NULL, egg, "--quickstep-iterations", "5,5"), "different");
    refused(COMPARE(NULL, egg, "--quickstep-iterations", "1,2,3,4,5,6,7,8,9"), "--quickstep-iterations");
    refused(COMPARE(NULL, egg, "--contacts", "mine"), "--contacts");
    refused(COMPARE(NULL, egg, "--points", "0"), "--points");
    refused(COMPARE(NULL, egg, "--points", "9"), "--points");
    refused(COMPARE(NULL, egg, "--samples", "-1"), "--samples");
    refused(COMPARE(NULL, egg, "--jobs", "0"), "--jobs");
    refused(COMPARE(NULL, egg, "--check", "nowhere.json"), "nowhere.json");
    refused(COMPARE(NULL, egg, "../scenes/egg.json", "--save", "twice.json"), "egg.json");
}

static void refuse_baseline(const char *folder, const char *text, const char *says)
{
    free(program_write_file(folder, "baseline.json", text));
    refused(COMPARE(folder, COMPARE_SCENE("egg.json"), "--check", "baseline.json"), says);
}

static void test_bad_baselines(void **state)
{
    (void)state;
    char *folder = program_make_folder(), pipe[512];
    snprintf(pipe, sizeof pipe, "%s/pipe", folder); /* nobody writes to it: reading would never end */
    assert_int_equal(mkfifo(pipe, 0600), 0);
    refused(COMPARE(folder, COMPARE_SCENE("egg.json"), "--check", "pipe"), "pipe: cannot be read");
#define FORMAT "{\"format\": \"pinch-baseline/1\", "
    refuse_baseline(folder, "{", "line 1");
    refuse_baseline(folder, "[]", "format");
    refuse_baseline(folder, "\xEF\xBB\xBF[]", "format"); /* the byte order mark is no fault */
    refuse_baseline(folder, "{\"format\": \"pinch-scene/1\"}", "pinch-baseline/1");
#define TOLERANCES                                                                                                     \
    "\"tolerances\": {\"pinch\": {\"creep\": {\"absolute\": 1, \"relative\": 0}}, \"ode\": {\"dropped\": "             \
    "{\"absolute\": 0, \"relative\": 0}}}, "
    refuse_baseline(folder, FORMAT TOLERANCES "\"scenes\": {}}", "no scene egg.json");
    refuse_baseline(folder, FORMAT "\"tolerances\": {}, \"scenes\": {}}", "tolerances.pinch");
    refuse_baseline(folder, FORMAT TOLERANCES "\"scenes\": {\"egg.json\": {\"tolerances\": {}, \"runs\": {}}}}",
                    "at least one run");
    refuse_baseline(folder,
                    FORMAT TOLERANCES "\"scenes\": {\"egg.json\": {\"tolerances\": {}, \"runs\": {\"pinch\": {}}}}}",
                    "at least one metric");
    refuse_baseline(folder, FORMAT "\"tolerances\": {\"pinch\": {\"speed\": {}}}, \"scenes\": {}}", "speed");
    refuse_baseline(folder,
                    FORMAT "\"tolerances\": {\"pinch\": {\"creep\": {\"absolute\": -1, \"relative\": 0}}}, "
                           "\"scenes\": {}}",
                    "tolerances.pinch.creep");
    refuse_baseline(folder, FORMAT TOLERANCES "\"scenes\": {\"egg.json\": {\"tolerances\": {}}}}", "runs");
    refuse_baseline(folder,
                    FORMAT TOLERANCES "\"scenes\": {\"egg.json\": {\"tolerances\": {}, \"runs\": {\"pinch\": "
                                      "{\"creep\": \"much\"}}}}}",
                    "scenes.egg.json.runs.pinch.creep");
    program_remove_folder(folder);
}

/* A baseline that has a run under another name, or lacks a metric, does not let the run pass. */
static void test_baseline_without_a_run(void **state)
{
    (void)state;
    char *folder = program_make_folder();
#define SHORT "--duration", "0.1", "--samples", "2", "--quiet", "--contact-solver", "pinch"
    program_result r = COMPARE(folder, COMPARE_SCENE("egg.json"), SHORT, "--save", "baseline.json");
    assert_int_equal(r.status, 0);
    program_free(&r);
    char path[512];
    snprintf(path, sizeof path, "%s/baseline.json", folder);
    r = COMPARE(folder, COMPARE_SCENE("egg.json"), SHORT, "--check", "baseline.json");
    assert_int_equal(r.status, 0);
    program_free(&r);
    json_t *baseline = json_load_file(path, 0, NULL);
    json_t *runs = json_object_get(json_object_get(json_object_get(baseline, "scenes"), "egg.json"), "runs");
    assert_int_equal(json_object_set(runs, "pinhc", json_object_get(runs, "pinch")), 0);
    assert_int_equal(json_object_del(runs, "pinch"), 0);
    assert_int_equal(json_dump_file(baseline, path, 0), 0);
    r = COMPARE(folder, COMPARE_SCENE("egg.json"), SHORT, "--check", "baseline.json");
    assert_int_equal(r.status, 1);
    assert_non_null(strstr(r.err, "egg.json, pinch: run moved from nothing"));
    program_free(&r);
    assert_int_equal(json_object_set(runs, "pinch", json_object_get(runs, "pinhc")), 0);
    assert_int_equal(json_object_del(runs, "pinhc"), 0);
    assert_int_equal(json_object_del(json_object_get(runs, "pinch"), "momentum_error"), 0);
    assert_int_equal(json_dump_file(baseline, path, 0), 0);
    r = COMPARE(folder, COMPARE_SCENE("egg.json"), SHORT, "--check", "baseline.json");
    assert_int_equal(r.status, 1);
    assert_non_null(strstr(r.err, "momentum_error moved from nothing"));
    program_free(&r);
    json_decref(baseline);
    program_remove_folder(folder);
}

/* Files that cannot be written: exit status 3, and nothing of them is left; what was there stays. */
static void test_files_are_whole_or_not_there(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    static const char *const options[] = {"--csv", "--save", "--report", "--picture"};
    for (int i = 0; i < 4; i++) {
        program_result r =
            COMPARE(folder, COMPARE_SCENE("egg.json"), "--duration", "0.05", "--quiet", options[i], "nowhere/file");
        assert_int_equal(r.status, 3);
        assert_non_null(strstr(r.err, "nowhere/file"));
        program_free(&r);
        r = COMPARE(folder, COMPARE_SCENE("egg.json"), "--duration", "0.05", "--quiet", options[i], "/dev/full");
        assert_int_equal(r.status, 3);
        program_free(&r);
    }
    /* neither where a scene is refused, alone or among others */
    char missing[] = "missing.json", good[] = COMPARE_SCENE("egg.json");
    for (int i = 0; i < 2; i++) {
        program_result r = COMPARE(folder, missing, i == 0 ? missing : good, "--duration", "0.05", "--quiet", "--csv",
                                   "table.csv", "--report", "report.html");
        assert_int_equal(r.status, 2);
        program_free(&r);
    }
    assert_int_equal(program_count_entries(folder), 0);
    /* a scene that fails leaves the baseline as it was */
    char *path = program_write_file(folder, "baseline.json", "as it was");
    program_result r = COMPARE(folder, COMPARE_SCENE("example-3.json"), "--duration", "0.3", "--quiet", "--solver",
                               "nsngrk", "--max-iterations", "1", "--save", "baseline.json");
    assert_int_equal(r.status, 1);
    program_free(&r);
    char *text = program_read_file(path);
    assert_string_equal(text, "as it was");
    free(text);
    free(path);
    program_remove_folder(folder);
}

/* The picture of one scene is small and whole; of two scenes there is none. */
static void test_picture(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    program_result r = COMPARE(folder, COMPARE_SCENE("egg.json"), "--duration", "0.3", "--samples", "2", "--quiet",
                               "--picture", "egg.svg");
    assert_int_equal(r.status, 0);
    program_free(&r);
    snprintf(path, sizeof path, "%s/egg.svg", folder);
    char *text = program_read_file(path);
    static const char *const parts[] = {"<svg ",
                                        "class=\"object\"",
                                        "class=\"finger\"",
                                        "class=\"cone\"",
                                        "class=\"arrow s0\"",
                                        "class=\"line s1\"",
                                        "angular creep",
                                        "</svg>\n"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) assert_non_null(strstr(text, parts[i]));
    assert_true(strlen(text) < 40000);
    free(text);
    r = COMPARE(folder, COMPARE_SCENE("egg.json"), COMPARE_SCENE("mug.json"), "--picture", "two.svg");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, "--picture"));
    program_free(&r);
    assert_int_equal(program_count_entries(folder), 1);
    program_remove_folder(folder);
}

/* The first failure's command line, which fails as well. */
static void test_repeat(void **state)
{
    (void)state;
    program_result r = COMPARE(NULL, COMPARE_SCENE("egg.json"), COMPARE_SCENE("example-3.json"), "--quiet",
                               "--duration", "0.3", "--solver", "nsngrk", "--max-iterations", "1", "--samples=2");
    assert_int_equal(r.status, 1);
    const char *line = strstr(r.err, "to repeat the first failure: pinch compare ");
    assert_non_null(line);
    assert_non_null(strstr(line, "--solver nsngrk"));
    assert_non_null(strstr(line, "--samples 2"));
    assert_non_null(strstr(line, "example-3.json\n"));
    assert_null(strstr(line, "egg.json"));
    program_free(&r);
}

/* A run of no steps and runs without samples have null for what they do not have. */
static void test_nothing_to_measure(void **state)
{
    (void)state;
    static const char *const none[] = {"--duration", "--samples"};
    json_t *schema = load_schema();
    for (int i = 0; i < 2; i++) {
        json_t *d = compare_document(COMPARE(NULL, COMPARE_SCENE("egg.json"), "--json", none[i], "0",
                                             i ? "--duration" : "--samples", i ? "0.01" : "3"),
                                     0);
        assert_int_equal(schema_faults(schema, d), 0);
        const json_t *entry = json_array_get(json_object_get(d, "scenes"), 0);
        assert_true(isnan(compare_metric(compare_find(entry, "pinch"), "force_error_max")));
        assert_int_equal(json_array_size(json_object_get(entry, "samples")), 0);
        json_decref(d);
    }
    json_decref(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_document),
        cmocka_unit_test(test_same_again_whatever_the_jobs),
        cmocka_unit_test(test_runs_are_independent),
        cmocka_unit_test(test_contacts),
        cmocka_unit_test(test_probes),
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_csv),
        cmocka_unit_test(test_bad_options),
        cmocka_unit_test(test_bad_baselines),
        cmocka_unit_test(test_baseline_without_a_run),
        cmocka_unit_test(test_files_are_whole_or_not_there),
        cmocka_unit_test(test_picture),
        cmocka_unit_test(test_repeat),
        cmocka_unit_test(test_nothing_to_measure),
    };
    return cmocka_run_group_tests_name("pinch compare", tests, NULL, NULL);
}
