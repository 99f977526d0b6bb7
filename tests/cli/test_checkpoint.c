/*
 * A run that goes on from a checkpoint ends in the same document as one that was never interrupted: after any number of
 * kills at any moment. Checkpoints of other runs and damaged ones are refused.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/draw.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Drops what a clock has measured, and the memory that the process happened to hold. */
static void drop_costs(json_t *value)
{
    const char *key;
    json_t *member;
    void *next;
    size_t i;
    json_array_foreach(value, i, member) drop_costs(member);
    json_object_foreach_safe(value, next, key, member)
    {
        size_t length = strlen(key);
        bool cost = (length > 3 && strcmp(key + length - 3, "_us") == 0) || strcmp(key, "memory") == 0;
        if (cost)
            json_object_del(value, key);
        else
            drop_costs(member);
    }
}

/* Returns the document of a run without costs, which the caller frees. */
static char *text_of(program_result r, int status)
{
    if (r.status != status) fail_msg("exit status %d: %s", r.status, r.err);
    json_t *document = cli_document(&r);
    program_free(&r);
    drop_costs(document);
    char *text = json_dumps(document, JSON_SORT_KEYS | JSON_REAL_PRECISION(17));
    json_decref(document);
    return text;
}

static char *whole_run(const char *scene)
{
    return text_of(PINCH(NULL, "run", scene, "--json"), 0);
}

static void test_all_scenes_resume(void **state)
{
    (void)state;
    const char *const *scenes = shipped_scenes();
    for (int i = 0; scenes[i]; i++) {
        if (i % 3 && !draw_full()) continue;
        char *folder = program_make_folder();
        char *whole = whole_run(scenes[i]);
        char *saved =
            text_of(PINCH(folder, "run", scenes[i], "--json", "--checkpoint", "run.state", "--every", "170"), 0);
        assert_string_equal(saved, whole);
        assert_int_equal(program_count_entries(folder), 1);
        char *resumed = text_of(PINCH(folder, "run", scenes[i], "--json", "--resume", "run.state"), 0);
        if (strcmp(resumed, whole) != 0) fail_msg("%s: another end", scenes[i]);
        free(resumed);
        free(saved);
        free(whole);
        program_remove_folder(folder);
    }
}

/* ---- kills ---- */

/* Starts a run that goes on from its checkpoint, if there is one, and kills it after so many seconds. Returns true
 * where it has ended by itself before that. */
static bool run_and_kill(const char *folder, const char *scene, double seconds)
{
    char path[512], checkpoint[] = "run.state";
    snprintf(path, sizeof path, "%s/%s", folder, checkpoint);
    bool resumes = access(path, F_OK) == 0;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (chdir(folder) != 0) _exit(126);
        execl(PINCH_EXECUTABLE, "pinch", "run", scene, "--quiet", "--checkpoint", checkpoint, "--every", "20",
              resumes ? "--resume" : (char *)NULL, checkpoint, (char *)NULL);
        _exit(127);
    }
    struct timespec wait = {0, (long)(1e9 * seconds)};
    nanosleep(&wait, NULL);
    kill(child, SIGKILL);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    return WIFEXITED(status);
}

static void test_kills(void **state)
{
    (void)state;
    static const char *const names[] = {SCENE("example-3.json"), SCENE("lift.json"), SCENE("roll.json")};
    pinch_random random;
    pinch_random_seed(&random, 11);
    int kills = 0, wanted = draw_full() ? 200 : 15;
    for (int i = 0; kills < wanted; i++) {
        const char *scene = names[i % 3];
        char *folder = program_make_folder();
        char *whole = whole_run(scene);
        for (int k = 0; k < 8 && !run_and_kill(folder, scene, draw_uniform(&random, 0.004, 0.05)); k++) kills++;
        struct stat file;
        char path[512];
        snprintf(path, sizeof path, "%s/run.state", folder);
        if (stat(path, &file) == 0) {
            char *resumed = text_of(PINCH(folder, "run", scene, "--json", "--resume", "run.state"), 0);
            if (strcmp(resumed, whole) != 0) fail_msg("%s: another end after %d kills", scene, kills);
            free(resumed);
        }
        free(whole);
        program_remove_folder(folder);
        if (i > 20 * wanted) fail_msg("only %d of the runs lived long enough to be killed", kills);
    }
}

/* An interrupt is no kill: the state at that moment is kept. */
/* The run is still going on when it is interrupted. */
#define DURATION "60"

static void test_interrupt_keeps_the_state(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    char *whole = text_of(PINCH(NULL, "run", SCENE("egg.json"), "--json", "--duration", DURATION), 0);
    program_result r =
        program_run(folder, (char *const[]){(char[]){"/bin/sh"}, (char[]){"-c"},
                                            (char[]){PINCH_EXECUTABLE " run " SCENE(
                                                "egg.json") " --duration " DURATION " --quiet --checkpoint run.state "
                                                            "--every 100000000 & sleep 0.15; kill -INT $!; wait $!"},
                                            NULL});
    assert_true(r.status == 128 + SIGINT || r.status == 0);
    if (r.status != 0) {
        char *resumed = text_of(
            PINCH(folder, "run", SCENE("egg.json"), "--json", "--duration", DURATION, "--resume", "run.state"), 0);
        assert_string_equal(resumed, whole);
        free(resumed);
    }
    program_free(&r);
    free(whole);
    program_remove_folder(folder);
}

