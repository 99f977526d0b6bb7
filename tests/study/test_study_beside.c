/* Studies run by two solvers, with hands, on ranks that die: what the results say of them. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "study/beside.h"
#include "study/trial.h"
#include "support/command.h"
#include "support/sanitized.h"
#include "support/schema.h"

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static char *folder;

/* Two fingers on a cube of 0.5 kg; `drive` is added to both. */
#define FINGER(name, x, n, drive)                                                                                      \
    "{\"name\": \"" name "\", \"point\": [" x ", 0, 0], \"normal\": [" n ", 0, 0], \"model\": \"soft\", "              \
    "\"stiffness\": {\"normal\": 20000, \"torsional\": 1}, \"damping\": {\"normal\": 20, \"tangential\": 13}, "        \
    "\"friction\": 0.6, \"torsional_friction\": 0.002, " drive "}"
#define CUBE                                                                                                           \
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, "         \
    "\"mass\": 0.5}, "

static const char cube_text[] = CUBE "\"fingers\": [" FINGER("left", "-0.05", "1", "\"closing\": 0.0005") ", " FINGER(
    "right", "0.05", "-1", "\"closing\": 0.0005") "], \"simulation\": {\"duration\": 0.1}}";

static char *file(const char *name)
{
    static char path[4][4096];
    static int next;
    char *p = path[next++ % 4];
    snprintf(p, sizeof path[0], "%s/%s", folder, name);
    return p;
}

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    free(program_write_file(folder, "cube.json", cube_text));
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    program_remove_folder(folder);
    return 0;
}

static void expect(program_result r, int status)
{
    if (r.status != status) fail_msg("exit %d: %s%s", r.status, r.out, r.err);
    program_free(&r);
}

static bool add_row(void *context, const json_t *names, json_t *row)
{
    (void)names;
    return json_array_append(context, row) == 0;
}

/* The rows of a query, as a text that the caller frees. */
static char *rows(const char *name, const char *query)
{
    results_error error;
    results *r = results_read(file(name), &error);
    if (!r) fail_msg("%s", error.text);
    json_t *list = json_array();
    if (!results_query(r, query, add_row, list, &error)) fail_msg("%s", error.text);
    results_close(r, &error);
    char *text = json_dumps(list, JSON_COMPACT);
    json_decref(list);
    return text;
}

static const char every_trial[] = "SELECT \"index\", inputs, status, success, exit, hash, recorded FROM trials";

static void expect_same(const char *one, const char *other)
{
    char *a = rows(one, every_trial), *b = rows(other, every_trial);
    assert_string_equal(a, b);
    free(a);
    free(b);
}

/* ---- Two solvers. ---- */

/* Friction near the least that holds the cube, 4.905 N / 20 N, and a displacement that counts which is less than what
 * the fingertips give, 0.18 mm: quickstep, which knows no such springs, differs. */
static const char beside_text[] =
    "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"samples\": 6, \"seed\": 2}, "
    "\"vary\": [{\"path\": \"/fingers/*/friction\", \"uniform\": [0.2, 1], \"common\": true}], "
    "\"success\": {\"displacement\": 0.0001}}";

/* quickstep shuffles its rows by a random number that a process goes on drawing; a trial does not depend on it. */
static void quickstep_trials_depend_on_nothing_else(void **state)
{
    (void)state;
    free(program_write_file(folder, "beside.json", beside_text));
    expect(PINCH(folder, "study", "beside.json", "--out", "q1.sqlite", "--contact-solver", "quickstep", "--jobs", "1",
                 "--quiet"),
           0);
    expect(PINCH(folder, "study", "beside.json", "--out", "q3.sqlite", "--contact-solver", "quickstep", "--jobs", "3",
                 "--quiet"),
           0);
    expect_same("q1.sqlite", "q3.sqlite");
}

