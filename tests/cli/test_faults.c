/*
 * Takes something away from the command while it works: memory, its standard streams, its parent. It must say so, with
 * the right exit status, and never print a document that lacks a part as if it were whole. With the name of a command
 * as argument, memory is taken away from that one alone; with `forks` behind it by forks alone (see starved.c), and
 * with `runs` by runs alone.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"

#ifdef FCLIB_FOUND
#include <fclib.h>
#endif
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#define HAND(name)  PINCH_SOURCE_DIR "/assets/hands/" name
#define STUDY(name) PINCH_SOURCE_DIR "/assets/studies/" name

#ifdef PINCH_STARVED

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
    /* a process that reads a file with FCLIB is there to crash in its place */
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

#endif

static program_result run_shell(const char *folder, const char *line)
{
    char shell[] = "/bin/sh", option[] = "-c", text[4096];
    snprintf(text, sizeof text, "%s", line);
    return program_run(folder, (char *const[]){shell, option, text, NULL});
}

/* A stream that the caller has closed: the next file must not take its number. */
static void test_closed_streams(void **state)
{
    (void)state;
    program_result r =
        run_shell(NULL, PINCH_EXECUTABLE " compare " SCENE("egg.json") " --duration 0.1 --samples 2 --json 2>&-");
    assert_int_equal(r.status, 0);
    json_t *document = cli_document(&r);
    assert_int_equal(json_array_size(json_object_get(document, "scenes")), 1);
    json_decref(document);
    program_free(&r);
    cli_refused(run_shell(NULL, PINCH_EXECUTABLE " run " SCENE("egg.json") " --duration 0.1 >&-"), 3,
                "cannot write to standard output");
    cli_refused(run_shell(NULL, PINCH_EXECUTABLE " run " SCENE("egg.json") " --duration 0.1 >/dev/full"), 3,
                "cannot write to standard output");
}

/* Whoever starts pinch may leave a child of his own to it, which ends while pinch waits for its jobs. */
static void test_foreign_child(void **state)
{
    (void)state;
    program_result r = run_shell(NULL, "sleep 0.1 & exec " PINCH_EXECUTABLE " compare " SCENE("egg.json") " " SCENE(
                                           "mug.json") " --duration 0.5 --samples 2 --quiet");
    assert_int_equal(r.status, 0);
    program_free(&r);
}

/* An output never takes the place of an input, and two outputs never share a file. */
static void test_outputs_are_apart(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *text = program_read_file(SCENE("egg.json"));
    char *path = program_write_file(folder, "egg.json", text);
    cli_refused(PINCH(folder, "run", "egg.json", "--csv", "./egg.json"), 2, "egg.json is the file that is read");
    cli_refused(PINCH(folder, "compare", "egg.json", "--save", "egg.json"), 2, "is the file that is read");
    cli_refused(PINCH(folder, "compare", "egg.json", "--csv", "a", "--report", "a"), 2, "two files");
    char *after = program_read_file(path);
    assert_string_equal(after, text);
    assert_int_equal(program_count_entries(folder), 1);
    free(after);
    free(path);
    free(text);
    program_remove_folder(folder);
}

/* A name with control characters reaches the terminal as text. */
static void test_control_characters(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "validate", "no\x1b[31mwhere\n.json");
    assert_int_equal(r.status, 2);
    assert_null(strchr(r.err, 0x1b));
    program_free(&r);
    cli_refused(
        PINCH(NULL, "bench", "step", "--plot", "a\n!touch b", "--budget", "0.001", "--max-size", "3", "--quiet"), 2,
        "--plot");
}

/* Ends a run in the middle: what was done is kept in whole rows, and the exit status tells the signal. */
static void interrupt(int number)
{
    char *folder = program_make_folder(), command[1024], path[512];
    snprintf(command, sizeof command,
             PINCH_EXECUTABLE " run " SCENE("egg.json") " --duration 1000 --json --csv table.csv & "
                                                        "sleep 0.3; kill -%d $!; wait $!",
             number);
    program_result r = run_shell(folder, command);
    assert_int_equal(r.status, 128 + number);
    assert_non_null(strstr(r.err, "interrupted at"));
    json_t *document = cli_document(&r);
    assert_true(json_is_true(json_object_get(document, "interrupted")));
    long steps = (long)json_integer_value(json_object_get(document, "steps")), lines = 0;
    assert_true(steps > 0);
    snprintf(path, sizeof path, "%s/table.csv", folder);
    char *table = program_read_file(path);
    for (const char *c = table; *c; c++) lines += *c == '\n';
    assert_int_equal(lines, steps + 1);
    assert_int_equal(program_count_entries(folder), 1);
    free(table);
    json_decref(document);
    program_free(&r);
    program_remove_folder(folder);
}

