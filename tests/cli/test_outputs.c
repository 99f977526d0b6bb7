/*
 * What a command leaves behind when something goes wrong around it: standard streams that are closed, a full disk,
 * signals, names that clash. Its outputs are whole or not there, and the exit status says what happened.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/sanitized.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STUDY(name) PINCH_SOURCE_DIR "/assets/studies/" name

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

/* Nor do they take the place of what options and scenes name. */
static void test_named_files_stay(void **state)
{
    (void)state;
    static const char cube[] = "o cube\nv 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    static const char scene[] = "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"mesh\", "
                                "\"file\": \"m.obj\"}, \"mass\": 1}, "
                                "\"fingers\": [{\"name\": \"f\", \"point\": [0, 0, -0.025], \"normal\": [0, 0, 1], "
                                "\"tip\": {\"type\": \"sphere\", "
                                "\"radius\": 0.008}, \"model\": \"hard\", \"stiffness\": {\"normal\": 1e4, "
                                "\"tangential\": 1e4}, \"friction\": 1, "
                                "\"closing\": 0}], \"simulation\": {\"duration\": 0.01}}";
    char *folder = program_make_folder();
    char *mesh = program_write_file(folder, "m.obj", cube);
    free(program_write_file(folder, "s.json", scene));
    free(program_write_file(folder, "study.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"s.json\", \"trials\": {\"samples\": 2}, "
                            "\"vary\": [{\"path\": \"/object/mass\", \"uniform\": [0.4, 0.5]}]}"));
    char *state_file = program_write_file(folder, "state", "kept");
    static const char read[] = "is the file that is read";
    cli_refused(PINCH(folder, "run", "s.json", "--csv", "-"), 2, "(/dev/stdout for standard output), got \"-\"");
    cli_refused(PINCH(folder, "run", "s.json", "--csv", "m.obj"), 2, read);
    cli_refused(PINCH(folder, "run", "s.json", "--checkpoint", "m.obj"), 2, read);
    cli_refused(PINCH(folder, "run", "s.json", "--resume", "state", "--csv", "state"), 2, read);
    cli_refused(PINCH(folder, "compare", "s.json", "--csv", "state", "--check", "state"), 2, read);
    cli_refused(PINCH(folder, "exec", "--config", "state", "--stats", "state", "--", "true"), 2, read);
    cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite", "--csv", "m.obj"), 2, read);
    cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite", "--csv", "s.json"), 2, read);
    cli_refused(PINCH(folder, "study", "study.json", "--trial", "0", "--gltf", "m.obj"), 2, read);
    char *after = program_read_file(mesh), *state_after = program_read_file(state_file);
    assert_string_equal(after, cube);
    assert_string_equal(state_after, "kept");
    assert_int_equal(program_count_entries(folder), 4);
    free(after);
    free(state_after);
    free(mesh);
    free(state_file);
    program_remove_folder(folder);
}

/* A pipe without anybody at its other end does not block; with somebody it is read and written as a file. */
static void test_pipes(void **state)
{
    (void)state;
    static const char *const lines[] = {"run p",
                                        "solve p",
                                        "validate p",
                                        "lcp p",
                                        "hand p",
                                        "replay p",
                                        "compare p",
                                        "study p --print",
                                        "study " PINCH_SOURCE_DIR
                                        "/assets/studies/step-size.json --out o.sqlite --beside p --limit 1 --quiet"};
    char *folder = program_make_folder(), command[512];
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        snprintf(command, sizeof command, "mkfifo p 2>&-; timeout -k 1 20 " PINCH_EXECUTABLE " %s", lines[i]);
        cli_refused(run_shell(folder, command), 2, "p");
    }
    cli_refused(run_shell(folder, "timeout -k 1 20 " PINCH_EXECUTABLE " run " SCENE("egg.json") " --csv p"), 3,
                "p: cannot be written");
    program_result r =
        run_shell(folder, "rm -f p o.sqlite*; (sleep 0.2; cat " SCENE(
                              "egg.json") ") | " PINCH_EXECUTABLE
                                          " run /dev/fd/0 --duration 0.01 --quiet --csv /dev/fd/1 | wc -l");
    assert_int_equal(r.status, 0);
    if (!strstr(r.out, "11\n")) fail_msg("the pipe had %s, %s", r.out, r.err);
    program_free(&r);
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
        {"run " SCENE("egg.json") " --duration 0.5 --quiet --csv table.csv",
         "table.csv: cannot be written: No space left on device"},
        {"run " SCENE("egg.json") " --duration 0.5 --quiet --checkpoint run.state --every 50",
         "run.state: cannot be written: No space left on device"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --view page.html",
         "page.html: cannot be written: No space left on device"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --gltf run.glb",
         "run.glb: cannot be written: No space left on device"},
        {"compare " SCENE("egg.json") " --duration 0.1 --samples 2 --quiet --save base.json",
         "base.json: cannot be written: No space left on device"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out o.sqlite", "o.sqlite: the disk is full"},
        {"run " SCENE("egg.json") " --duration 0.1 --quiet --record . --record-all",
         "/d: an island could not be written"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out ../o.sqlite --csv table.csv",
         "table.csv: cannot be written: No space left on device"},
        {"study " STUDY("step-size.json") " --limit 1 --jobs 1 --quiet --out ../o.sqlite --report page.html",
         "page.html: cannot be written: No space left on device"},
        {"bench paper --faces 4 --budget 0.01 --quiet --report page.html",
         "page.html: cannot be written: No space left on device"},
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

/* A limit on the size of files is as a full disk. */
static void test_limited_files(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    cli_refused(run_shell(folder, "ulimit -f 1; exec " PINCH_EXECUTABLE
                                  " run " SCENE("egg.json") " --duration 0.1 --quiet --csv t"),
                3, "t: cannot be written");
    cli_refused(run_shell(folder, "ulimit -f 1; exec " PINCH_EXECUTABLE
                                  " run " SCENE("egg.json") " --duration 0.1 --quiet --checkpoint c --every 5"),
                3, "c: cannot be written");
    program_result none = run_shell(folder, "ulimit -f 0; exec " PINCH_EXECUTABLE " exec --stats s.json -- true");
    int without = none.status; /* not even the message can be written into the file that takes it here */
    program_free(&none);
    assert_int_equal(program_count_entries(folder), 0);
    program_result r =
        run_shell(folder, "ulimit -f 1; exec " PINCH_EXECUTABLE " exec -- sh -c 'head -c 9999 /dev/zero >z'");
    program_result plain = run_shell(folder, "ulimit -f 1; exec sh -c 'head -c 9999 /dev/zero >z'");
    int status = r.status, wanted = plain.status;
    program_free(&plain);
    program_free(&r);
    program_remove_folder(folder);
    assert_int_equal(without, 3);
    /* a library with sanitizers is not loaded into a shell without */
    if (!SANITIZED) assert_int_equal(status, wanted);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_streams),
        cmocka_unit_test(test_foreign_child),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_limited_files),
        cmocka_unit_test(test_pipes),
        cmocka_unit_test(test_named_files_stay),
        cmocka_unit_test(test_outputs_are_apart),
        cmocka_unit_test(test_control_characters),
        cmocka_unit_test(test_interrupted_run),
        cmocka_unit_test(test_interrupted_compare),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
