/* Results of studies: the same rows however they came about, and clear errors where they cannot be kept. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "study/report.h"
#include "support/browser.h"
#include "support/command.h"
#include "support/sanitized.h"
#include "support/schema.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static char *folder;

static const char scene_text[] =
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, \"mass\": "
    "0.5},"
    " \"fingers\": ["
    "{\"name\": \"left\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], \"model\": \"soft\", \"stiffness\": "
    "{\"normal\": "
    "20000, \"torsional\": 1}, \"friction\": 0.6, \"torsional_friction\": 0.002, \"closing\": 0.0005},"
    "{\"name\": \"right\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"soft\", \"stiffness\": "
    "{\"normal\": "
    "20000, \"torsional\": 1}, \"friction\": 0.6, \"torsional_friction\": 0.002, \"closing\": 0.0005}],"
    " \"simulation\": {\"duration\": 0.1}}";

/* A run takes ten times as long with sanitizers, and MPI's libraries have none. */
#ifdef __SANITIZE_ADDRESS__
#define SAMPLES "30"
#else
#define SAMPLES "120"
#endif

/* Some of the draws are no legal scenes: a friction below zero. */
static const char study_text[] =
    "{\"format\": \"pinch-study/1\", \"name\": \"small\", \"scene\": \"cube.json\", \"trials\": {\"samples\": " SAMPLES
    ", "
    "\"seed\": 4},"
    " \"vary\": [{\"path\": \"/object/mass\", \"uniform\": [0.3, 2]},"
    " {\"path\": \"/fingers/*/friction\", \"uniform\": [-0.05, 1]}],"
    " \"protocol\": {\"name\": \"six-forces\", \"settle\": 0.02, \"hold\": 0.05},"
    " \"success\": {\"displacement\": 0.002},"
    " \"record\": [\"object.creep\", \"fingers.*.slip_total\"]}";

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    free(program_write_file(folder, "cube.json", scene_text));
    free(program_write_file(folder, "small.json", study_text));
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    browser_remove_folder(folder);
    return 0;
}

/* ---- The rows. ---- */

static bool add_row(void *context, const json_t *names, json_t *row)
{
    json_t *list = context;
    json_t *kept = json_array();
    for (size_t i = 0; i < json_array_size(row); i++)
        if (!strstr(json_string_value(json_array_get(names, i)), "time"))
            json_array_append(kept, json_array_get(row, i));
    json_array_append_new(list, kept);
    return true;
}

/* All tables without their times, as one text. */
static char *dump(const char *name)
{
    static const char *const tables[] = {"study", "trials", "directions", "errors"};
    char path[4096], query[64];
    results_error error;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    results *r = results_read(path, &error);
    if (!r) fail_msg("%s", error.text);
    json_t *all = json_array();
    for (int i = 0; i < 4; i++) {
        json_t *list = json_array();
        snprintf(query, sizeof query, "SELECT * FROM %s", tables[i]);
        if (!results_query(r, query, add_row, list, &error)) fail_msg("%s", error.text);
        json_array_append_new(all, list);
    }
    results_close(r, &error);
    char *text = json_dumps(all, JSON_COMPACT);
    json_decref(all);
    return text;
}

static void expect(program_result r, int status)
{
    if (r.status != status) fail_msg("exit %d: %s%s", r.status, r.out, r.err);
    program_free(&r);
}

static void expect_same(const char *name, const char *reference)
{
    char *text = dump(name);
    assert_string_equal(text, reference);
    free(text);
}

static void wait_a_while(double seconds)
{
    struct timespec span = {0, (long)(1e9 * seconds)};
    nanosleep(&span, NULL);
}

/* Starts the command, and kills it after a while. Returns true where it was done before. */
static pid_t start(void)
{
    pid_t process = fork();
    if (process == 0) {
        if (chdir(folder) != 0) _exit(9);
        execl(PINCH_EXECUTABLE, "pinch", "study", "small.json", "--out", "killed.sqlite", "--resume", "--quiet",
              "--jobs", "2", (char *)NULL);
        _exit(9);
    }
    return process;
}

static bool run_and_kill(double seconds, int *ended)
{
    pid_t process = start();
    wait_a_while(seconds);
    kill(process, SIGKILL);
    waitpid(process, ended, 0);
    return WIFEXITED(*ended) && WEXITSTATUS(*ended) == 0;
}

