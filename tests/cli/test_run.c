/* Runs the real `pinch run` and `pinch compare` and checks exit statuses, options, solvers and events. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static void test_no_steps_at_all(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-2.json"), "--json", "--duration", "0");
    assert_int_equal(r.status, 0);
    json_t *d = cli_document(&r);
    assert_int_equal(json_integer_value(json_object_get(d, "steps")), 0);
    assert_true(json_is_null(json_object_get(d, "step_us"))); /* means of nothing */
    assert_true(json_is_null(json_object_get(d, "iterations_mean")));
    json_decref(d);
    program_free(&r);
}

static void test_step_and_duration(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--step=0.002", "--duration=0.5");
    assert_int_equal(r.status, 0);
    json_t *d = cli_document(&r);
    assert_int_equal(json_integer_value(json_object_get(d, "steps")), 250);
    assert_close(json_number_value(json_object_get(d, "time_s")), 0.5, 1e-12);
    json_decref(d);
    program_free(&r);
}

static void remove_timings(json_t *document)
{
    assert_int_equal(json_object_del(document, "step_us"), 0);
    assert_int_equal(json_object_del(document, "collide_us"), 0);
    assert_int_equal(json_object_del(document, "solve_us"), 0);
}

static void test_same_document_again(void **state)
{
    (void)state;
    static const char *const scenes[] = {SCENE("example-2.json"), SCENE("pinched-capsule.json")};
    for (int i = 0; i < 2; i++) {
        json_t *d[2];
        for (int run = 0; run < 2; run++) {
            program_result r = PINCH(NULL, "run", scenes[i], "--json", "--duration", "1.5");
            assert_int_equal(r.status, 0);
            d[run] = cli_document(&r);
            remove_timings(d[run]);
            program_free(&r);
        }
        assert_true(json_equal(d[0], d[1]));
        json_decref(d[0]);
        json_decref(d[1]);
    }
}

static void test_quiet(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--quiet", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.out, "");
    assert_string_equal(r.err, "");
    program_free(&r);
    r = PINCH(NULL, "run", SCENE("example-3.json"), "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "F1")); /* a table with the fingers */
    program_free(&r);
    r = PINCH(NULL, "run", SCENE("example-3.json"), "--quiet", "--json", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    json_decref(cli_document(&r));
    program_free(&r);
    r = PINCH(NULL, "compare", SCENE("example-3.json"), "--quiet", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.out, "");
    program_free(&r);
}

static void test_usage_and_bad_input(void **state)
{
    (void)state;
    cli_refused(PINCH(NULL, "run"), 2, "SCENE");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), SCENE("example-3.json")), 2, "SCENE");
    cli_refused(PINCH(NULL, "run", "nowhere.json", "--json"), 2, "nowhere.json");
    cli_refused(PINCH(NULL, "run", PINCH_SOURCE_DIR, "--json"), 2, PINCH_SOURCE_DIR);
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--nonsense"), 2, "--nonsense");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--duration", "-1"), 2, "--duration");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--step", "0"), 2, "--step");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--step", "nan"), 2, "--step");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--solver", "magic"), 2, "magic");
    cli_refused(PINCH(NULL, "run", SCENE("example-2.json"), "--contact-solver", "bullet"), 2, "bullet");
    cli_refused(PINCH(NULL, "compare"), 2, "SCENE");
    cli_refused(PINCH(NULL, "compare", "nowhere.json"), 2, "nowhere.json");
    cli_refused(PINCH(NULL, "frobnicate"), 2, "frobnicate");
}

/* A solver that cannot do what is asked for is refused, with the pairs that exist. */
static void test_refused_pairs(void **state)
{
    (void)state;
    static const char *const solvers[] = {"lemke", "pgs"};
    static const char *const commands[] = {"run", "compare"};
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 2; i++) {
            program_result r = PINCH(NULL, commands[c], SCENE("example-2.json"), "--solver", solvers[i]);
            assert_int_equal(r.status, 2);
            assert_string_equal(r.out, "");
            assert_non_null(strstr(r.err, solvers[i]));
            assert_non_null(strstr(r.err, "nsnmgk"));
            assert_non_null(strstr(r.err, "newton"));
            program_free(&r);
        }
}