static void test_interrupted_run(void **state)
{
    (void)state;
    interrupt(SIGINT);
    interrupt(SIGTERM);
}

/* A comparison that is interrupted writes no baseline and leaves no process behind; nor does one that is killed. */
static void test_interrupted_compare(void **state)
{
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM, SIGKILL};
    for (int i = 0; i < 3; i++) {
        char *folder = program_make_folder(), command[2048];
        /* the duration is a mark by which the shell finds the processes of this test */
        snprintf(
            command, sizeof command,
            PINCH_EXECUTABLE " compare " SCENE("egg.json") " " SCENE(
                "mug.json") " --duration 987.125 --save base.json --quiet & sleep 0.3; kill -%d $!; wait $!; "
                            "status=$?; "
                            "sleep 0.2; for p in /proc/[0-9]*/cmdline; do tr '\\0' ' ' <$p; echo; done 2>/dev/null | "
                            "grep -c '^[^ ]*/pinch compare .*987.125'; exit $status",
            signals[i]);
        program_result r = run_shell(folder, command);
        assert_int_equal(r.status, 128 + signals[i]);
        assert_string_equal(r.out, "0\n");
        if (signals[i] != SIGKILL) assert_non_null(strstr(r.err, "interrupted after 0 of 2 scenes"));
        assert_int_equal(program_count_entries(folder), 0);
        program_free(&r);
        program_remove_folder(folder);
    }
}

/* On a full disk every command says which file it could not write, or the folder of one, and ends with 3. What was
 * there stays, and nothing is left behind but what the shell has made and the trials of a study. The disk is one in
 * memory, of 64 kB, in a name space of its own; where that is not allowed, there is nothing to test. */
static void test_full_disk(void **state)
{
    (void)state;
    static const struct {
        const char *line, *says;
    } cases[] = {
        {"run " SCENE("egg.json") " --duration 0.5 --quiet --csv table.csv", "table.csv: cannot be written"},
        {"run " SCENE("egg.json") " --duration 0.5 --quiet --checkpoint run.state --every 50",
         "run.state: cannot be written"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --view page.html", "page.html: cannot be written"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --gltf run.glb", "run.glb: cannot be written"},
        {"compare " SCENE("egg.json") " --duration 0.1 --samples 2 --quiet --save base.json",
         "base.json: cannot be written"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out o.sqlite", "o.sqlite: the disk is full"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --record . --record-all",
         "/d: an island could not be written"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out ../o.sqlite --csv table.csv",
         "table.csv: cannot be written"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out ../o.sqlite --report page.html",
         "page.html: cannot be written"},
        {"bench paper --faces 4 --quiet --report page.html", "page.html: cannot be written"},
        {"solve " SCENE("paper/example-1.json") " --json >table.json", "cannot write to standard output"},
        {"exec --stats stats.json -- /bin/true", "stats.json cannot be written"},
        {"exec --stats run.state -- /bin/true", "run.state cannot be written"},
    };
    program_result able = run_shell(NULL, "unshare -rm true");
    bool allowed = able.status == 0;
    program_free(&able);
    if (!allowed) {
        print_message("no name spaces: the full disk is not tested\n");
        skip();
    }
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *folder = program_make_folder(), line[2048];
        snprintf(line, sizeof line,
                 "unshare -rm sh -c 'mkdir d && mount -t tmpfs -o size=64k none d && cd d && "
                 "printf kept >run.state && (dd if=/dev/zero of=fill bs=512 2>/dev/null; %s %s; status=$?; "
                 "test \"$(cat run.state)\" = kept || exit 99; "
                 "ls | grep -Evq \"^(fill|run.state|table.json|o.sqlite.*)\\$\" && exit 98; "
                 "exit $status)'; status=$?; rmdir d; exit $status",
                 PINCH_EXECUTABLE, cases[i].line);
        cli_refused(run_shell(folder, line), 3, cases[i].says);
        program_remove_folder(folder);
    }
}

int main(int argc, char **argv)
{
    (void)argc, (void)argv;
    const struct CMUnitTest tests[] = {
#ifdef PINCH_STARVED
        cmocka_unit_test(test_memory),
#endif
        cmocka_unit_test(test_closed_streams),
        cmocka_unit_test(test_foreign_child),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_outputs_are_apart),
        cmocka_unit_test(test_control_characters),
        cmocka_unit_test(test_interrupted_run),
        cmocka_unit_test(test_interrupted_compare),
    };
#ifdef PINCH_STARVED
    only = argc > 1 ? argv[1] : NULL;
    only_by = argc > 2 ? argv[2] : NULL;
#endif
    return cmocka_run_group_tests(tests, NULL, NULL);
}