static void test_same_rows(void **state)
{
    (void)state;
    expect(PINCH(folder, "study", "small.json", "--out", "one.sqlite", "--jobs", "1", "--quiet"), 0);
    char *reference = dump("one.sqlite");
    assert_non_null(strstr(reference, "bad_draw"));
    assert_non_null(strstr(reference, "+x"));
    expect(PINCH(folder, "study", "small.json", "--out", "three.sqlite", "--jobs", "3", "--quiet"), 0);
    expect_same("three.sqlite", reference);
    expect(PINCH(folder, "study", "small.json", "--out", "parts.sqlite", "--limit", "17", "--jobs", "2", "--quiet"), 0);
    expect(PINCH(folder, "study", "small.json", "--out", "parts.sqlite", "--limit", "1", "--resume", "--quiet"), 0);
    expect(PINCH(folder, "study", "small.json", "--out", "parts.sqlite", "--resume", "--quiet"), 0);
    expect_same("parts.sqlite", reference);
    unsigned draw = 1;
    int kills = 0, ended;
    for (; kills < 20; kills++) {
        draw = draw * 1103515245 + 12345;
        if (run_and_kill(0.01 + 0.1 * (double)(draw >> 16 & 0xff) / 256, &ended)) break;
    }
    assert_true(kills > 0);
    expect(PINCH(folder, "study", "small.json", "--out", "killed.sqlite", "--resume", "--quiet"), 0);
    expect_same("killed.sqlite", reference);
    free(reference);
}

static void test_interrupt(void **state)
{
    (void)state;
    int ended;
    expect(PINCH(folder, "study", "small.json", "--out", "killed.sqlite", "--limit", "1", "--resume", "--quiet"), 0);
    char path[4096];
    snprintf(path, sizeof path, "%s/killed.sqlite", folder);
    unlink(path);
    struct stat about;
    pid_t process = start();
    bool running = true;
    while (running && stat(path, &about) != 0) {
        wait_a_while(0.01);
        running = waitpid(process, &ended, WNOHANG) == 0;
    }
    if (running) {
        kill(process, SIGINT); /* its results are there, and so is what it does at a signal */
        waitpid(process, &ended, 0);
    }
    assert_true(WIFEXITED(ended));
    assert_true(WEXITSTATUS(ended) == 130 || WEXITSTATUS(ended) == 0);
    expect(PINCH(folder, "study", "small.json", "--out", "killed.sqlite", "--resume", "--quiet"), 0);
    char *reference = dump("one.sqlite");
    expect_same("killed.sqlite", reference);
    free(reference);
}

static bool has_mpirun(void)
{
    char module[4096];
    snprintf(module, sizeof module, "%s", PINCH_EXECUTABLE);
    strcpy(strrchr(module, '/'), "/libpinch_mpi.so");
    return access(module, R_OK) == 0 && system("command -v mpirun >/dev/null 2>&1") == 0;
}

/* Rank 0 writes what one or two others compute. */
static void test_mpi(void **state)
{
    (void)state;
    if (SANITIZED || !has_mpirun()) {
        print_message("sanitized, built without MPI, or mpirun is not there\n");
        skip();
    }
    char *reference = dump("one.sqlite");
    for (int n = 2; n <= 3; n++) {
        char script[4096], name[32];
        snprintf(name, sizeof name, "mpi%d.sqlite", n);
        snprintf(
            script, sizeof script,
            "ASAN_OPTIONS=detect_leaks=0 exec mpirun --allow-run-as-root --oversubscribe -n %d %s study small.json "
            "--out %s --quiet </dev/null",
            n, PINCH_EXECUTABLE, name);
        expect(program_run(folder, (char *[]){"/bin/sh", "-c", script, NULL}), 0);
        expect_same(name, reference);
    }
    free(reference);
}

/* ---- The report. ---- */

static void test_report(void **state)
{
    (void)state;
    char path[4096];
    if (browser_libraries_are_missing()) skip();
    expect(PINCH(folder, "study", "small.json", "--out", "one.sqlite", "--resume", "--report", "r.html", "--quiet"), 0);
    snprintf(path, sizeof path, "%s/r.html", folder);
    char *page = program_read_file(path);
    browser_page_is_self_contained(page);
    assert_non_null(strstr(page, SAMPLES " of " SAMPLES " trials by pinch"));
    assert_non_null(strstr(page, "/object/mass"));
    assert_non_null(strstr(page, "area under the ROC curve"));
    assert_non_null(strstr(page, "hardest first"));
    assert_non_null(strstr(page, "pinch study small.json --trial "));
    assert_non_null(strstr(page, ": failed: play\"><svg "));
    free(page);
}

