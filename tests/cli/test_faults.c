/*
 * Takes memory away from the command while it works. It must say so, with the right exit status, and never print a
 * document that lacks a part as if it were whole. With the name of a command as argument, memory is taken away from
 * that one alone; with `forks` behind it by forks alone (see starved.c), and with `runs` by runs alone.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"

#ifdef FCLIB_FOUND
#include <fclib.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#define HAND(name)  PINCH_SOURCE_DIR "/assets/hands/" name
#define STUDY(name) PINCH_SOURCE_DIR "/assets/studies/" name

static const char *only, *only_by; /* the command that memory is taken away from, and how; NULL: all */

/* Costs differ from run to run. */
static void drop_costs(json_t *value)
{
    const char *key;
    void *next;
    json_t *member;
    size_t i;
    if (json_is_array(value)) json_array_foreach(value, i, member) drop_costs(member);
    if (!json_is_object(value)) return;
    json_object_foreach_safe(value, next, key, member)
    {
        size_t length = strlen(key);
        if ((length > 3 && strcmp(key + length - 3, "_us") == 0) || strcmp(key, "time_s") == 0 ||
            strncmp(key, "cost", 4) == 0)
            json_object_del(value, key);
        else
            drop_costs(member);
    }
}

static char *text_without_costs(const char *text)
{
    json_t *document = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    if (!document) return NULL;
    drop_costs(document);
    char *result = json_dumps(document, JSON_SORT_KEYS | JSON_REAL_PRECISION(17));
    json_decref(document);
    return result;
}

static program_result run_starved(const char *const words[], long allocation)
{
    char number[32];
    snprintf(number, sizeof number, "%ld", allocation);
    setenv("LD_PRELOAD", PINCH_STARVED, 1);
    setenv("PINCH_TEST_FAIL_ALLOCATION", number, 1);
    program_result r = command_run(NULL, words);
    unsetenv("LD_PRELOAD");
    unsetenv("PINCH_TEST_FAIL_ALLOCATION");
    return r;
}

/* What a command that memory was taken away from may do. Exit status 0 is allowed where the document is complete (the C
 * library needs no buffer for its streams, for one). Every other end is a system failure with a message, and with a
 * whole document or none. `expected` is NULL where documents differ from run to run. Returns whether the command
 * failed. */
static bool judge(const char *command, long k, const program_result *r, const char *expected)
{
    char *got = text_without_costs(r->out);
    if (r->status == 0) {
        if (!got) fail_msg("%s: allocation %ld: exit status 0 without a document", command, k);
        if (expected && strcmp(got, expected) != 0) fail_msg("%s: allocation %ld: another document", command, k);
    } else {
        /* 127: the dynamic loader could not start the program */
        if (r->status != 3 && r->status != 127)
            fail_msg("%s: allocation %ld: status %d, %s", command, k, r->status, r->err);
        if (!*r->err) fail_msg("%s: allocation %ld: status %d without a word", command, k, r->status);
        if (*r->out && !got) fail_msg("%s: allocation %ld: half a document", command, k);
    }
    free(got);
    return r->status != 0;
}

static bool asked_for(const char *command, const char *method)
{
    return (!only || strcmp(command, only) == 0) && (!only_by || strcmp(method, only_by) == 0);
}

/* Runs the command as often as it allocates, each time with another allocation that fails. */
static void starve_by_runs(const char *const words[], long stride)
{
    if (!asked_for(words[0], "runs")) return;
    program_result whole = command_run(NULL, words);
    assert_int_equal(whole.status, 0);
    char *expected = text_without_costs(whole.out);
    assert_non_null(expected);
    int failed = 0, runs = 0, enough = stride > 1 ? 10 : 40; /* in a row that do no harm: then there are no more */
    for (long k = 1, unharmed = 0; unharmed < enough; k += stride, runs++) {
        program_result r = run_starved(words, k);
        bool harmed = judge(words[0], k, &r, expected);
        unharmed = harmed ? 0 : unharmed + 1;
        failed += harmed;
        program_free(&r);
    }
    assert_true(failed > 5);
    print_message("%s: each %ld. allocation, %d of %d said that there is no memory\n", words[0], stride, failed, runs);
    free(expected);
    program_free(&whole);
}

static program_result end_of_child(const char *folder, int process, long k, int status)
{
    char path[1024];
    program_result r = {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), NULL, NULL};
    snprintf(path, sizeof path, "%s/%d-%ld.out", folder, process, k);
    r.out = program_read_file(path);
    snprintf(path, sizeof path, "%s/%d-%ld.err", folder, process, k);
    r.err = program_read_file(path);
    return r;
}

enum { LEAKED = 23 }; /* the exit status of the leak sanitizer */

/* What became of the processes that a run has forked. */
typedef struct fork_end {
    int process; /* the one that was forked */
    long k;
    program_result result;
} fork_end;