/* ---- what is refused ---- */

static char *read_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    char *bytes = malloc(1 << 20);
    assert_true(file && bytes);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

static void write_bytes(const char *path, const char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_true(fwrite(bytes, 1, size, file) == size);
    assert_int_equal(fclose(file), 0);
}

static void test_damaged_files(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    pinch_random random;
    size_t size;
    pinch_random_seed(&random, 3);
    program_result r = PINCH(folder, "run", SCENE("egg.json"), "--quiet", "--duration", "0.1", "--checkpoint",
                             "run.state", "--every", "40");
    assert_int_equal(r.status, 0);
    program_free(&r);
    snprintf(path, sizeof path, "%s/run.state", folder);
    char *bytes = read_bytes(path, &size);
    for (int i = 0; i < (draw_full() ? 2000 : 60); i++) {
        size_t at = pinch_random_next(&random) % size;
        char bit = (char)(1 << draw_index(&random, 8));
        bytes[at] ^= bit;
        write_bytes(path, bytes, i % 4 ? size : at);
        bytes[at] ^= bit;
        cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--duration", "0.1", "--resume", "run.state"), 2,
                    "run.state: expected a whole checkpoint");
    }
    write_bytes(path, bytes, size);
    r = PINCH(folder, "run", SCENE("egg.json"), "--quiet", "--duration", "0.1", "--resume", "run.state");
    assert_int_equal(r.status, 0);
    program_free(&r);
    free(bytes);
    program_remove_folder(folder);
}

/* The files that a scene names belong to it: with another hand, it is another run. */
static void test_other_files(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *hand = program_read_file(PINCH_SOURCE_DIR "/assets/hands/three-finger.urdf");
    char *scene = program_read_file(SCENE("hands/three-finger-lift.json"));
    char *file = strstr(scene, "../../hands/three-finger.urdf");
    assert_non_null(file);
    memmove(file, file + strlen("../../hands/"), strlen(file + strlen("../../hands/")) + 1);
    free(program_write_file(folder, "lift.json", scene));
    free(program_write_file(folder, "three-finger.urdf", hand));
    program_result r = PINCH(folder, "run", "lift.json", "--quiet", "--duration", "0.2", "--checkpoint", "run.state",
                             "--every", "100");
    assert_int_equal(r.status, 0);
    program_free(&r);
    r = PINCH(folder, "run", "lift.json", "--quiet", "--duration", "0.2", "--resume", "run.state");
    assert_int_equal(r.status, 0);
    program_free(&r);
    char *damping = strstr(hand, "damping=\"");
    assert_non_null(damping);
    damping[strlen("damping=\"")] ^= 1; /* a digit, and another one */
    free(program_write_file(folder, "three-finger.urdf", hand));
    cli_refused(PINCH(folder, "run", "lift.json", "--quiet", "--duration", "0.2", "--resume", "run.state"), 2,
                "the files of its hands and meshes");
    free(hand);
    free(scene);
    program_remove_folder(folder);
}

static void test_other_runs(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    program_result r =
        PINCH(folder, "run", SCENE("egg.json"), "--quiet", "--checkpoint", "run.state", "--every", "100");
    assert_int_equal(r.status, 0);
    program_free(&r);
    cli_refused(PINCH(folder, "run", SCENE("mug.json"), "--json", "--resume", "run.state"), 2, "of another scene");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--duration", "9", "--resume", "run.state"), 2,
                "--duration must be the same");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--step", "5e-4", "--resume", "run.state"), 2,
                "of another scene, or of a run with other options");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--tolerance", "1e-9", "--resume", "run.state"), 2,
                "of another scene, or of a run with other options");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--resume", "none.state"), 2, "none.state");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--resume", "."), 2, "expected a checkpoint");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--resume", "/dev/zero"), 2, "expected a checkpoint");
    snprintf(path, sizeof path, "%s/pipe", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--resume", "pipe"), 2, "expected a checkpoint");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--every", "5"), 2, "--every: expected --checkpoint");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--json", "--checkpoint", "a", "--contact-solver", "quickstep"),
                2, "--checkpoint: expected Pinch as contact solver");
    program_remove_folder(folder);
}

/* A place that cannot be written ends the run at once; on a full disk the last checkpoint stays. */
static void test_no_room(void **state)
{
    (void)state;
    cli_refused(PINCH(NULL, "run", SCENE("egg.json"), "--json", "--checkpoint", "/none/run.state", "--every", "5"), 3,
                "/none/run.state: cannot be written");
    /* also where the run ends before its first checkpoint */
    cli_refused(
        PINCH(NULL, "run", SCENE("egg.json"), "--json", "--checkpoint", "/none/run.state", "--duration", "0.01"), 3,
        "/none/run.state: cannot be written");
    cli_refused(PINCH(NULL, "run", SCENE("egg.json"), "--json", "--checkpoint", "/dev/full", "--every", "5"), 3,
                "/dev/full: cannot be written");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_scenes_resume),
        cmocka_unit_test(test_kills),
        cmocka_unit_test(test_interrupt_keeps_the_state),
        cmocka_unit_test(test_damaged_files),
        cmocka_unit_test(test_other_runs),
        cmocka_unit_test(test_other_files),
        cmocka_unit_test(test_no_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