static void test_solvers_that_exist(void **state)
{
    (void)state;
    static const char *const solvers[] = {"nsnmgk", "nsngrk", "newton"};
    double force[3];
    for (int i = 0; i < 3; i++) {
        program_result r =
            PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--solver", solvers[i], "--duration", "0.3");
        assert_int_equal(r.status, 0);
        json_t *d = cli_document(&r);
        assert_string_equal(json_string_value(json_object_get(d, "solver")), solvers[i]);
        const json_t *finger = json_array_get(json_object_get(d, "fingers"), 0);
        force[i] = json_number_value(json_object_get(finger, "normal_force"));
        json_decref(d);
        program_free(&r);
    }
    /* the same forces; the row methods stop at a residual of 1e-10, 300 steps of it at 10 N and a stiffness ratio of
     * h (h kn + cn)/m = 0.14 */
    assert_close(force[1], force[0], 1e-6);
    assert_close(force[2], force[0], 1e-9);
}

static const char ellipsoid_scene[] =
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"ellipsoid\", \"radii\": [0.02, 0.02, 0.03]}, "
    "\"mass\": 0.1}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
    "\"stiffness\": "
    "{\"normal\": 1e4}, \"friction\": 0.5}]}";

/* A shape without a collider: an error that names it, or, once there is one, a run; never a world without contacts. */
static void test_unsupported_shapes(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *path = program_write_file(folder, "ellipsoid.json", ellipsoid_scene);
    static const char *const commands[] = {"run", "compare"};
    for (int c = 0; c < 2; c++) {
        program_result r = PINCH(folder, commands[c], "ellipsoid.json", "--duration", "0.01");
        if (r.status == 2)
            assert_non_null(strstr(r.err, "ellipsoid"));
        else
            assert_int_equal(r.status, 0);
        program_free(&r);
    }
    free(path);
    program_remove_folder(folder);
}

static const char dropped_scene[] = "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", "
                                    "\"size\": [0.04, 0.04, 0.04]}, \"mass\": 0.2}, "
                                    "\"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": "
                                    "\"hard\", \"stiffness\": {\"normal\": 1e4}, "
                                    "\"friction\": 0.2, \"closing\": 1e-4}, {\"name\": \"other\", \"point\": [0.02, 0, "
                                    "0], \"normal\": [-1, 0, 0], \"model\": "
                                    "\"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.2, \"closing\": 1e-4, "
                                    "\"damage\": {\"max_force\": 0.5}}], "
                                    "\"simulation\": {\"duration\": 1}}";