typedef struct fork_result {
    program_result whole; /* of the run that lost nothing */
    int main_process;
    fork_end *ends;
    int count;
} fork_result;

static void fork_result_free(fork_result *f)
{
    for (int i = 0; i < f->count; i++) program_free(&f->ends[i].result);
    free(f->ends);
    program_free(&f->whole);
}

/* Runs a command once, which forks at each allocation, or at each `stride`-th. No process may crash, or lose memory
 * where that is looked at. */
static fork_result run_by_forks(const char *const words[], long stride)
{
    char *folder = program_make_folder(), text[512];
    setenv("LD_PRELOAD", PINCH_STARVED, 1);
    setenv("PINCH_TEST_FAIL_FOLDER", folder, 1);
    snprintf(text, sizeof text, "%ld", stride);
    setenv("PINCH_TEST_FAIL_EVERY", text, 1);
    fork_result f = {.whole = command_run(NULL, words)};
    unsetenv("LD_PRELOAD");
    unsetenv("PINCH_TEST_FAIL_FOLDER");
    unsetenv("PINCH_TEST_FAIL_EVERY");
    snprintf(text, sizeof text, "%s/ends", folder);
    char *ends = program_read_file(text);
    for (const char *line = ends; *line; line = strchr(line, '\n') + 1) f.count++;
    f.ends = calloc((size_t)f.count + 1, sizeof *f.ends);
    assert_non_null(f.ends);
    const char *line = ends;
    for (int i = 0; i < f.count; i++, line = strchr(line, '\n') + 1) {
        fork_end *e = &f.ends[i];
        int status;
        assert_int_equal(sscanf(line, "%d %ld %d", &e->process, &e->k, &status), 3);
        f.main_process = e->process; /* the last one to fork */
        e->result = end_of_child(folder, e->process, e->k, status);
    }
    /* A process that reads a file with FCLIB is there to crash in its place: HDF5 without memory reports that there is
     * none for the report, until its stack is full (H5E_printf_stack, H5I_inc_ref). */
    bool reader = strcmp(words[0], "friction") == 0;
    for (int i = 0; i < f.count; i++) {
        const fork_end *e = &f.ends[i];
        bool crashed = e->result.status >= 128 && !(reader && e->process != f.main_process);
        if (e->result.status == LEAKED || crashed)
            fail_msg("%s: allocation %ld of process %d: status %d, %s", words[0], e->k, e->process, e->result.status,
                     e->result.err);
    }
    free(ends);
    program_remove_folder(folder);
    return f;
}

/* The same with one run, which forks where it allocates. Processes that the command itself forks have no document, and
 * exit statuses that it understands; what it says of them is seen in runs. Where `measures`, the document has measured
 * values that no two runs share. */
static void starve_by_forks(const char *const words[], long stride, bool measures)
{
    if (!asked_for(words[0], "forks")) return;
    fork_result f = run_by_forks(words, stride);
    if (f.whole.status != 0) fail_msg("%s: status %d, %s", words[0], f.whole.status, f.whole.err);
    char *expected = text_without_costs(f.whole.out);
    int failed = 0;
    assert_non_null(expected);
    for (int i = 0; i < f.count; i++)
        if (f.ends[i].process == f.main_process)
            failed += judge(words[0], f.ends[i].k, &f.ends[i].result, measures ? NULL : expected);
    assert_true(failed > 5);
    print_message("%s: each %ld. allocation, %d of %d forks said that there is no memory\n", words[0], stride, failed,
                  f.count);
    free(expected);
    fork_result_free(&f);
}

/* `pinch exec` becomes the program and prints nothing itself: here the program is not there, so that all it does comes
 * to an end of its own. */
static void starve_exec(const char *folder)
{
    char stats[512], program[512];
    snprintf(stats, sizeof stats, "%s/stats.json", folder);
    snprintf(program, sizeof program, "%s/nowhere", folder);
    const char *const words[] = {"exec", "--stats", stats, "--record", folder, "--", program, NULL};
    int failed = 0, runs = 0;
    for (long k = 1, unharmed = 0; unharmed < 40; k++, runs++) {
        program_result r = run_starved(words, k);
        if ((r.status != 3 && r.status != 127) || !*r.err)
            fail_msg("exec: allocation %ld: status %d, %s", k, r.status, r.err);
        unharmed = r.status == 3 ? 0 : unharmed + 1;
        failed += r.status == 3;
        program_free(&r);
    }
    assert_true(failed > 5);
    print_message("exec: each allocation, %d of %d said that there is no memory\n", failed, runs);
}

/* A program under `pinch exec`: where Pinch gets no memory, ODE takes the step, and the program does not notice. What
 * ODE itself asks for is left alone: it does not look at what it gets. In runs, because the library holds its lock
 * while it allocates, and a fork would wait for that. */
