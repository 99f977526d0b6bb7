#include "support/command.h"

#include "support/cmocka_all.h"

#include <stdio.h>
#include <string.h>

enum { MOST_WORDS = 80 };

program_result command_run(const char *folder, const char *const words[])
{
    static char executable[] = PINCH_EXECUTABLE;
    char *argv[MOST_WORDS + 2] = {executable};
    for (int i = 0; words[i]; i++) {
        assert_true(i < MOST_WORDS);
        argv[1 + i] = (char *)words[i]; /* execv does not write to them */
    }
    return program_run(folder, argv);
}

json_t *cli_document(const program_result *r)
{
    json_error_t error;
    json_t *document = json_loads(r->out, JSON_REJECT_DUPLICATES, &error);
    if (!document) fail_msg("%s\n%.2000s\n%s", error.text, r->out, r->err);
    assert_true(json_is_object(document));
    return document;
}

void cli_refused(program_result r, int status, const char *says)
{
    if (r.status != status || *r.out || !strstr(r.err, says))
        fail_msg("status %d (wanted %d), said \"%s\" (wanted \"%s\"), printed \"%s\"", r.status, status, r.err, says,
                 r.out);
    program_free(&r);
}

const json_t *cli_at(const json_t *document, const char *path)
{
    char key[64];
    const char *dot = strchr(path, '.');
    if (!dot) return json_object_get(document, path);
    snprintf(key, sizeof key, "%.*s", (int)(dot - path), path);
    return cli_at(json_object_get(document, key), dot + 1);
}

bool cli_is_vector(const json_t *value, size_t length)
{
    if (json_array_size(value) != length) return false;
    for (size_t i = 0; i < length; i++)
        if (!json_is_number(json_array_get(value, i))) return false;
    return true;
}

json_t *compare_document(program_result r, int status)
{
    if (r.status != status) fail_msg("status %d, not %d: %s", r.status, status, r.err);
    json_t *document = cli_document(&r);
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

char *exec_program(const char *name)
{
    static char places[8][1024];
    static int next;
    char *place = places[next++ % 8];
    snprintf(place, sizeof places[0], "%s/%s", PINCH_PROGRAMS, name);
    return place;
}

static void append(const char **words, int *count, char *const *more)
{
    for (; *more; more++) {
        assert_true(*count < MOST_WORDS);
        words[(*count)++] = *more;
    }
}

exec_run exec_program_run(char *const *options, char *const *command)
{
    char *folder = program_make_folder(), file[1024];
    const char *words[MOST_WORDS + 1] = {"exec"};
    int count = 1;
    exec_run run = {0};
    if (options) {
        snprintf(file, sizeof file, "%s/stats.json", folder);
        append(words, &count, options);
        append(words, &count, (char *[]){"--stats", file, "--", NULL});
        append(words, &count, command);
    }
    run.result = options ? command_run(NULL, words) : program_run(NULL, command);
    run.line = json_loads(run.result.out, JSON_DISABLE_EOF_CHECK, NULL);
    if (options) {
        json_error_t error;
        run.stats = json_load_file(file, JSON_REJECT_DUPLICATES, &error);
        if (!run.stats) print_error("%s: %s\n%s\n", *command, error.text, run.result.err);
        assert_non_null(run.stats);
        assert_int_equal(program_count_entries(folder), 1); /* nothing half-written is left */
    }
    program_remove_folder(folder);
    return run;
}

void exec_run_free(exec_run *run)
{
    program_free(&run->result);
    json_decref(run->line);
    json_decref(run->stats);
}

double exec_number(const json_t *document, const char *key)
{
    const json_t *value = json_object_get(document, key);
    if (!json_is_number(value)) print_error("no number %s\n", key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}
