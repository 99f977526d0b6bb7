/* Runs the real `pinch validate` on good and on broken scene files. */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "cli/broken_scenes.h"
#include "support/program.h"

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static program_result pinch(const char *folder, char *a, char *b, char *c)
{
    char executable[] = PINCH_EXECUTABLE;
    char *argv[] = {executable, a, b, c, NULL};
    return program_run(folder, argv);
}

static char *replace_first(const char *text, const char *find, const char *replacement)
{
    const char *at = strstr(text, find);
    assert_non_null(at);
    size_t head = (size_t)(at - text), size = strlen(text) + strlen(replacement) + 1;
    char *result = malloc(size);
    assert_non_null(result);
    snprintf(result, size, "%.*s%s%s", (int)head, text, replacement, at + strlen(find));
    return result;
}

static int line_of(const char *text, const char *what)
{
    const char *at = strstr(text, what);
    assert_non_null(at);
    int line = 1;
    for (const char *c = text; c < at; c++) line += *c == '\n';
    return line;
}

static bool is_one_line(const char *text)
{
    const char *end = strchr(text, '\n');
    return end && end != text && end[1] == '\0';
}

/* what is wrong with the answer to one broken scene; NULL: nothing */
static const char *judge(const broken_scene *b, const char *text, const program_result *r, const char *folder)
{
    char start[64], path[256];
    snprintf(start, sizeof start, "broken.json:%d: ", line_of(text, b->line_of));
    snprintf(path, sizeof path, ": %s: expected ", b->path);
    if (r->status != 2) return "exit status is not 2";
    if (*r->out) return "something on standard output";
    if (!is_one_line(r->err)) return "not one line";
    if (strncmp(r->err, start, strlen(start)) != 0) return "not file and line";
    if (!strstr(r->err, path)) return "not the path";
    if (!strstr(r->err, b->expectation)) return "not the expectation";
    if (program_count_entries(folder) != 1) return "something was written";
    return NULL;
}

static void test_broken_scenes(void **state)
{
    (void)state;
    int wrong = 0;
    assert_true(broken_scene_count >= 40);
    for (size_t i = 0; i < broken_scene_count; i++) {
        const broken_scene *b = &broken_scenes[i];
        char *folder = program_make_folder();
        char *text = replace_first(b->base, b->find, b->replacement);
        char *path = program_write_file(folder, "broken.json", text);
        program_result r = pinch(folder, "validate", "broken.json", NULL);
        const char *fault = judge(b, text, &r, folder);
        if (fault) {
            print_error("%s: %s (wanted line %d, %s, \"%s\"); status %d, said: %s%s\n", b->kind, fault,
                        line_of(text, b->line_of), b->path, b->expectation, r.status, r.err, r.out);
            wrong++;
        }
        program_free(&r);
        free(path);
        free(text);
        program_remove_folder(folder);
    }
    assert_int_equal(wrong, 0);
}

static void assert_refused(const char *folder, char *file, const char *said)
{
    program_result r = pinch(folder, "validate", file, NULL);
    if (r.status != 2 || *r.out || !is_one_line(r.err) || !strstr(r.err, file) || !strstr(r.err, said))
        fail_msg("%s: status %d, said: %s%s", file, r.status, r.err, r.out);
    program_free(&r);
}

static void test_unreadable_files(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "empty.json", ""));
    free(program_write_file(folder, "line.json", "\xff\xfe\n"));
    assert_refused(folder, "missing.json", "No such file");
    assert_refused(folder, ".", "Is a directory");
    assert_refused(folder, "empty.json", "valid JSON");
    free(program_write_file(folder, "marked.json", "\xEF\xBB\xBF\n{"));
    assert_refused(folder, "marked.json", "marked.json:2: (top level): expected valid JSON");
    free(program_write_file(folder, "mark.json", "\xEF\xBB\xBF"));
    assert_refused(folder, "mark.json", "valid JSON");
    char marked[4096];
    snprintf(marked, sizeof marked, "\xEF\xBB\xBF%s", good_scene);
    free(program_write_file(folder, "good.json", marked));
    program_result r = pinch(folder, "validate", "good.json", NULL);
    assert_int_equal(r.status, 0);
    program_free(&r);
    assert_refused(folder, "line.json", "valid JSON");
    if (geteuid() != 0) {
        char *path = program_write_file(folder, "secret.json", good_scene);
        assert_int_equal(chmod(path, 0), 0);
        assert_refused(folder, "secret.json", "ermission denied");
        free(path);
    }
    program_remove_folder(folder);
}