/* Pressing a picture plays the trial's run, whose length is that of the protocol, and no page is wider than a phone. */
static void test_report_plays(void **state)
{
    (void)state;
    if (browser_libraries_are_missing() || browser_is_missing()) skip();
    browser_add_script(folder, "r.html", "played.html",
                       "addEventListener('load', () => document.querySelector('button[data-film]').click())");
    json_t *seen = browser_seen(folder, "played.html",
                                "seen.end = viewer.film.end; seen.fingers = viewer.film.fingers.length;"
                                "seen.title = q('#view-title').textContent; seen.pictures = all('.gallery svg').length;"
                                "seen.wide = document.documentElement.scrollWidth > innerWidth;",
                                browser_narrow);
    assert_close(json_number_value(json_object_get(seen, "end")), 0.07, 1e-9); /* settle and hold */
    assert_int_equal(json_integer_value(json_object_get(seen, "fingers")), 2);
    assert_int_equal(json_integer_value(json_object_get(seen, "pictures")), 6);
    assert_non_null(strstr(json_string_value(json_object_get(seen, "title")), "force along "));
    assert_true(json_is_false(json_object_get(seen, "wide")));
    json_decref(seen);
}

/* The part of the page from a quantity's name to the end of its drawing. */
static char *figure_of(const char *page, const char *name)
{
    char caption[128];
    snprintf(caption, sizeof caption, "<figcaption>%s</figcaption>", name);
    const char *from = strstr(page, caption), *to = from ? strstr(from, "</figure>") : NULL;
    return to ? strndup(from, (size_t)(to - from)) : NULL;
}

/* The trials of all dots, as their titles have them. */
static int trials_of(const char *figure)
{
    int sum = 0, succeeded, count;
    for (const char *c = figure; (c = strstr(c, "<title>")); c++)
        if (sscanf(c, "<title>%d of %d", &succeeded, &count) == 2) sum += count;
    return sum;
}

/* Texts have nothing between them. The most frequent have a dot each, and one dot has all others, so that no trial is
 * missing. Lists and objects are texts in the results only. */
static void test_report_texts(void **state)
{
    (void)state;
    if (browser_libraries_are_missing()) skip();
    json_t *names = json_array(), *places = json_array();
    for (int i = 0; i < 20; i++) {
        json_array_append_new(names, json_sprintf("<cup> %d", i));
        json_array_append_new(places, json_pack("[f, f, f]", 0.0, 0.0, 1e-6 * i));
    }
    json_t *document =
        json_pack("{s:s, s:s, s:{s:i, s:i}, s:[s], s:[{s:s, s:o}, {s:s, s:o}, {s:s, s:[{s:s, s:[f,f,f]}, {s:s, "
                  "s:[f,f,f]}]}, {s:s, s:[f,f,f]}]}",
                  "format", "pinch-study/1", "scene", "cube.json", "trials", "samples", 200, "seed", 3, "record",
                  "object.displacement", "vary", "path", "/object/name", "values", names, "path", "/object/position",
                  "values", places, "path", "/object/shape", "values", "type", "box", "size", 0.1, 0.1, 0.1, "type",
                  "box", "size", 0.1, 0.1, 0.11, "path", "/object/mass", "values", 0.3, 0.4, 0.5);
    assert_non_null(document);
    char *text = json_dumps(document, 0), path[4096];
    free(program_write_file(folder, "texts.json", text));
    free(text);
    json_decref(document);
    expect(PINCH(folder, "study", "texts.json", "--out", "texts.sqlite", "--report", "texts.html", "--quiet"), 0);
    snprintf(path, sizeof path, "%s/texts.html", folder);
    char *page = program_read_file(path), *figure = figure_of(page, "/object/name");
    assert_non_null(figure);
    assert_null(strstr(figure, "between"));
    assert_non_null(strstr(figure, ": &lt;cup&gt; "));
    assert_non_null(strstr(figure, ": others</title>"));
    assert_non_null(strstr(figure, "16: others, 5 different ones ("));
    assert_int_equal(trials_of(figure), 200);
    free(figure);
    /* an object that a study chooses is drawn, and numbers are */
    figure = figure_of(page, "/object/shape");
    assert_non_null(figure);
    assert_null(strstr(figure, "between"));
    assert_non_null(strstr(figure, "type box"));
    assert_int_equal(trials_of(figure), 200);
    free(figure);
    figure = figure_of(page, "/object/mass");
    assert_non_null(figure);
    assert_non_null(strstr(figure, "between 0.5 and 0.5"));
    assert_int_equal(trials_of(figure), 200);
    free(figure);
    /* many lists are not */
    assert_null(figure_of(page, "/object/position"));
    assert_null(figure_of(page, "object.displacement"));
    assert_non_null(strstr(page, "than can be drawn: /object/position.</p>"));
    assert_non_null(strstr(page, "which are not drawn: object.displacement.</p>"));
    free(page);
}