static void starve_program(const char *name, const char *stepper, long stride)
{
    const char *const words[] = {"exec", "--", exec_program(name), "--steps", "30", "--stepper", stepper, NULL};
    program_result whole = command_run(NULL, words);
    int harmed = 0, runs = 0, enough = stride > 1 ? 10 : 40;
    setenv("PINCH_TEST_FAIL_IN", "libpinch_preload:libqhull", 1);
    for (long k = 1, unharmed = 0; unharmed < enough && runs < 2000; k += stride, runs++) {
        program_result r = run_starved(words, k);
        if (r.status != 0 || !strstr(r.out, "\"finite\": true"))
            fail_msg("%s under exec: allocation %ld: status %d, %s%s", name, k, r.status, r.out, r.err);
        bool same = strcmp(r.out, whole.out) == 0 && strcmp(r.err, whole.err) == 0;
        unharmed = same ? unharmed + 1 : 0;
        harmed += !same;
        program_free(&r);
    }
    unsetenv("PINCH_TEST_FAIL_IN");
    assert_true(harmed > 0);
    print_message("%s under exec, %s: each %ld. allocation of Pinch, %d of %d runs ended otherwise, all in order\n",
                  name, stepper, stride, harmed, runs);
    program_free(&whole);
}

#ifdef FCLIB_FOUND
/* Writes the problem of a point that slips. */
static char *write_point(const char *folder)
{
    char none[] = "none", path[512];
    int p[] = {0, 1, 2, 3}, rows[] = {0, 1, 2};
    double w[] = {0.5, 0.5, 0.5}, q[] = {-1, 2, 0}, mu = 0.5;
    struct fclib_matrix_info about = {.comment = none};
    struct fclib_matrix matrix = {.m = 3, .n = 3, .nz = -1, .nzmax = 3, .p = p, .i = rows, .x = w, .info = &about};
    struct fclib_info info = {none, none, none};
    struct fclib_local problem = {.W = &matrix, .mu = &mu, .q = q, .spacedim = 3, .info = &info};
    snprintf(path, sizeof path, "%s/point.hdf5", folder);
    assert_int_equal(fclib_write_local(&problem, path), 1);
    return strdup(path);
}
#endif

static void test_memory(void **state)
{
    (void)state;
    long stride = draw_full() ? 1 : 10, widest = draw_full() ? 1 : 100;
    char *folder = program_make_folder();
    char *lcp = program_write_file(folder, "lcp.json", "{\"M\": [[2, 1], [1, 2]], \"q\": [-5, -6]}");
    const char *const of_lcp[] = {"lcp", lcp, "--json", NULL};
    starve_by_runs(of_lcp, 1);
    starve_by_forks(of_lcp, 1, false);
    const struct {
        const char *words[12];
        long stride;
        bool measures;
    } alone[] = {
        {{"solve", SCENE("paper/example-1.json"), "--json"}, stride, false},
        {{"run", SCENE("egg.json"), "--duration", "0.02", "--json"}, stride, false},
        {{"validate", SCENE("mug.json"), "--print"}, stride, false},
        {{"run", SCENE("mug.json"), "--duration", "0.002", "--json"}, stride, false},
        {{"hand", HAND("parallel-gripper.urdf"), "--json"}, stride, false},
        {{"run", SCENE("hands/parallel-gripper-lift.json"), "--duration", "0.01", "--json"}, stride, false},
        {{"study", STUDY("step-size.json"), "--trial", "1", "--json"}, stride, false},
        {{"replay", PINCH_SOURCE_DIR "/tests/cli/recorded/jointed-slip.json", "--json"}, widest, false},
        {{"bench", "step", "--max-size", "3", "--budget", "0.001", "--json", "--quiet"}, widest, true},
    };
    for (size_t i = 0; i < sizeof alone / sizeof *alone; i++)
        starve_by_forks(alone[i].words, alone[i].stride, alone[i].measures);
    const char *const comparison[] = {"compare", SCENE("egg.json"),        "--duration", "0.02",   "--samples", "2",
                                      "--json",  "--quickstep-iterations", "20",         "--jobs", "1",         NULL};
    starve_by_runs(comparison, widest);
    starve_by_forks(comparison, stride, false);
    if (asked_for("exec", "runs")) {
        static const char *const programs[] = {"stack", "gripper", "jointed"};
        starve_exec(folder);
        for (size_t i = 0; i < sizeof programs / sizeof *programs; i++) {
            starve_program(programs[i], "quick", stride);
            starve_program(programs[i], "world", stride);
        }
    }
#ifdef FCLIB_FOUND
    char *file = write_point(folder);
    const char *const friction[] = {"friction", file, "--json", NULL};
    starve_by_runs(friction, stride);
    starve_by_forks(friction, stride, false);
    free(file);
#endif
    free(lcp);
    program_remove_folder(folder);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_memory),
    };
    only = argc > 1 ? argv[1] : NULL;
    only_by = argc > 2 ? argv[2] : NULL;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