/* A file of some megabytes must not need gigabytes, nor minutes. */
static void test_huge_documents(void **state)
{
    (void)state;
    enum { LISTS = 5000000, FINGERS = 20000 };
    char *folder = program_make_folder(), *text = malloc(4 * (size_t)LISTS + 4);
    assert_non_null(text);
    for (size_t k = 0; k < LISTS; k++) memcpy(text + 3 * k, k ? ",[]" : "[[]", 3);
    memcpy(text + 3 * (size_t)LISTS, "]", 2);
    free(program_write_file(folder, "lists.json", text));
    assert_refused(folder, "lists.json", "1024 MiB of memory");
    free(text);

    size_t length;
    FILE *stream = open_memstream(&text, &length);
    assert_non_null(stream);
    fputs(
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 1}, \"mass\": 1}, "
        "\"fingers\": [",
        stream);
    for (int k = 0; k <= FINGERS; k++)
        fprintf(stream,
                "%s{\"name\": \"f%d\", \"point\": [0, 0, 1], \"normal\": [0, 0, -1], \"model\": \"frictionless\", "
                "\"stiffness\": {\"normal\": 1}}",
                k ? ",\n" : "", k % FINGERS);
    fputs("]}", stream);
    fclose(stream);
    free(program_write_file(folder, "twice.json", text));
    assert_refused(folder, "twice.json",
                   "fingers[20000].name: expected a name of its own, but fingers[0] has the same");
    free(text);
    program_remove_folder(folder);
}

/* a message stays one line, whatever the file puts into it */
static void test_hostile_texts(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "key.json", "{\"format\": \"pinch-scene/1\", \"a\\nb\\u001b[31m\": 1}"));
    assert_refused(folder, "key.json", "a known key");
    char *deep = malloc(3 * 3000 + 1);
    assert_non_null(deep);
    memset(deep, '[', 3000);
    memset(deep + 3000, ']', 3000);
    deep[6000] = '\0';
    free(program_write_file(folder, "deep.json", deep));
    assert_refused(folder, "deep.json", "JSON");
    memset(deep, 'k', 9000);
    memcpy(deep, "{\"", 2);
    memcpy(deep + 8995, "\":1}", 5);
    free(program_write_file(folder, "long.json", deep));
    assert_refused(folder, "long.json", "a known key");
    free(deep);
    program_remove_folder(folder);
}

static void assert_round_trip(char *scene)
{
    char *folder = program_make_folder();
    program_result first = pinch(NULL, "validate", "--print", scene);
    if (first.status != 0) fail_msg("%s: %s", scene, first.err);
    char *path = program_write_file(folder, "printed.json", first.out);
    program_result second = pinch(NULL, "validate", "--print", path);
    assert_int_equal(second.status, 0);
    assert_string_equal(second.out, first.out);
    /* nothing moves a second time, but what lies in a file of its own */
    if (!strstr(first.out, "\"type\": \"mesh\"")) assert_string_equal(second.err, "");
    program_free(&first);
    program_free(&second);
    program_remove_folder(folder);
    free(path);
}

static void test_print_round_trip(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *texts[] = {
        replace_first(good_scene, "\"name\": \"good\",", ""),
        replace_first(good_plane, "[1, 0, 0, 0]", "[3, 0, 0, 3]"),
        /* what is not unit, not perpendicular and not centred in the file */
        replace_first(good_scene, "\"tangent\": [0, 1, 0]", "\"tangent\": [0.3, 0.1, 0.77]"),
        replace_first(good_scene, "\"normal\": [1, 0, 0]", "\"normal\": [0.3, 0.1, 0.07]"),
        replace_first(good_scene, "{\"type\": \"sphere\", \"radius\": 0.01}",
                      "{\"type\": \"convex\", \"vertices\": [[1, 1, 1], [1.1, 1, 1], [1, 1.3, 1], [1, 1, 1.7], "
                      "[1.2, 1.1, 1.3]]}"),
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        char *path = program_write_file(folder, "scene.json", texts[i]);
        assert_round_trip(path);
        free(path);
        free(texts[i]);
    }
    program_remove_folder(folder);
}