static void test_statistics(void **state)
{
    (void)state;
    double low, high;
    /* the interval's ends are the rates p with |p^ - p| = z sqrt(p (1 - p)/n) */
    wilson_interval(8, 10, &low, &high);
    for (int k = 0; k < 2; k++) {
        double p = k ? high : low;
        assert_close(fabs(0.8 - p), 1.959963984540054 * sqrt(p * (1 - p) / 10), 1e-12);
    }
    wilson_interval(0, 5, &low, &high);
    assert_close(low, 0, 0);
    wilson_interval(5, 5, &low, &high);
    assert_close(high, 1, 0);
    const double values[] = {1, 2, 2, 3, NAN, 4};
    const bool success[] = {false, false, true, true, true, false};
    /* pairs of a success (2, 3) and a failure (1, 2, 4): 1 + 1/2 + 0 and 1 + 1 + 0 of 6 */
    assert_close(area_under_roc(values, success, 6), 3.5 / 6, 1e-15);
    assert_true(isnan(area_under_roc(values, success, 2)));
    /* of one success and many failures, the variance is that of the share of failures below it, uniform for A = 1/2 */
    double many[1000] = {0};
    bool first[1000] = {true};
    assert_int_equal(area_interval(many, first, 1000, 0.5, &low, &high), 1000);
    assert_close(high - low, 1.0, 0.0); /* 1.96 * sqrt(1/12) is more than there is */
    assert_int_equal(area_interval(values, success, 6, 3.5 / 6, &low, &high), 5);
    for (int i = 1; i < 500; i++) first[i] = true;
    area_interval(many, first, 1000, 0.5, &low, &high);
    assert_close(high - 0.5, 1.96 * sqrt(1.0 / (12 * 500) * 2), 1e-3);
}

/* ---- Single trials. ---- */

/* A trial alone is the trial of the study. */
static void test_one_trial(void **state)
{
    (void)state;
    free(program_write_file(folder, "plain.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"samples\": 4, "
                            "\"design\": \"sobol\"}, \"vary\": [{\"path\": \"/object/mass\", \"uniform\": [0.3, 2]}],"
                            " \"record\": [\"grasp.least_closing\", \"grasp.epsilon\"]}"));
    expect(PINCH(folder, "study", "plain.json", "--out", "plain.sqlite", "--csv", "plain.csv", "--quiet"), 0);
    char path[4096];
    snprintf(path, sizeof path, "%s/plain.csv", folder);
    char *csv = program_read_file(path);
    assert_non_null(strstr(csv, "trial,status,success,exit,wall_time,hash,/object/"
                                "mass,displacement,grasp.epsilon,grasp.least_closing,outcome,rotation\n"));
    program_result r = PINCH(folder, "study", "plain.json", "--trial", "2", "--json", "--quiet");
    json_t *document = cli_document(&r);
    assert_non_null(strstr(csv, json_string_value(json_object_get(document, "hash"))));
    json_decref(document);
    program_free(&r);
    free(csv);
    r = PINCH(folder, "study", "plain.json", "--trial", "2", "--print");
    assert_int_equal(r.status, 0);
    free(program_write_file(folder, "printed.json", r.out));
    program_free(&r);
    expect(PINCH(folder, "validate", "printed.json", "--quiet"), 0);
    cli_refused(PINCH(folder, "study", "plain.json", "--trial", "4"), 2, "from 0 to 3");
}

static bool take_bounds(void *context, const json_t *names, json_t *row)
{
    (void)names;
    double *bounds = context;
    for (int i = 0; i < 2; i++) bounds[i] = json_number_value(json_array_get(row, (size_t)i));
    return true;
}

