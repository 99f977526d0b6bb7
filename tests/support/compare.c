#define _POSIX_C_SOURCE 200809L

#include "support/compare.h"

#include "support/cmocka_all.h"

#include <glob.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_WORDS = 60 };

program_result compare_run(const char *folder, const char *const arguments[])
{
    char *argv[MOST_WORDS + 3] = {strdup(PINCH_EXECUTABLE), strdup("compare")};
    int count = 2;
    for (; arguments[count - 2]; count++) {
        assert_true(count < MOST_WORDS);
        argv[count] = strdup(arguments[count - 2]);
    }
    program_result r = program_run(folder, argv);
    for (int i = 0; i < count; i++) free(argv[i]);
    return r;
}

json_t *compare_document(program_result r, int status)
{
    json_error_t error;
    if (r.status != status) fail_msg("status %d, not %d: %s", r.status, status, r.err);
    json_t *document = json_loads(r.out, JSON_REJECT_DUPLICATES, &error);
    if (!document) fail_msg("%s\n%.2000s", error.text, r.out);
    program_free(&r);
    return document;
}

const json_t *compare_find(const json_t *of_scene, const char *run)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    for (size_t k = 0; k < json_array_size(runs); k++) {
        const json_t *entry = json_array_get(runs, k);
        if (strcmp(json_string_value(json_object_get(entry, "run")), run) == 0) return entry;
    }
    fail_msg("no run %s", run);
    return NULL;
}

double compare_metric(const json_t *run, const char *key)
{
    const json_t *value = json_object_get(json_object_get(run, "metrics"), key);
    if (!value) fail_msg("no metric %s", key);
    if (json_is_boolean(value)) return json_is_true(value);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

const char *const *compare_shipped(void)
{
    static const char *paths[65];
    static glob_t found;
    if (paths[0]) return paths;
    assert_int_equal(glob(COMPARE_SCENE("*.json"), 0, NULL, &found), 0);
    assert_true(found.gl_pathc >= 10 && found.gl_pathc <= 64);
    for (size_t i = 0; i < found.gl_pathc; i++) paths[i] = found.gl_pathv[i];
    return paths;
}