static void each_shipped_scene(const char *path, void (*act)(char *))
{
    DIR *stream = opendir(path);
    assert_non_null(stream);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(stream));) {
        const char *suffix = strrchr(entry->d_name, '.');
        if (!suffix || strcmp(suffix, ".json") != 0) continue;
        char file[1024];
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        act(file);
        count++;
    }
    closedir(stream);
    assert_true(count >= 5);
}

static void test_shipped_scenes(void **state)
{
    (void)state;
    each_shipped_scene(PINCH_SOURCE_DIR "/assets/scenes", assert_round_trip);
    each_shipped_scene(PINCH_SOURCE_DIR "/assets/scenes/paper", assert_round_trip);
}

static void test_json_verdict(void **state)
{
    (void)state;
    char scene[] = PINCH_SOURCE_DIR "/assets/scenes/example-2.json";
    program_result r = pinch(NULL, "validate", "--json", scene);
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "\"command\": \"validate\""));
    assert_non_null(strstr(r.out, "\"valid\": true"));
    assert_non_null(strstr(r.out, "\"shift\": [0.0166"));
    program_free(&r);
    r = pinch(NULL, "validate", "--quiet", scene);
    assert_int_equal(r.status, 0);
    assert_string_equal(r.out, "");
    assert_string_equal(r.err, "");
    program_free(&r);
}

/* one bad scene among good ones does not hide behind them */
static void test_several_scenes(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "good.json", good_scene));
    free(program_write_file(folder, "bad.json", "{}"));
    program_result r = pinch(folder, "validate", "bad.json", "good.json");
    assert_int_equal(r.status, 2);
    assert_string_equal(r.out, "good.json: valid\n");
    assert_non_null(strstr(r.err, "bad.json:1: format: expected"));
    program_free(&r);
    program_remove_folder(folder);
}

/* A pair that no run does is refused as a run refuses it. */
static void test_solver_pair(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *text = replace_first(good_plane, "{", "{\"solver\": {\"name\": \"pgs\", \"formulation\": \"coulomb\"}, ");
    free(program_write_file(folder, "pgs.json", text));
    assert_refused(folder, "pgs.json",
                   "solver pgs does not do formulation coulomb here; there are nsnmgk with coulomb");
    free(text);
    program_remove_folder(folder);
}

static void assert_usage_error(char *a, char *b, char *c, const char *said)
{
    program_result r = pinch(NULL, a, b, c);
    if (r.status != 2 || *r.out || !is_one_line(r.err) || !strstr(r.err, said))
        fail_msg("%s: status %d, said: %s%s", said, r.status, r.err, r.out);
    program_free(&r);
}

static void test_usage(void **state)
{
    (void)state;
    assert_usage_error("grasp", NULL, NULL, "unknown command \"grasp\"");
    assert_usage_error("validate", NULL, NULL, "expected SCENE...");
    assert_usage_error("validate", "--frobnicate", "x.json", "unknown option --frobnicate; it takes");
    assert_usage_error("validate", "--solver=newton", "x.json", "unknown option --solver;");
    assert_usage_error("validate", "-q", "x.json", "unknown option -q");
    assert_usage_error("validate", "--json=yes", "x.json", "--json takes no value");
    program_result r = pinch(NULL, NULL, NULL, NULL);
    assert_int_equal(r.status, 2);
    assert_string_equal(r.out, "");
    program_free(&r);
}

static void assert_says(char *a, char *b, const char *said)
{
    program_result r = pinch(NULL, a, b, NULL);
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, said));
    assert_string_equal(r.err, "");
    program_free(&r);
}

static void test_help_and_version(void **state)
{
    (void)state;
    assert_says("--help", NULL, "validate");
    assert_says("--version", NULL, "pinch ");
    assert_says("validate", "--help", "--print");
    assert_says("validate", "--version", "pinch ");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_broken_scenes),  cmocka_unit_test(test_unreadable_files),
        cmocka_unit_test(test_hostile_texts),  cmocka_unit_test(test_print_round_trip),
        cmocka_unit_test(test_shipped_scenes), cmocka_unit_test(test_json_verdict),
        cmocka_unit_test(test_several_scenes), cmocka_unit_test(test_solver_pair),
        cmocka_unit_test(test_usage),          cmocka_unit_test(test_help_and_version),
        cmocka_unit_test(test_huge_documents),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