/* A name with a quotation mark has its column like any other. */
static void test_quoted_names(void **state)
{
    (void)state;
    free(program_write_file(
        folder, "quoted.json",
        "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"design\": "
        "\"grid\"}, \"vary\": [{\"path\": \"/fingers/0/name\", \"values\": [\"q\\\"x\", \"plain\"]}],"
        " \"record\": [\"fingers.*.peak_normal_force\"]}"));
    expect(PINCH(folder, "study", "quoted.json", "--out", "quoted.sqlite", "--csv", "quoted.csv", "--quiet"), 0);
    char path[4096];
    snprintf(path, sizeof path, "%s/quoted.csv", folder);
    char *csv = program_read_file(path), *column = strstr(csv, "\"fingers.q\"\"x.peak_normal_force\"");
    assert_non_null(column);
    size_t commas = 0;
    for (const char *c = csv; c < column; c++) commas += *c == ',';
    const char *cell = strchr(csv, '\n') + 1;
    for (; commas > 0; cell++) commas -= *cell == ',';
    assert_close(strtod(cell, NULL), 10, 1);
    free(csv);
}

/* Closing and gravity come in slowly, so that nothing swings. */
#define SLOW_FINGER(name, x, n)                                                                                        \
    "{\"name\": \"" name "\", \"point\": [" x ", 0, 0], \"normal\": [" n ", 0, 0], \"model\": \"soft\", "              \
    "\"stiffness\": {\"normal\": 20000, \"torsional\": 1}, \"damping\": {\"normal\": 20, \"tangential\": 13}, "        \
    "\"friction\": 0.6, \"torsional_friction\": 0.002, \"closing\": 0.0005, \"ramp\": 0.2}"
static const char slow_text[] =
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, "
    "\"mass\": 0.5}, \"fingers\": [" SLOW_FINGER("left", "-0.05", "1") ", " SLOW_FINGER(
        "right", "0.05",
        "-1") "],"
              " \"schedule\": [{\"time\": 0.2, \"gravity\": [0, 0, 0]}, {\"time\": 0.4, \"gravity\": [0, 0, -9.81]}],"
              " \"simulation\": {\"duration\": 0.1}}";

static const char least_text[] =
    "{\"format\": \"pinch-study/1\", \"scene\": \"slow.json\", \"trials\": {\"samples\": 2}, "
    "\"vary\": [{\"path\": \"/simulation/duration\", \"values\": [1.9]},"
    "{\"path\": \"/object/position\", \"values\": [[0, 0, 0]]}],"
    "\"least\": {\"path\": \"/fingers/*/friction\", \"from\": 0.01, \"to\": 1, \"precision\": 1e-3},"
    "\"success\": {\"displacement\": 0.001}}";

/* The least friction of a pinch that holds a weight of 4.905 N by 10 N on each side is the weight over 20 N. Just below
 * it the cube does not move far within the second and a half, which the tolerance allows for. */
static void test_least(void **state)
{
    (void)state;
    double bounds[2] = {NAN, NAN};
    char path[4096];
    results_error error;
    free(program_write_file(folder, "slow.json", slow_text));
    free(program_write_file(folder, "least.json", least_text));
    expect(PINCH(folder, "study", "least.json", "--out", "least.sqlite", "--csv", "least.csv", "--quiet"), 0);
    snprintf(path, sizeof path, "%s/least.sqlite", folder);
    results *r = results_read(path, &error);
    assert_non_null(r);
    assert_true(results_query(r,
                              "SELECT json_extract(recorded, '$.\"least.holds\"'), json_extract(recorded, "
                              "'$.\"least.fails\"') FROM trials",
                              take_bounds, bounds, &error));
    results_close(r, &error);
    assert_close(bounds[0], 4.905 / 20, 2e-3 * 4.905 / 20);
    assert_true(bounds[1] < bounds[0] && bounds[1] > 0.998 * bounds[0]);
    /* a list is one field */
    snprintf(path, sizeof path, "%s/least.csv", folder);
    char *csv = program_read_file(path);
    assert_non_null(strstr(csv, ",\"["));
    free(csv);
}

/* ---- What goes wrong. ---- */