/* "-" is standard input, and a mesh in its scene is looked for in the working directory. */
static void test_standard_input(void **state)
{
    (void)state;
    static const char box[] = "{\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}";
    static const char cube[] = "v -.02 -.02 -.02\nv .02 -.02 -.02\nv -.02 .02 -.02\nv .02 .02 -.02\nv -.02 -.02 .02\nv "
                               ".02 -.02 .02\nv -.02 .02 .02\nv .02 .02 .02\n"
                               "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    static const char *const lines[] = {"exec " PINCH_EXECUTABLE " run - --json --duration 0.1 <other/s.json",
                                        "exec " PINCH_EXECUTABLE " run s.json --json --duration 0.1 </dev/null",
                                        "exec " PINCH_EXECUTABLE " solve - --json <other/s.json",
                                        "cat s.json | " PINCH_EXECUTABLE " validate -",
                                        "exec " PINCH_EXECUTABLE " compare - --json --duration 0.01 --quiet <s.json"};
    char *folder = program_make_folder(), other[512], text[2000], hash[64] = "";
    const char *at = strstr(dropped_scene, box);
    snprintf(text, sizeof text, "%.*s{\"type\": \"mesh\", \"file\": \"m.obj\"}%s", (int)(at - dropped_scene),
             dropped_scene, at + strlen(box));
    snprintf(other, sizeof other, "%s/other", folder);
    assert_int_equal(mkdir(other, 0700), 0);
    char *inner = program_write_file(other, "s.json", text);
    free(program_write_file(folder, "s.json", text));
    free(program_write_file(folder, "m.obj", cube));
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char shell[] = "/bin/sh", flag[] = "-c", line[512];
        snprintf(line, sizeof line, "%s", lines[i]);
        program_result r = program_run(folder, (char *const[]){shell, flag, line, NULL});
        int expected = i == 2; /* the fingers do not hold it */
        if (r.status != expected) fail_msg("%s: %d, %s", line, r.status, r.err);
        if (i < 2) {
            json_t *d = cli_document(&r);
            const char *own = json_string_value(json_object_get(d, "hash"));
            assert_string_equal(json_string_value(json_object_get(d, "scene")), i == 0 ? "-" : "s.json");
            if (*hash) assert_string_equal(own, hash);
            snprintf(hash, sizeof hash, "%s", own);
            json_decref(d);
        }
        program_free(&r);
    }
    char shell[] = "/bin/sh", flag[] = "-c", line[] = "echo { | " PINCH_EXECUTABLE " run -";
    program_result r = program_run(folder, (char *const[]){shell, flag, line, NULL});
    assert_int_equal(r.status, 2);
    assert_int_equal(strncmp(r.err, "-:2: ", 5), 0);
    program_free(&r);
    assert_int_equal(remove(inner), 0);
    assert_int_equal(remove(other), 0);
    free(inner);
    program_remove_folder(folder);
}

/* A ball without weight, which one finger pushes and the other follows or leaves. */
static const char drifting_scene[] =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"sphere\", "
    "\"radius\": "
    "0.02}, \"mass\": 0.05}, \"fingers\": [{\"name\": \"l\", \"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], "
    "\"model\": "
    "\"hard\", \"stiffness\": {\"normal\": 1e4}, \"damping\": {\"normal\": 5, \"tangential\": 3}, \"friction\": 0.8, "
    "\"drive\": {\"type\": \"path\", \"points\": [{\"time\": 0}, {\"time\": 0.1, \"translation\": [0.005, 0, 0]}]}}, "
    "{\"name\": \"r\", \"point\": [0.02, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": "
    "{\"normal\": "
    "1e4}, \"damping\": {\"normal\": 5, \"tangential\": 3}, \"friction\": 0.8, \"drive\": {\"type\": \"path\", "
    "\"points\": "
    "[{\"time\": 0}, {\"time\": 0.1, \"translation\": [0.02, 0, 0]}, {\"time\": 0.5, \"translation\": [%s, 0, 0]}]}}], "
    "\"schedule\": [{\"time\": 0, \"gravity\": [0, 0, 0]}, {\"time\": %s, \"gravity\": [0, 0, 0]}, {\"time\": %s, "
    "\"gravity\": [0, 0, -9.81]}], \"simulation\": {\"duration\": %s}}";

/* Without weight nothing falls: a ball that drifts between the fingers before they close is held, and is dropped where
 * it ends further than its own size from where it was touched. With weight it falls. */