static void verdicts_that_differ_are_refined(void **state)
{
    (void)state;
    expect(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--quiet"), 0);
    program_result r = PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--beside", "q1.sqlite",
                             "--refine", "2", "--json", "--quiet");
    assert_int_equal(r.status, 0);
    json_t *document = cli_document(&r);
    program_free(&r);
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-study-result-1.json", 0, NULL);
    assert_int_equal(schema_faults(schema, document), 0);
    json_decref(schema);
    char *differing = rows("p.sqlite", "SELECT \"index\", success FROM trials WHERE success");
    assert_string_equal(differing, "[]"); /* every fingertip gives more than the limit */
    free(differing);
    long beside = (long)json_integer_value(cli_at(document, "beside.trials.only_beside"));
    assert_in_range(beside, 1, 6);
    assert_int_equal(json_integer_value(cli_at(document, "beside.trials.compared")), 6);
    assert_int_equal(json_array_size(cli_at(document, "beside.differing")), beside);
    const json_t *refined = cli_at(document, "beside.refined");
    assert_int_equal(json_array_size(refined), beside < 2 ? beside : 2);
    for (size_t i = 0; i < json_array_size(refined); i++) {
        const json_t *of = json_array_get(refined, i), *here = json_object_get(of, "here");
        assert_int_equal(json_array_size(here), 1 + BESIDE_STAYS);
        assert_true(json_is_false(json_object_get(json_array_get(here, 0), "success")));
        assert_true(json_is_true(json_object_get(json_array_get(json_object_get(of, "beside"), 0), "success")));
        assert_string_equal(json_string_value(json_object_get(of, "right")), "each of its own law");
    }
    json_decref(document);
    /* what is there is not run again, and the first verdict is the trial's */
    char *again = rows("p.sqlite", "SELECT count(*) FROM refinements r JOIN trials t ON t.\"index\" = r.trial WHERE "
                                   "halvings = 0 AND contact_solver = 'pinch' AND r.hash <> t.hash");
    assert_string_equal(again, "[[0]]");
    free(again);
    char *before = rows("p.sqlite", "SELECT * FROM refinements");
    expect(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--beside", "q1.sqlite", "--refine",
                 "2", "--quiet"),
           0);
    again = rows("p.sqlite", "SELECT * FROM refinements");
    assert_string_equal(again, before);
    free(before);
    free(again);
}

static void results_of_another_study_are_refused(void **state)
{
    (void)state;
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--refine", "2"), 2, "--beside");
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--beside", "none.sqlite"), 2,
                "none.sqlite: cannot be read");
    free(program_write_file(folder, "other.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", "
                            "\"trials\": {\"samples\": 1}}"));
    expect(PINCH(folder, "study", "other.json", "--out", "other.sqlite", "--quiet"), 0);
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--beside", "other.sqlite"), 2,
                "same study");
    /* nothing is begun for them, and results are not beside themselves */
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "new.sqlite", "--beside", "none.sqlite"), 2,
                "none.sqlite: cannot be read");
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "new.sqlite", "--beside", "other.sqlite"), 2,
                "same study");
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "new.sqlite", "--beside", "new.sqlite"), 2,
                "new.sqlite: cannot be read");
    cli_refused(PINCH(folder, "study", "beside.json", "--out", "p.sqlite", "--resume", "--beside", "p.sqlite"), 2,
                "p.sqlite is the file that is read");
    char path[4096];
    snprintf(path, sizeof path, "%s/new.sqlite", folder);
    assert_int_not_equal(access(path, F_OK), 0);
}

/* ---- Files that the scene refers to. ---- */

#define SLAB(x)                                                                                                        \
    "o slab\nv -" x " -.05 -.05\nv " x " -.05 -.05\nv " x " .05 -.05\nv -" x " .05 -.05\nv -" x " -.05 .05\nv " x      \
    " -.05 .05\nv " x " .05 .05\nv -" x " .05 .05\nf 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 "       \
    "7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n"

