/*
 * Every shipped scene and every hand's is saved at each 100th step. From there the run goes on to the same bits in the
 * same world, in one that has done something else, in a fresh one and in another process: what is compared is all of
 * the next checkpoint, 100 steps later. A quick run takes one checkpoint of every scene. Files as
 * arguments are the scenes.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/program.h"
#include "support/started_run.h"

#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { BETWEEN = 100, ELSEWHERE = 37, QUICK = 200 };

typedef struct checkpoint {
    unsigned char *bytes;
    size_t size;
} checkpoint;

static char *self;          /* this program's file */
static char *const *chosen; /* the scenes that it was given, NULL behind them */

static scene *load(const char *path)
{
    scene *s;
    scene_error error;
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    return s;
}

static started_run start(const scene *of)
{
    started_run r = run_start(of);
    assert_non_null(r.s);
    return r;
}

static checkpoint save(started_run *r)
{
    checkpoint c;
    assert_true(simulation_checkpoint(r->s, &c.bytes, &c.size));
    return c;
}

static void advance(started_run *r, long steps)
{
    for (long i = 0; i < steps; i++) assert_int_equal(simulation_step(r->s), WORLD_OK);
}

/* Does the run end at `wanted`, `steps` after it has taken `from`? */
static bool comes_to(started_run *r, const checkpoint *from, long steps, const checkpoint *wanted)
{
    assert_int_equal(simulation_resume(r->s, from->bytes, from->size), CHECKPOINT_FINE);
    advance(r, steps);
    checkpoint end = save(r);
    bool same = end.size == wanted->size && memcmp(end.bytes, wanted->bytes, end.size) == 0;
    free(end.bytes);
    return same;
}

static void write_checkpoint(const char *path, const checkpoint *c)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(c->bytes, 1, c->size, file), c->size);
    assert_int_equal(fclose(file), 0);
}

static checkpoint read_checkpoint(const char *path)
{
    checkpoint c = {NULL, 0};
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    c.size = (size_t)ftell(file);
    rewind(file);
    c.bytes = malloc(c.size + 1);
    assert_non_null(c.bytes);
    assert_int_equal(fread(c.bytes, 1, c.size, file), c.size);
    fclose(file);
    return c;
}

/* The other process is this program once more, with the scene, two files and the steps as arguments. */
static bool another_process_comes_to(const char *path, const char *folder, const checkpoint *from, long steps,
                                     const checkpoint *wanted)
{
    char files[2][512], number[32], again[] = "--again";
    snprintf(files[0], sizeof files[0], "%s/from", folder);
    snprintf(files[1], sizeof files[1], "%s/wanted", folder);
    snprintf(number, sizeof number, "%ld", steps);
    write_checkpoint(files[0], from);
    write_checkpoint(files[1], wanted);
    program_result r = program_run(NULL, (char *const[]){self, again, (char *)path, files[0], files[1], number, NULL});
    int status = r.status;
    program_free(&r);
    return status == 0;
}

static int be_the_other_process(char *const *words)
{
    scene *s = load(words[0]);
    checkpoint from = read_checkpoint(words[1]), wanted = read_checkpoint(words[2]);
    started_run r = start(s);
    bool same = comes_to(&r, &from, atol(words[3]), &wanted);
    run_end(&r);
    free(from.bytes);
    free(wanted.bytes);
    scene_free(s);
    return same ? 0 : 1;
}

static int check_scene(const char *path, const char *folder)
{
    int count = 0;
    scene *s = load(path);
    started_run first = start(s), used = start(s);
    advance(&used, ELSEWHERE);
    long steps = simulation_steps(first.s), at = draw_full() || steps <= QUICK + BETWEEN ? 0 : QUICK;
    advance(&first, at);
    for (; at < steps; count++) {
        long on = steps - at < BETWEEN ? steps - at : BETWEEN;
        checkpoint from = save(&first);
        advance(&first, on);
        checkpoint wanted = save(&first);
        started_run fresh = start(s);
        if (!comes_to(&fresh, &from, on, &wanted)) fail_msg("%s, step %ld: a fresh world differs", path, at);
        if (!comes_to(&used, &from, on, &wanted)) fail_msg("%s, step %ld: a used world differs", path, at);
        if (!comes_to(&first, &from, on, &wanted)) fail_msg("%s, step %ld: the same world differs", path, at);
        if (!another_process_comes_to(path, folder, &from, on, &wanted))
            fail_msg("%s, step %ld: another process differs", path, at);
        run_end(&fresh);
        free(from.bytes);
        free(wanted.bytes);
        at = draw_full() ? at + on : steps;
    }
    run_end(&first);
    run_end(&used);
    scene_free(s);
    return count;
}

static void test_saved_scenes_go_on_to_the_same_bits(void **state)
{
    (void)state;
    glob_t shipped;
    int count = 0, scenes = 0;
    char *folder = program_make_folder();
    assert_int_equal(glob(PINCH_SOURCE_DIR "/assets/scenes/*.json", 0, NULL, &shipped), 0);
    assert_int_equal(glob(PINCH_SOURCE_DIR "/assets/scenes/hands/*.json", GLOB_APPEND, NULL, &shipped), 0);
    assert_true(shipped.gl_pathc >= 50);
    for (char *const *path = *chosen ? chosen : shipped.gl_pathv; *path; path++, scenes++)
        count += check_scene(*path, folder);
    print_message("%d checkpoints of %d scenes\n", count, scenes);
    globfree(&shipped);
    program_remove_folder(folder);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_saved_scenes_go_on_to_the_same_bits)};
    self = argv[0];
    chosen = argv + 1;
    dInitODE2(0);
    int failed = argc == 6 && strcmp(argv[1], "--again") == 0 ? be_the_other_process(argv + 2)
                                                              : cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