static void test_errors(void **state)
{
    (void)state;
    expect(PINCH(folder, "study", "small.json", "--out", "r.sqlite", "--limit", "5", "--quiet"), 0);
    char *before = dump("r.sqlite");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "r.sqlite"), 2, "--resume");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "r.sqlite", "--resume", "--step", "0.002"), 2,
                "not those");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "r.sqlite", "--resume", "--contact-solver", "quickstep"),
                2, "not those");
    char changed[sizeof study_text];
    memcpy(changed, study_text, sizeof changed);
    *strstr(changed, "0.002") = '1';
    free(program_write_file(folder, "changed.json", changed));
    cli_refused(PINCH(folder, "study", "changed.json", "--out", "r.sqlite", "--resume"), 2,
                "not those of changed.json");
    expect_same("r.sqlite", before);
    free(before);
    free(program_write_file(folder, "text.sqlite", "this is a text and no database at all, whatever its name may say"));
    cli_refused(PINCH(folder, "study", "small.json", "--out", "text.sqlite", "--resume"), 2, "no database");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "nowhere/r.sqlite"), 3, "cannot be written");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "."), 2, "--out");
    /* what would be written at the end is refused at the start */
    cli_refused(PINCH(folder, "study", "small.json", "--out", "late.sqlite", "--csv", "nowhere/r.csv"), 3,
                "nowhere/r.csv");
    cli_refused(PINCH(folder, "study", "small.json", "--out", "late.sqlite", "--report", "nowhere/r.html"), 3,
                "nowhere/r.html");
    char path[4096];
    struct stat about;
    snprintf(path, sizeof path, "%s/late.sqlite", folder);
    assert_int_not_equal(stat(path, &about), 0);
}

/* A page in the middle is overwritten. */
static void test_damaged(void **state)
{
    (void)state;
    char path[4096];
    struct stat about;
    expect(PINCH(folder, "study", "small.json", "--out", "hurt.sqlite", "--quiet"), 0);
    snprintf(path, sizeof path, "%s/hurt.sqlite", folder);
    assert_int_equal(stat(path, &about), 0);
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    char noise[4096];
    memset(noise, 0xa5, sizeof noise);
    for (long page = 4; page * 4096L + 4096 <= about.st_size && page < 12; page++) {
        fseek(file, page * 4096L, SEEK_SET);
        fwrite(noise, 1, sizeof noise, file);
    }
    fclose(file);
    cli_refused(PINCH(folder, "study", "small.json", "--out", "hurt.sqlite", "--resume"), 2, "damaged");
}

/* Files that may not grow beyond 64 KiB are a disk that is full. */
static void test_full_disk(void **state)
{
    (void)state;
    char script[4096];
    snprintf(script, sizeof script,
             "trap '' XFSZ; ulimit -f 64; exec %s study small.json --out full.sqlite --jobs 2 --quiet",
             PINCH_EXECUTABLE);
    program_result r = program_run(folder, (char *[]){"/bin/sh", "-c", script, NULL});
    assert_int_equal(r.status, 3);
    assert_non_null(strstr(r.err, "full.sqlite"));
    program_free(&r);
    expect(PINCH(folder, "study", "small.json", "--out", "full.sqlite", "--resume", "--quiet"), 0);
    char *reference = dump("one.sqlite");
    expect_same("full.sqlite", reference);
    free(reference);
}

static void test_schema(void **state)
{
    (void)state;
    json_error_t error;
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-study-1.json", 0, &error);
    json_t *document = json_loads(study_text, JSON_DECODE_INT_AS_REAL, &error);
    assert_non_null(schema);
    assert_int_equal(schema_faults(schema, document), 0);
    json_object_set_new(document, "success", json_loads("{\"no_events\": [\"limit\"]}", 0, &error));
    assert_int_equal(schema_faults(schema, document), 0);
    json_object_set_new(document, "colour", json_true());
    assert_true(schema_faults(schema, document) > 0);
    json_decref(document);
    json_decref(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_rows),  cmocka_unit_test(test_interrupt),    cmocka_unit_test(test_mpi),
        cmocka_unit_test(test_report),     cmocka_unit_test(test_report_plays), cmocka_unit_test(test_report_texts),
        cmocka_unit_test(test_statistics), cmocka_unit_test(test_one_trial),    cmocka_unit_test(test_quoted_names),
        cmocka_unit_test(test_least),      cmocka_unit_test(test_errors),       cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_full_disk),  cmocka_unit_test(test_schema),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