/* A mesh in the scene, and one that a value brings in. */
static void a_changed_mesh_is_noticed(void **state)
{
    (void)state;
    static const char study_text[] =
        "{\"format\": \"pinch-study/1\", \"scene\": \"mesh.json\", \"trials\": {\"samples\": 3}, \"vary\": [{\"path\": "
        "\"/object/shape\", \"values\": [{\"type\": \"mesh\", \"file\": \"a.obj\"}, {\"type\": \"mesh\", \"file\": "
        "\"b.obj\"}]}]}";
    char *scene_text = strdup(cube_text), mesh[sizeof cube_text + 64];
    char *shape = strstr(scene_text, "{\"type\": \"box\""), *after = strchr(shape, '}') + 1;
    snprintf(mesh, sizeof mesh, "%.*s{\"type\": \"mesh\", \"file\": \"a.obj\"}%s", (int)(shape - scene_text),
             scene_text, after);
    free(scene_text);
    free(program_write_file(folder, "mesh.json", mesh));
    free(program_write_file(folder, "a.obj", SLAB(".05")));
    free(program_write_file(folder, "b.obj", SLAB(".05") "# b\n"));
    free(program_write_file(folder, "meshes.json", study_text));
    expect(PINCH(folder, "study", "meshes.json", "--out", "m.sqlite", "--limit", "1", "--quiet"), 0);
    expect(PINCH(folder, "study", "meshes.json", "--out", "m.sqlite", "--limit", "1", "--resume", "--quiet"), 0);
    free(program_write_file(folder, "b.obj", SLAB(".05") "# c\n"));
    cli_refused(PINCH(folder, "study", "meshes.json", "--out", "m.sqlite", "--resume"), 2, "meshes");
    free(program_write_file(folder, "b.obj", SLAB(".05") "# b\n"));
    free(program_write_file(folder, "a.obj", SLAB(".05") "\n"));
    cli_refused(PINCH(folder, "study", "meshes.json", "--out", "m.sqlite", "--resume"), 2, "meshes");
    free(program_write_file(folder, "a.obj", SLAB(".05")));
    expect(PINCH(folder, "study", "meshes.json", "--out", "m.sqlite", "--resume", "--quiet"), 0);
    /* a hand */
    free(program_write_file(folder, "hand.urdf",
                            "<robot name=\"h\"><link name=\"l\"><collision><geometry><box "
                            "size=\"1 1 1\"/></geometry></collision></link></robot>"));
    snprintf(mesh, sizeof mesh, "%s",
             "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.02}, "
             "\"mass\": 0.1, \"position\": [0, 0, 0.52]}, \"hand\": {\"file\": \"hand.urdf\"}, \"simulation\": "
             "{\"duration\": 0.01}}");
    free(program_write_file(folder, "hand.json", mesh));
    free(program_write_file(folder, "hands.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"hand.json\", "
                            "\"trials\": {\"samples\": 2}}"));
    expect(PINCH(folder, "study", "hands.json", "--out", "h.sqlite", "--limit", "1", "--quiet"), 0);
    free(program_write_file(folder, "hand.urdf",
                            "<robot name=\"h\"><link name=\"l\"><collision><geometry><box "
                            "size=\"1 2 1\"/></geometry></collision></link></robot>"));
    cli_refused(PINCH(folder, "study", "hands.json", "--out", "h.sqlite", "--resume"), 2, "hands");
}

/* ---- What a protocol begins with. ---- */

/* Fingers on paths, which close by as much as the others' `closing`. */
#define PATH(sign)                                                                                                     \
    "\"drive\": {\"type\": \"path\", \"points\": [{\"time\": 0}, {\"time\": 0.3, \"translation\": [" sign              \
    "0.0005, 0, 0]}]}"

static const char slow[] =
    "], \"schedule\": [{\"time\": 0.3, \"gravity\": [0, 0, 0]}, {\"time\": 0.5, \"gravity\": [0, "
    "0, -9.81]}], \"simulation\": {\"duration\": 0.7}}";

