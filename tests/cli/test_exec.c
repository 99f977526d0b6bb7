/*
 * Runs the real `pinch exec`: exit statuses, options, configuration and statistics are right, also for programs that
 * end in odd ways.
 */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char yes[] = "/bin/true";

static int lines(const char *text)
{
    int count = 0;
    for (; *text; text++) count += *text == '\n';
    return count;
}

/* One message that names what is wrong, exit status 2, and the program not run. */
static void expect_refused(program_result r, const char *word)
{
    if (r.status != 2 || !strstr(r.err, word) || lines(r.err) != 1) print_error("%d: %s\n", r.status, r.err);
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, word));
    assert_int_equal(lines(r.err), 1);
    assert_string_equal(r.out, "");
    program_free(&r);
}

static void statuses_pass_through(void **state)
{
    (void)state;
    static char shell[] = "/bin/sh", flag[] = "-c";
    static const struct {
        char *script;
        int status;
    } cases[] = {{"exit 0", 0}, {"exit 7", 7}, {"exit 255", 255}, {"kill -TERM $$", 128 + SIGTERM}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        program_result r = EXEC("--", shell, flag, cases[i].script);
        assert_int_equal(r.status, cases[i].status);
        assert_string_equal(r.out, "");
        assert_string_equal(r.err, "");
        program_free(&r);
    }
    /* its streams and words are its own */
    program_result r = EXEC(shell, flag, "echo \"$2 $1\"; echo wrong >&2", "x", "--json", "a b");
    assert_string_equal(r.out, "a b --json\n");
    assert_string_equal(r.err, "wrong\n");
    program_free(&r);
}

static void programs_that_cannot_be_run(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *text = program_write_file(folder, "text", "no program\n");
    char stats[1024];
    snprintf(stats, sizeof stats, "%s/stats.json", folder);
    static const int statuses[] = {127, 127, 126, 126, 127};
    char *const programs[] = {"pinch-no-such-program", "/no/such/program", text, folder, ""};
    char *old = program_write_file(folder, "old.json", "precious\n");
    for (int i = 0; i < 5; i++) {
        program_result r = EXEC("--stats", stats, "--", programs[i]);
        if (r.status != statuses[i]) print_error("%s: %s\n", programs[i], r.err);
        assert_int_equal(r.status, statuses[i]);
        assert_int_equal(lines(r.err), 1);
        assert_int_equal(access(stats, F_OK), -1);
        program_free(&r);
        r = EXEC("--stats", old, "--", programs[i]); /* what was there is there again */
        program_free(&r);
        char line[16] = "";
        FILE *file = fopen(old, "r");
        assert_non_null(file);
        assert_non_null(fgets(line, sizeof line, file));
        assert_string_equal(line, "precious\n");
        fclose(file);
    }
    free(old);
    free(text);
    program_remove_folder(folder);
}

static void wrong_options(void **state)
{
    (void)state;
    expect_refused(EXEC("--stats", "-"), "PROGRAM");
    expect_refused(EXEC("--"), "PROGRAM");
    expect_refused(EXEC("--only", "hard", yes), "--only");
    expect_refused(EXEC("--kt-ratio", "0", yes), "--kt-ratio");
    expect_refused(EXEC("--kt-ratio", "10.5", yes), "--kt-ratio");
    expect_refused(EXEC("--kt-ratio", "nan", yes), "--kt-ratio");
    expect_refused(EXEC("--solver", "dantzig", yes), "--solver");
    expect_refused(EXEC("--solver", "lemke", yes), "--solver");
    expect_refused(EXEC("--solver=pgs", yes), "--solver");
    expect_refused(EXEC("--solver=lemke", yes), "newton, or nsngrk");
    expect_refused(EXEC("--tolerance", "-1", yes), "--tolerance");
    expect_refused(EXEC("--max-iterations", "0", yes), "--max-iterations");
    expect_refused(EXEC("--stats=", yes), "--stats");
    expect_refused(EXEC("--stats", "/no/such/folder/stats.json", yes), "/no/such/folder");
    expect_refused(EXEC("--stats", "/tmp", yes), "/tmp");
    expect_refused(EXEC("--stats", "/dev/null", yes), "/dev/null");
    expect_refused(EXEC("--config", "/no/such/file.json", yes), "/no/such/file.json");
    expect_refused(EXEC("--json", yes), "--json");
}

