#include "support/exec.h"

#include "support/cmocka_all.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_WORDS = 40 };

char *exec_program(const char *name)
{
    static char places[8][1024];
    static int next;
    char *place = places[next++ % 8];
    snprintf(place, sizeof places[0], "%s/%s", PINCH_PROGRAMS, name);
    return place;
}

static void append(char **argv, int *count, char *const *words)
{
    for (; words && *words; words++) {
        assert_true(*count < MOST_WORDS);
        argv[(*count)++] = *words;
    }
}

program_result exec_pinch(char *const *words)
{
    char executable[] = PINCH_EXECUTABLE, exec[] = "exec";
    char *argv[MOST_WORDS + 1] = {executable, exec};
    int count = 2;
    append(argv, &count, words);
    return program_run(NULL, argv);
}

exec_run exec_program_run(char *const *options, char *const *command)
{
    char *folder = program_make_folder(), file[1024], stats[] = "--stats", end[] = "--";
    char *argv[MOST_WORDS + 1] = {NULL};
    int count = 0;
    snprintf(file, sizeof file, "%s/stats.json", folder);
    append(argv, &count, options);
    append(argv, &count, (char *[]){stats, file, end, NULL});
    append(argv, &count, command);

    exec_run run = {0};
    run.result = options ? exec_pinch(argv) : program_run(NULL, command);
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