static double recorded(const char *text, const char *scene_text, const char *key)
{
    scene_error error;
    study *s;
    free(program_write_file(folder, "base.json", scene_text));
    free(program_write_file(folder, "s.json", text));
    if (study_load(file("s.json"), &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    json_t *trial = trial_run(s, 0), *value = json_object_get(json_object_get(trial, "recorded"), key);
    double number = json_is_number(value) ? json_number_value(value) : NAN;
    if (strcmp(key, "success") == 0) number = json_is_true(json_object_get(trial, key));
    json_decref(trial);
    study_free(s);
    return number;
}

/* The contacts of a run are a grasp whose quality is that of the scene with closings; a fingertip's sphere touches the
 * cube at the scene's point. */
static void contacts_of_a_run_have_the_quality_of_the_grasp(void **state)
{
    (void)state;
    static const char study_text[] =
        "{\"format\": \"pinch-study/1\", \"scene\": \"base.json\", \"trials\": {\"samples\": 1}, \"record\": "
        "[\"grasp.epsilon\", \"grasp.volume\", \"grasp.smallest_friction\", \"grasp.largest_load_factor\"]}";
    static const char *const keys[] = {"grasp.epsilon", "grasp.volume", "grasp.smallest_friction",
                                       "grasp.largest_load_factor"};
    char closed[4096], moved[4096];
    snprintf(closed, sizeof closed, "%s%s, %s%s", CUBE "\"fingers\": [",
             FINGER("left", "-0.05", "1", "\"closing\": 0.0005, \"ramp\": 0.3"),
             FINGER("right", "0.05", "-1", "\"closing\": 0.0005, \"ramp\": 0.3"), slow);
    snprintf(moved, sizeof moved, "%s%s, %s%s", CUBE "\"fingers\": [", FINGER("left", "-0.05", "1", PATH("")),
             FINGER("right", "0.05", "-1", PATH("-")), slow);
    for (int k = 0; k < 4; k++) {
        double by_scene = recorded(study_text, closed, keys[k]), by_run = recorded(study_text, moved, keys[k]);
        /* the object has sagged by 0.18 mm of its 87 mm radius */
        assert_true(by_scene > 0.0);
        assert_close(by_run, by_scene, 0.01 * by_scene);
    }
}

/* Both fingers leave the cube, which a force pushes along, and close on it again: it has been dropped, and lies in the
 * hand when the protocol begins. */
static void what_lies_in_the_hand_at_the_start_was_not_dropped(void **state)
{
    (void)state;
#define AWAY(out, in)                                                                                                  \
    "\"drive\": {\"type\": \"path\", \"points\": [{\"time\": 0}, {\"time\": 0.05, \"translation\": [" out              \
    "0.01, 0, 0]}, {\"time\": 0.25, \"translation\": [" out "0.01, 0, 0]}, {\"time\": 0.35, \"translation\": [" in     \
    "0.0005, 0, 0]}]}"
    char text[4096];
    snprintf(text, sizeof text, "%s%s, %s%s", CUBE "\"fingers\": [", FINGER("left", "-0.05", "1", AWAY("-", "")),
             FINGER("right", "0.05", "-1", AWAY("", "-")),
             "], \"gravity\": [0, 0, 0], \"schedule\": [{\"time\": 0, \"force\": [0, 0, 0.2]}], \"simulation\": "
             "{\"duration\": 0.8}}");
    double plain = recorded("{\"format\": \"pinch-study/1\", \"scene\": \"base.json\", \"trials\": {\"samples\": 1}}",
                            text, "success");
    double lifted = recorded("{\"format\": \"pinch-study/1\", \"scene\": \"base.json\", \"trials\": {\"samples\": 1}, "
                             "\"protocol\": {\"name\": \"lift\", \"distance\": 0.01, \"hold\": 0.1}, \"success\": "
                             "{\"displacement\": 0.001}}",
                             text, "success");
    assert_true(plain == 0.0);
    assert_true(lifted == 1.0);
}

/* ---- A rank that dies. ---- */

static bool has_mpirun(void)
{
    char module[4096];
    snprintf(module, sizeof module, "%s", PINCH_EXECUTABLE);
    strcpy(strrchr(module, '/'), "/libpinch_mpi.so");
    return access(module, R_OK) == 0 && system("command -v mpirun >/dev/null 2>&1") == 0;
}

static bool has_in(const char *path, const char *wanted)
{
    char text[65536];
    FILE *stream = fopen(path, "rb");
    size_t length = stream ? fread(text, 1, sizeof text - 1, stream) : 0;
    if (stream) fclose(stream);
    text[length] = '\0';
    for (char *at = text; at < text + length; at += strlen(at) + 1)
        if (strcmp(at, wanted) == 0) return true;
    return false;
}

/* The process that is this rank of a study with these results; 0 where there is none. */
static pid_t find_rank(const char *out, int rank)
{
    char wanted[64], path[300];
    pid_t found = 0;
    DIR *all = opendir("/proc");
    assert_non_null(all);
    snprintf(wanted, sizeof wanted, "OMPI_COMM_WORLD_RANK=%d", rank);
    for (struct dirent *e; !found && (e = readdir(all));) {
        snprintf(path, sizeof path, "/proc/%.200s/cmdline", e->d_name);
        if (atoi(e->d_name) <= 0 || !has_in(path, out)) continue;
        snprintf(path, sizeof path, "/proc/%.200s/environ", e->d_name);
        if (has_in(path, wanted)) found = (pid_t)atoi(e->d_name);
    }
    closedir(all);
    return found;
}

static void nap(double seconds)
{
    struct timespec span = {0, (long)(1e9 * seconds)};
    nanosleep(&span, NULL);
}

static long trials_in(const char *name)
{
    results_error error;
    results_counts n = {.done = 0};
    results *r = access(file(name), R_OK) == 0 ? results_read(file(name), &error) : NULL;
    if (r && !results_count(r, &n, &error)) n.done = 0;
    results_close(r, &error);
    return n.done;
}

/* Ends rank `rank` of three once some trials are there. The job ends with what is done kept, and is completed with
 * another number of processes. */
static void kill_rank(int rank, const char *reference)
{
    char out[64], script[8192];
    snprintf(out, sizeof out, "rank%d.sqlite", rank);
    snprintf(script, sizeof script,
             "exec mpirun --allow-run-as-root --oversubscribe -n 3 %s study long.json --out %s --quiet </dev/null "
             ">/dev/null 2>&1",
             PINCH_EXECUTABLE, out);
    pid_t job = fork();
    if (job == 0) {
        if (chdir(folder) != 0) _exit(9);
        execl("/bin/sh", "sh", "-c", script, (char *)NULL);
        _exit(9);
    }
    int ended = 0;
    while (trials_in(out) < 3 && waitpid(job, &ended, WNOHANG) == 0) nap(0.02);
    pid_t process = find_rank(out, rank);
    assert_true(process > 0);
    assert_int_equal(kill(process, SIGKILL), 0);
    assert_int_equal(waitpid(job, &ended, 0), job);
    assert_false(WIFEXITED(ended) && WEXITSTATUS(ended) == 0);
    assert_in_range(trials_in(out), 3, 79);
    expect(PINCH(folder, "study", "long.json", "--out", out, "--resume", "--quiet"), 0);
    expect_same(out, reference);
}

static void a_rank_that_is_killed_loses_nothing(void **state)
{
    (void)state;
    if (SANITIZED || !has_mpirun()) {
        print_message("sanitized, built without MPI, or mpirun is not there\n");
        skip();
    }
    free(program_write_file(folder, "long.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"samples\": 80}, "
                            "\"vary\": [{\"path\": \"/object/mass\", \"uniform\": [0.3, 2]}], \"protocol\": {\"name\": "
                            "\"shake\", \"time\": 0.25}}"));
    expect(PINCH(folder, "study", "long.json", "--out", "long.sqlite", "--jobs", "2", "--quiet"), 0);
    kill_rank(2, "long.sqlite");
    kill_rank(0, "long.sqlite");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quickstep_trials_depend_on_nothing_else),
        cmocka_unit_test(verdicts_that_differ_are_refined),
        cmocka_unit_test(results_of_another_study_are_refused),
        cmocka_unit_test(a_changed_mesh_is_noticed),
        cmocka_unit_test(contacts_of_a_run_have_the_quality_of_the_grasp),
        cmocka_unit_test(what_lies_in_the_hand_at_the_start_was_not_dropped),
        cmocka_unit_test(a_rank_that_is_killed_loses_nothing),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, make_folder, remove_folder);
    dCloseODE();
    return failed;
}