/* `text` as a configuration; `word`: what the message names */
static void expect_config_refused(const char *text, const char *word)
{
    char *folder = program_make_folder(), *file = program_write_file(folder, "c.json", text);
    program_result r = EXEC("--config", file, yes);
    assert_non_null(strstr(r.err, file));
    expect_refused(r, word);
    program_remove_folder(folder);
    free(file);
}

static void wrong_configurations(void **state)
{
    (void)state;
    char *folder = program_make_folder(), pipe[512];
    snprintf(pipe, sizeof pipe, "%s/pipe", folder); /* nobody writes to it: reading would never end */
    assert_int_equal(mkfifo(pipe, 0600), 0);
    expect_refused(EXEC("--config", pipe, yes), "pipe: cannot be read");
    program_remove_folder(folder);
    expect_config_refused("", "JSON");
    expect_config_refused("{\n\"only\": }", ":2:");
    expect_config_refused("[]", "object");
    expect_config_refused("\xEF\xBB\xBF[]", "object"); /* the byte order mark is no fault */
    expect_config_refused("{\"only\": \"hard\"}", "$.only");
    expect_config_refused("{\"only\": 1}", "$.only");
    expect_config_refused("{\"kt_ratio\": \"1\"}", "$.kt_ratio");
    expect_config_refused("{\"kt_ratio\": -1}", "$.kt_ratio");
    expect_config_refused("{\"kt_ratio\": 11}", "$.kt_ratio");
    expect_config_refused("{\"solver\": \"lemke\"}", "$.solver");
    expect_config_refused("{\"solver\": \"pgs\"}", "newton, or nsngrk");
    expect_config_refused("{\"exec_solver\": \"newton\"}", "$.exec_solver");
    expect_config_refused("{\"solver\": null}", "$.solver");
    expect_config_refused("{\"max_iterations\": 1.5}", "$.max_iterations");
    expect_config_refused("{\"tolerance\": 0}", "$.tolerance");
    expect_config_refused("{\"kt-ratio\": 1}", "$.kt-ratio");
    expect_config_refused("{\"config\": \"x\"}", "$.config");
    expect_config_refused("{\"seed\": 1}", "$.seed");
    expect_config_refused("{\"only\": \"all\", \"only\": \"soft\"}", "duplicate");
}

/* The help offers the solvers that are taken, and no other. */
static void help_names_the_solvers(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "exec", "--help");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "nsnmgk (default), newton, or nsngrk, which solves joints alone and no contacts"));
    assert_null(strstr(r.out, "lemke"));
    assert_null(strstr(r.out, "pgs"));
    program_free(&r);
}

/* nsngrk leaves contacts to ODE, and the remark at the end gives the solver as the reason. Joints that nothing touches
 * it does solve. */
static void nsngrk_solves_joints_alone(void **state)
{
    (void)state;
    exec_run r = exec_program_run((char *[]){"--solver", "nsngrk", NULL},
                                  (char *[]){exec_program("chain"), "--steps", "100", "--stepper", "quick", NULL});
    assert_int_equal(r.result.status, 0);
    assert_int_equal(exec_number(r.stats, "contacts_solved"), 0);
    assert_true(exec_number(r.stats, "contacts_left_unsupported") > 0);
    assert_true(exec_number(r.stats, "joints_solved") > 0);
    assert_non_null(strstr(r.result.err, "ODE solved 100 % of the contacts, because the solver nsngrk solves none"));
    assert_null(strstr(r.result.err, "contacts, because Pinch could not"));
    exec_run_free(&r);
}