static void test_drifting(void **state)
{
    (void)state;
    static const struct {
        const char *closes, *floats_until, *falls_from, *duration, *outcome;
        double time;
    } cases[] = {{"0.004", "1", "1.5", "2", "held", 0},
                 {"0.3", "1", "1.5", "0.3", "held", 0},         /* has drifted by 1 cm */
                 {"0.3", "3", "4", "2", "dropped", 2},          /* by 10 cm, at the end */
                 {"0.3", "0.2", "0.2", "0.3", "dropped", 0.25}, /* after 50 ms of free fall */
                 {"0.004", "0.15", "0.15", "1", "dropped", 0.2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *folder = program_make_folder(), text[2000];
        snprintf(text, sizeof text, drifting_scene, cases[i].closes, cases[i].floats_until, cases[i].falls_from,
                 cases[i].duration);
        free(program_write_file(folder, "s.json", text));
        program_result r = PINCH(folder, "run", "s.json", "--json");
        json_t *d = cli_document(&r);
        const json_t *events = json_object_get(d, "events");
        assert_string_equal(json_string_value(json_object_get(d, "outcome")), cases[i].outcome);
        assert_int_equal(json_array_size(events), cases[i].time > 0);
        if (cases[i].time > 0)
            assert_close(json_number_value(json_object_get(json_array_get(events, 0), "time")), cases[i].time, 0.0021);
        json_decref(d);
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* A hand that lifts a box with too little force leaves it on the table, and with enough it holds it. A finger that has
 * never come to its object has not held it either. */
static void test_left_behind(void **state)
{
    (void)state;
    static const char lifted[] =
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}, "
        "\"mass\": 0.2}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 1e4}, \"damping\": {\"normal\": 20, \"tangential\": 20}, \"friction\": 0.5, "
        "\"closing\": %s}, {\"point\": [0.02, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": "
        "{\"normal\": 1e4}, \"damping\": {\"normal\": 20, \"tangential\": 20}, \"friction\": 0.5, \"closing\": %s}], "
        "\"environment\": [{\"shape\": {\"type\": \"box\", \"size\": [1, 1, 0.1]}, \"position\": [0, 0, -0.07], "
        "\"stiffness\": {\"normal\": 1e5}, \"damping\": {\"normal\": 100, \"tangential\": 100}, \"friction\": 0.5}], "
        "\"schedule\": [{\"time\": 0.1, \"hand\": {\"translation\": [0, 0, 0]}}, {\"time\": 0.6, \"hand\": "
        "{\"translation\": [0, 0, 0.1]}}], \"simulation\": {\"duration\": 1}}";
    static const struct {
        const char *closing;
        bool touched;
    } cases[] = {{"1e-4", false}, {"5e-4", true}, {"-1e-3", false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[2048], *folder = program_make_folder();
        snprintf(text, sizeof text, lifted, cases[i].closing, cases[i].closing);
        free(program_write_file(folder, "lift.json", text));
        program_result r = PINCH(folder, "run", "lift.json", "--json");
        assert_int_equal(r.status, 0);
        json_t *d = cli_document(&r);
        assert_string_equal(json_string_value(json_object_get(d, "outcome")), "held"); /* no event speaks against it */
        assert_true(json_is_boolean(json_object_get(d, "touched")));
        assert_int_equal(json_is_true(json_object_get(d, "touched")), cases[i].touched);
        json_decref(d);
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* The document has these remarks, of which NULL is none, though nothing is on standard error. Frees r. */
static void has_remarks(program_result *r, const char *first, const char *second)
{
    assert_int_equal(r->status, 0);
    assert_string_equal(r->err, "");
    json_t *d = cli_document(r);
    const json_t *remarks = json_object_get(d, "remarks");
    const char *const expected[] = {first ? first : second, first ? second : NULL};
    size_t count = (expected[0] ? 1 : 0) + (expected[1] ? 1 : 0);
    assert_int_equal(json_array_size(remarks), count);
    for (size_t i = 0; i < count; i++) assert_string_equal(json_string_value(json_array_get(remarks, i)), expected[i]);
    json_decref(d);
    program_free(r);
}

/* What begins in something else is pushed out of it with forces that nobody meant, and the run says so. How far
 * fingers close is meant. */
static void test_overlap_is_remarked(void **state)
{
    (void)state;
    static const char on_table[] =
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}, "
        "\"mass\": 0.2}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5, \"closing\": 0.005}], \"environment\": [{\"name\": "
        "\"table\", \"shape\": {\"type\": \"box\", \"size\": [1, 1, 0.1]}, \"position\": [0, 0, %s], \"stiffness\": "
        "{\"normal\": 1e5}, \"friction\": 0.5}], \"simulation\": {\"duration\": 0.01}}";
    static const char *const heights[] = {"-0.07", "-0.06"};
    for (int deep = 0; deep < 2; deep++) {
        char text[1024], *folder = program_make_folder();
        snprintf(text, sizeof text, on_table, heights[deep]);
        free(program_write_file(folder, "table.json", text));
        program_result r = PINCH(folder, "run", "table.json", "--json");
        assert_int_equal(r.status, 0);
        assert_string_equal(
            r.err, deep ? "pinch run: table: object and table begin 0.01 m in each other, and are pushed apart\n" : "");
        program_free(&r);
        r = PINCH(folder, "run", "table.json", "--quiet");
        assert_string_equal(r.err, "");
        program_free(&r);
        const char *said = deep ? "object and table begin 0.01 m in each other, and are pushed apart" : NULL;
        r = PINCH(folder, "run", "table.json", "--json", "--quiet", "--checkpoint", "half", "--every", "5");
        has_remarks(&r, said, NULL);
        r = PINCH(folder, "run", "table.json", "--json", "--quiet", "--resume", "half", "--fail-on", "crush");
        has_remarks(&r, said, "--fail-on crush: no finger has damage.max_force, so that this never happens");
        program_remove_folder(folder);
    }
}

/* A duration that ends between two steps is rounded, which the run and the comparison say. */
static void test_rounded_duration_is_remarked(void **state)
{
    (void)state;
    static const char said[] = "a duration of 0.0025 s is 2.5 steps of 0.001 s; the run ends after 0.003 s";
    static const char *const durations[] = {"0.0025", "0.003"};
    for (int whole = 0; whole < 2; whole++) {
        program_result r = PINCH(NULL, "run", SCENE("twist.json"), "--json", "--quiet", "--duration", durations[whole]);
        has_remarks(&r, whole ? NULL : said, NULL);
        r = PINCH(NULL, "run", SCENE("twist.json"), "--duration", durations[whole]);
        assert_int_equal(r.status, 0);
        assert_int_equal(strstr(r.err, said) != NULL, !whole);
        program_free(&r);
        r = PINCH(NULL, "compare", SCENE("twist.json"), "--json", "--quiet", "--duration", durations[whole]);
        json_t *d = cli_document(&r);
        const json_t *scene = json_array_get(json_object_get(d, "scenes"), 0);
        const json_t *remarks = json_object_get(json_array_get(json_object_get(scene, "runs"), 0), "remarks");
        assert_int_equal(json_array_size(remarks), !whole);
        if (!whole) assert_string_equal(json_string_value(json_array_get(remarks, 0)), said);
        json_decref(d);
        program_free(&r);
    }
}

/* So are tips that begin in each other, where one of them can be stopped. */
static void test_overlap_of_tips_is_remarked(void **state)
{
    (void)state;
    static const char two_tips[] =
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}, "
        "\"mass\": 0.2}, \"fingers\": [{\"name\": \"one\", \"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], "
        "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5, \"normal_force\": 1, \"tip\": "
        "{\"type\": \"sphere\", \"radius\": 0.01}}, {\"name\": \"two\", \"point\": [-0.02, %s, 0], \"normal\": "
        "[1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5, \"closing\": 1e-4, "
        "\"tip\": {\"type\": \"sphere\", \"radius\": 0.01}}], \"simulation\": {\"duration\": 0.01}}";
    static const char *const places[] = {"0.02", "0.015", "0.0198"}, *const depths[] = {NULL, "0.005", "0.0002"};
    for (int deep = 0; deep < 3; deep++) {
        char text[1024], said[256] = "", *folder = program_make_folder();
        snprintf(text, sizeof text, two_tips, places[deep]);
        free(program_write_file(folder, "tips.json", text));
        program_result r = PINCH(folder, "run", "tips.json", "--json");
        if (deep)
            snprintf(said, sizeof said, "pinch run: tips: one and two begin %s m in each other, and are pushed apart\n",
                     depths[deep]);
        assert_string_equal(r.err, said);
        program_free(&r);
        r = PINCH(folder, "solve", "tips.json", "--no-reserves");
        snprintf(said, sizeof said,
                 "the statics leave out what one and two push each other with, which begin %s m in each other",
                 deep ? depths[deep] : "");
        assert_true((strstr(r.out, said) != NULL) == (deep > 0));
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* A box that is thrown at a stiff floor in steps that are much too long gets energy from them. The table says so. */
static void test_energy_of_long_steps_is_remarked(void **state)
{
    (void)state;
    static const char thrown[] =
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", \"size\": "
        "[0.06, 0.06, 0.06]}, \"mass\": 0.1}, \"fingers\": [{\"point\": [0.01, 0, -0.03], \"normal\": [0, 0, 1], "
        "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e5}, \"damping\": {\"normal\": 500, \"tangential\": 500}, "
        "\"friction\": 0.5}], \"schedule\": [{\"time\": 0, \"force\": [0.2, 0, 2]}, {\"time\": 0.05, \"force\": [0.2, "
        "0, "
        "2]}, {\"time\": 0.05, \"force\": [0, 0, 0], \"gravity\": [0, 0, -9.81]}], \"simulation\": {\"duration\": 1, "
        "\"step\": %s}}";
    static const char *const steps[] = {"0.01", "0.0001"};
    for (int fine = 0; fine < 2; fine++) {
        char text[1024], *folder = program_make_folder();
        snprintf(text, sizeof text, thrown, steps[fine]);
        free(program_write_file(folder, "thrown.json", text));
        program_result r = PINCH(folder, "run", "thrown.json");
        assert_int_equal(r.status, 0);
        assert_int_equal(strstr(r.out, "steps of 0.01 s have put ") != NULL, !fine);
        assert_int_equal(strstr(r.out, " s have put ") != NULL, !fine);
        program_free(&r);
        r = PINCH(folder, "run", "thrown.json", "--json");
        json_t *d = cli_document(&r);
        const char *remark = json_string_value(json_array_get(json_object_get(d, "remarks"), 0));
        assert_int_equal(remark && strncmp(remark, "steps of 0.01 s have put ", 25) == 0, !fine);
        json_decref(d);
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* Dropping what was held is a result: status 0 and an event; so is crushing. */
static void test_events(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *path = program_write_file(folder, "drop.json", dropped_scene);
    program_result r = PINCH(folder, "run", "drop.json", "--json");
    assert_int_equal(r.status, 0);
    json_t *d = cli_document(&r);
    const json_t *events = json_object_get(d, "events");
    bool dropped = false, crushed = false;
    for (size_t i = 0; i < json_array_size(events); i++) {
        const json_t *e = json_array_get(events, i);
        const char *type = json_string_value(json_object_get(e, "type"));
        assert_true(json_is_number(json_object_get(e, "time")) && json_is_number(json_object_get(e, "value")) &&
                    json_is_number(json_object_get(e, "limit")));
        if (strcmp(type, "dropped") == 0) dropped = true;
        if (strcmp(type, "crush") != 0) continue;
        crushed = true;
        assert_string_equal(json_string_value(json_object_get(e, "finger")), "other");
        assert_close(json_number_value(json_object_get(e, "limit")), 0.5, 0);
        assert_true(json_number_value(json_object_get(e, "value")) > 0.5);
    }
    assert_true(dropped && crushed);
    assert_string_equal(json_string_value(json_object_get(d, "outcome")), "dropped");
    json_decref(d);
    program_free(&r);
    /* --fail-on asks for the events that are failures */
    static const struct {
        const char *events, *duration, *outcome;
        int status;
    } cases[] = {{"dropped", "1", "dropped", 1},
                 {"slip,crush", "1", "dropped", 1},
                 {"slip", "1", "dropped", 0},
                 {"dropped", "0.01", "crushed", 0},
                 {"crush,dropped", "0.01", "crushed", 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        r = PINCH(folder, "run", "drop.json", "--json", "--fail-on", cases[i].events, "--duration", cases[i].duration);
        assert_int_equal(r.status, cases[i].status);
        /* the scene's fingers have a damage by force alone */
        bool slip = strstr(cases[i].events, "slip") != NULL;
        assert_true(slip == (strstr(r.err, "drop.json: --fail-on slip: no finger has damage.max_slip") != NULL));
        assert_null(strstr(r.err, "--fail-on crush"));
        d = cli_document(&r);
        assert_string_equal(json_string_value(json_object_get(d, "outcome")), cases[i].outcome);
        json_decref(d);
        program_free(&r);
    }
    r = PINCH(folder, "run", "drop.json", "--duration", "0.01", "--fail-on", "limit", "--quiet");
    assert_string_equal(r.err, "");
    program_free(&r);
    r = PINCH(NULL, "run", SCENE("hands/parallel-gripper-lift.json"), "--duration", "0.01", "--fail-on", "limit,crush");
    assert_null(strstr(r.err, "--fail-on limit"));
    assert_non_null(strstr(r.err, "--fail-on crush: no finger has damage.max_force"));
    program_free(&r);
    r = PINCH(folder, "run", "drop.json", "--duration", "0.01", "--fail-on", "limit");
    assert_non_null(strstr(r.err, "--fail-on limit: there is no hand with a limited joint, so that"));
    assert_non_null(strstr(r.out, "outcome: crushed"));
    program_free(&r);
    cli_refused(PINCH(folder, "run", "drop.json", "--fail-on", "crush,smash"), 2, "crush, slip, dropped or limit");
    cli_refused(PINCH(folder, "run", "drop.json", "--fail-on", "crush,"), 2, "crush, slip, dropped or limit");
    free(path);
    program_remove_folder(folder);
}

/* Steps that no solver settled: the document is printed, says so, and the status is 1. */
static void test_unconverged_is_reported(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--solver", "nsngrk", "--max-iterations",
                             "1", "--duration", "0.3");
    assert_int_equal(r.status, 1);
    json_t *d = cli_document(&r);
    assert_string_equal(json_string_value(json_object_get(d, "status")), "max_iterations");
    assert_true(json_integer_value(json_object_get(d, "unconverged_steps")) > 0);
    assert_true(json_is_false(cli_at(d, "verification.passed")));
    json_decref(d);
    program_free(&r);
}

static json_int_t solved_by(json_t *document, const char *path)
{
    const json_t *count = cli_at(document, path);
    assert_true(json_is_integer(count));
    return json_integer_value(count);
}

/* A run says which method has found its answers. */
static void test_solved_by_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *option, *value, *text;
        int newton, projections, lcp;
    } cases[] = {{"--solver", "nsnmgk", "by greedy projections 0,", 1, 0, 0},
                 {"--no-newton", NULL, "by Newton's steps 0 times", 0, 1, 0},
                 {"--formulation", "lcp", "by greedy projections 0,", 1, 0, 0},
                 {"--solver", "nsngrk", "by Newton's steps 0 times", 0, 1, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *arguments[] = {"run",           SCENE("example-3.json"),
                                   "--duration",    "0.2",
                                   cases[k].option, cases[k].value ? cases[k].value : "--json",
                                   "--json",        NULL};
        program_result r = command_run(NULL, arguments);
        assert_int_equal(r.status, 0);
        json_t *d = cli_document(&r);
        assert_int_equal(solved_by(d, "islands_by.newton") > 0, cases[k].newton);
        assert_int_equal(solved_by(d, "islands_by.projections") > 0, cases[k].projections);
        assert_int_equal(solved_by(d, "islands_by.lcp") > 0, cases[k].lcp);
        json_decref(d);
        program_free(&r);
        arguments[6] = NULL;
        if (!cases[k].value) arguments[5] = NULL;
        r = command_run(NULL, arguments);
        assert_non_null(strstr(r.out, cases[k].text));
        program_free(&r);
    }
}

static void test_compare(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "compare", SCENE("example-3.json"), SCENE("example-2.json"), "--json", "--duration", "0.2");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, "");
    json_t *d = cli_document(&r);
    assert_string_equal(json_string_value(json_object_get(d, "command")), "compare");
    const json_t *scenes = json_object_get(d, "scenes");
    assert_int_equal(json_array_size(scenes), 2);
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    for (size_t i = 0; i < 2; i++) {
        const json_t *scene = json_array_get(scenes, i), *list = json_object_get(scene, "contact_solvers");
        assert_true(json_number_value(json_object_get(scene, "cost_ratio")) > 0);
        assert_int_equal(json_array_size(list), 3);
        for (size_t k = 0; k < 3; k++) {
            const json_t *c = json_array_get(list, k);
            assert_string_equal(json_string_value(json_object_get(c, "contact_solver")), names[k]);
            assert_true(json_number_value(json_object_get(c, "step_us")) > 0);
            assert_true(cli_is_vector(json_object_get(c, "displacement"), 3));
            assert_int_equal(json_array_size(json_object_get(c, "forces")), 3);
        }
    }
    json_decref(d);
    program_free(&r);
    /* the table names all three and ends well */
    r = PINCH(NULL, "compare", SCENE("example-3.json"), "--duration", "0.2");
    assert_int_equal(r.status, 0);
    for (int k = 0; k < 3; k++) assert_non_null(strstr(r.out, names[k]));
    program_free(&r);
    /* one missing scene does not hide the others, but is not forgotten */
    r = PINCH(NULL, "compare", "nowhere.json", SCENE("example-3.json"), "--json", "--duration", "0.1");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, "nowhere.json"));
    d = cli_document(&r);
    assert_int_equal(json_array_size(json_object_get(d, "scenes")), 1);
    json_decref(d);
    program_free(&r);
}

static void test_help(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", "--help");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, "");
    static const char *const options[] = {"--solver", "--contact-solver", "--duration", "--step", "--json",
                                          "--csv",    "--quiet"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) assert_non_null(strstr(r.out, options[i]));
    for (int way = 0; way < 2; way++) {
        program_result other = way ? PINCH(NULL, "help", "run") : PINCH(NULL, "run", "-h");
        assert_int_equal(other.status, 0);
        assert_string_equal(other.out, r.out);
        program_free(&other);
    }
    program_free(&r);
    r = PINCH(NULL, "help");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "usage: pinch COMMAND"));
    program_free(&r);
    cli_refused(PINCH(NULL, "help", "walk"), 2, "unknown command \"walk\"");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_steps_at_all),
        cmocka_unit_test(test_step_and_duration),
        cmocka_unit_test(test_same_document_again),
        cmocka_unit_test(test_quiet),
        cmocka_unit_test(test_usage_and_bad_input),
        cmocka_unit_test(test_refused_pairs),
        cmocka_unit_test(test_solvers_that_exist),
        cmocka_unit_test(test_unsupported_shapes),
        cmocka_unit_test(test_standard_input),
        cmocka_unit_test(test_drifting),
        cmocka_unit_test(test_left_behind),
        cmocka_unit_test(test_overlap_is_remarked),
        cmocka_unit_test(test_rounded_duration_is_remarked),
        cmocka_unit_test(test_overlap_of_tips_is_remarked),
        cmocka_unit_test(test_energy_of_long_steps_is_remarked),
        cmocka_unit_test(test_events),
        cmocka_unit_test(test_unconverged_is_reported),
        cmocka_unit_test(test_solved_by_is_told),
        cmocka_unit_test(test_compare),
        cmocka_unit_test(test_help),
    };
    return cmocka_run_group_tests_name("pinch run and compare", tests, NULL, NULL);
}