static void settings_arrive(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *file = program_write_file(folder, "c.json",
                                    "{\"only\": \"soft\", \"kt_ratio\": 0.25, \"solver\": \"newton\", "
                                    "\"tolerance\": 1e-16, \"max_iterations\": 77}");
    exec_run r = exec_program_run((char *[]){"--config", file, "--solver", "nsngrk", NULL},
                                  (char *[]){exec_program("stack"), "--steps", "3", NULL});
    assert_int_equal(r.result.status, 0);
    const json_t *settings = json_object_get(r.stats, "settings");
    assert_string_equal(json_string_value(json_object_get(settings, "only")), "soft");
    assert_string_equal(json_string_value(json_object_get(settings, "solver")), "nsngrk");
    assert_close(exec_number(settings, "kt_ratio"), 0.25, 0);
    assert_close(exec_number(settings, "tolerance"), 1e-16, 0);
    assert_int_equal(exec_number(settings, "max_iterations"), 77);
    exec_run_free(&r);

    /* what the environment held before does not count */
    assert_int_equal(setenv("PINCH_SOLVER", "newton", 1), 0);
    r = exec_program_run((char *[]){"--only", "material", NULL},
                         (char *[]){exec_program("stack"), "--steps", "3", NULL});
    assert_int_equal(unsetenv("PINCH_SOLVER"), 0);
    settings = json_object_get(r.stats, "settings");
    assert_string_equal(json_string_value(json_object_get(settings, "solver")), "nsnmgk");
    assert_string_equal(json_string_value(json_object_get(settings, "only")), "material");
    exec_run_free(&r);
    free(file);
    program_remove_folder(folder);
}

/* A relative name is the caller's, wherever the program goes; a link stays one, and an older file is replaced. */
static void the_file_is_where_it_was_asked_for(void **state)
{
    (void)state;
    char *folder = program_make_folder(), link[1024], script[2048];
    char *file = program_write_file(folder, "real.json", "old");
    snprintf(link, sizeof link, "%s/link.json", folder);
    assert_int_equal(symlink("real.json", link), 0);
    snprintf(script, sizeof script, "cd / && exec %s --steps 5", exec_program("stack"));
    char executable[] = PINCH_EXECUTABLE;
    program_result r =
        program_run(folder, (char *[]){executable, "exec", "--stats", "link.json", "/bin/sh", "-c", script, NULL});
    assert_int_equal(r.status, 0);
    json_t *stats = json_load_file(file, 0, NULL);
    assert_non_null(stats);
    assert_int_equal(exec_number(stats, "steps"), 5);
    struct stat status;
    assert_int_equal(lstat(link, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    json_decref(stats);
    program_free(&r);
    free(file);
    program_remove_folder(folder);
}

static void on_standard_error_once(void **state)
{
    (void)state;
    program_result r = EXEC("--stats", "-", "--", exec_program("stack"), "--steps", "8");
    assert_int_equal(r.status, 0);
    assert_int_equal(lines(r.out), 1);
    json_t *stats = json_loads(r.err, 0, NULL); /* nothing else is there */
    assert_non_null(stats);
    assert_int_equal(exec_number(stats, "steps"), 8);
    json_decref(stats);
    program_free(&r);
}

static void who_steps_nothing_is_told(void **state)
{
    (void)state;
    exec_run r = exec_program_run((char *[]){NULL}, (char *[]){yes, NULL});
    assert_int_equal(r.result.status, 0);
    assert_int_equal(exec_number(r.stats, "steps"), 0);
    assert_non_null(strstr(r.result.err, "no ODE world was stepped"));
    assert_int_equal(lines(r.result.err), 1);
    exec_run_free(&r);
    /* without --stats nobody asked */
    program_result quiet = EXEC(yes);
    assert_string_equal(quiet.err, "");
    program_free(&quiet);
}

/* The shell steps nothing, its child does: one file, the child's, and no remark. */
static void children_count(void **state)
{
    (void)state;
    char script[2048];
    snprintf(script, sizeof script, "%s --steps 6; %s; exit 5", exec_program("stack"), yes);
    exec_run r = exec_program_run((char *[]){NULL}, (char *[]){"/bin/sh", "-c", script, NULL});
    assert_int_equal(r.result.status, 5);
    assert_int_equal(exec_number(r.stats, "steps"), 6);
    assert_string_equal(r.result.err, "");
    exec_run_free(&r);
}

static long forked_steps(char *child, char *after)
{
    exec_run r =
        exec_program_run((char *[]){NULL}, (char *[]){exec_program("forks"), "--child", child, "--after", after, NULL});
    assert_int_equal(r.result.status, 0);
    long steps = (long)exec_number(r.stats, "steps");
    assert_int_equal(exec_number(r.stats, "worlds"), 1);
    exec_run_free(&r);
    return steps;
}

/* A forked child reports its own steps, if it does any; the parent, which ends later, has the last word. */
static void forks_count(void **state)
{
    (void)state;
    assert_int_equal(forked_steps("0", "0"), 20);
    assert_int_equal(forked_steps("0", "7"), 27);
    assert_int_equal(forked_steps("9", "7"), 27);
}

static void programs_that_die(void **state)
{
    (void)state;
    exec_run r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("crash"), NULL});
    assert_int_equal(r.result.status, 128 + SIGKILL);
    assert_int_equal(exec_number(r.stats, "steps"), 50);
    exec_run_free(&r);
    /* nobody sees SIGKILL: the file is from the last second, or from the first step */
    r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("crash"), "--inside", "1", NULL});
    assert_int_equal(r.result.status, 128 + SIGKILL);
    assert_in_range((int)exec_number(r.stats, "steps"), 1, 50);
    exec_run_free(&r);
    static const int signals[] = {SIGTERM, SIGINT};
    for (int i = 0; i < 4; i++) { /* i >= 2: the program has a handler of its own */
        char number[16];
        snprintf(number, sizeof number, "%d", signals[i % 2]);
        char *words[] = {exec_program("crash"), "--inside",        "1", "--signal", number,
                         "--handler",           i < 2 ? "0" : "1", NULL};
        r = exec_program_run((char *[]){NULL}, words);
        assert_int_equal(r.result.status, i < 2 ? 128 + signals[i] : 7);
        assert_int_equal(exec_number(r.stats, "steps"), 50);
        exec_run_free(&r);
    }
}

/* ODE comes with a module of local scope, or its functions are looked up behind everybody's back. */
static void ode_that_is_opened(void **state)
{
    (void)state;
    exec_run r =
        exec_program_run((char *[]){NULL}, (char *[]){exec_program("loader"), exec_program("module.so"), NULL});
    assert_int_equal(r.result.status, 0);
    assert_int_equal(exec_number(r.stats, "steps"), 40);
    assert_true(exec_number(r.stats, "contacts_offered") > 30);
    exec_run_free(&r);

    r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("lookup"), NULL});
    assert_int_equal(r.result.status, 0);
    assert_int_equal(exec_number(r.stats, "steps"), 0);
    assert_non_null(strstr(r.result.err, "no ODE world was stepped"));
    exec_run_free(&r);
}

/* An ODE that Pinch cannot serve gets every call as it was, and no other ODE comes into the process. */
static void another_ode_is_left_alone(void **state)
{
    (void)state;
    exec_run r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("carrier"), NULL});
    assert_int_equal(r.result.status, 0);
    assert_int_equal(exec_number(r.stats, "steps"), 0);
    assert_non_null(strstr(r.result.err, "not in double precision"));
    exec_run_free(&r);
    program_result none = EXEC("/bin/sh", "-c", "grep libode /proc/$$/maps");
    assert_string_equal(none.out, "");
    program_free(&none);
}

static void help_says_what_is_out_of_reach(void **state)
{
    (void)state;
    program_result r = EXEC("--help");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "libode.a"));
    assert_non_null(strstr(r.out, "--kt-ratio"));
    program_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(statuses_pass_through),
        cmocka_unit_test(programs_that_cannot_be_run),
        cmocka_unit_test(wrong_options),
        cmocka_unit_test(wrong_configurations),
        cmocka_unit_test(help_names_the_solvers),
        cmocka_unit_test(nsngrk_solves_joints_alone),
        cmocka_unit_test(settings_arrive),
        cmocka_unit_test(the_file_is_where_it_was_asked_for),
        cmocka_unit_test(on_standard_error_once),
        cmocka_unit_test(who_steps_nothing_is_told),
        cmocka_unit_test(children_count),
        cmocka_unit_test(forks_count),
        cmocka_unit_test(programs_that_die),
        cmocka_unit_test(ode_that_is_opened),
        cmocka_unit_test(another_ode_is_left_alone),
        cmocka_unit_test(help_says_what_is_out_of_reach),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
