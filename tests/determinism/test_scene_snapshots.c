/*
 * Every shipped scene and every hand's is saved at each 100th step. From there the run goes on to the same bits in the
 * same world, in a fresh one and in another process, in a world that has done something else. What is compared is all
 * of the next checkpoint, 100 steps later: as each checkpoint leads to the next one, each leads to the end. A quick run
 * takes one checkpoint of every scene. Files as arguments are the scenes.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/program.h"
#include "support/started_run.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { BETWEEN = 100, ELSEWHERE = 37, QUICK = 200 };

typedef struct checkpoint {
    unsigned char *bytes;
    uint64_t size;
    long step;
} checkpoint;

/* The checkpoints of a run, each 100 steps after the one before it; the last one may be nearer. */
typedef struct chain {
    checkpoint *links;
    int count;
} chain;

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

static void advance(started_run *r, long steps)
{
    for (long i = 0; i < steps; i++) assert_int_equal(simulation_step(r->s), WORLD_OK);
}

static checkpoint save(started_run *r, long step)
{
    checkpoint c = {.step = step};
    size_t size;
    assert_true(simulation_checkpoint(r->s, &c.bytes, &size));
    c.size = size;
    return c;
}

/* Takes link k of the chain, and goes on to the next one. Is it that to the bit? */
static bool leads_on(started_run *r, const chain *c, int k)
{
    const checkpoint *from = &c->links[k], *wanted = &c->links[k + 1];
    assert_int_equal(simulation_resume(r->s, from->bytes, from->size), CHECKPOINT_FINE);
    advance(r, wanted->step - from->step);
    checkpoint end = save(r, wanted->step);
    bool same = end.size == wanted->size && memcmp(end.bytes, wanted->bytes, end.size) == 0;
    free(end.bytes);
    return same;
}

/* Runs the scene, and takes each part of it twice in the same world. */
static chain make_chain(const char *path, const scene *s)
{
    started_run first = start(s);
    long steps = simulation_steps(first.s), at = draw_full() || steps <= QUICK + BETWEEN ? 0 : QUICK;
    chain c = {calloc((size_t)(steps / BETWEEN) + 2, sizeof *c.links), 0};
    assert_non_null(c.links);
    advance(&first, at);
    c.links[c.count++] = save(&first, at);
    while (at < steps && (draw_full() || c.count < 2)) {
        long on = steps - at < BETWEEN ? steps - at : BETWEEN;
        advance(&first, on);
        at += on;
        c.links[c.count++] = save(&first, at);
        if (!leads_on(&first, &c, c.count - 2)) fail_msg("%s, step %ld: the same world differs", path, at - on);
    }
    run_end(&first);
    return c;
}

static void free_chain(chain *c)
{
    for (int k = 0; k < c->count; k++) free(c->links[k].bytes);
    free(c->links);
}

/* ---- the other process ---- */

static void write_chain(const char *path, const chain *c)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    for (int k = 0; k < c->count; k++) {
        assert_int_equal(fwrite(&c->links[k], sizeof c->links[k], 1, file), 1);
        assert_int_equal(fwrite(c->links[k].bytes, 1, c->links[k].size, file), c->links[k].size);
    }
    assert_int_equal(fclose(file), 0);
}

static chain read_chain(const char *path, int count)
{
    chain c = {calloc((size_t)count, sizeof *c.links), count};
    FILE *file = fopen(path, "rb");
    assert_true(file && c.links);
    for (int k = 0; k < count; k++) {
        assert_int_equal(fread(&c.links[k], sizeof c.links[k], 1, file), 1);
        c.links[k].bytes = malloc(c.links[k].size);
        assert_non_null(c.links[k].bytes);
        assert_int_equal(fread(c.links[k].bytes, 1, c.links[k].size, file), c.links[k].size);
    }
    fclose(file);
    return c;
}

/* The other process is this program once more, with the scene, a file and the number of links as arguments. */
static void check_in_another_process(const char *path, const char *folder, const chain *c)
{
    char file[512], count[32], again[] = "--again";
    snprintf(file, sizeof file, "%s/chain", folder);
    snprintf(count, sizeof count, "%d", c->count);
    write_chain(file, c);
    program_result r = program_run(NULL, (char *const[]){self, again, (char *)path, file, count, NULL});
    if (r.status != 0) fail_msg("%s: another process, status %d: %s", path, r.status, r.err);
    program_free(&r);
}

/* One world takes all links, from the last to the first: what it did before is always something else. */
static int be_the_other_process(char *const *words)
{
    int differ = 0;
    scene *s = load(words[0]);
    chain c = read_chain(words[1], atoi(words[2]));
    started_run used = start(s);
    advance(&used, ELSEWHERE);
    for (int k = c.count - 2; k >= 0; k--) {
        if (leads_on(&used, &c, k)) continue;
        fprintf(stderr, "it differs from step %ld on\n", c.links[k].step);
        differ = 1;
    }
    run_end(&used);
    free_chain(&c);
    scene_free(s);
    return differ;
}

static int check_scene(const char *path, const char *folder)
{
    scene *s = load(path);
    chain c = make_chain(path, s);
    for (int k = 0; k + 1 < c.count; k++) {
        started_run fresh = start(s);
        if (!leads_on(&fresh, &c, k)) fail_msg("%s, step %ld: a fresh world differs", path, c.links[k].step);
        run_end(&fresh);
    }
    check_in_another_process(path, folder, &c);
    int count = c.count - 1;
    free_chain(&c);
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

/* A run that goes on from a checkpoint knows the times of its own steps alone, and is not to divide them by all. */
static void test_times_are_of_own_steps(void **state)
{
    (void)state;
    enum { BEFORE = 30, OWN = 7 };
    scene *s = load(PINCH_SOURCE_DIR "/assets/scenes/egg.json");
    started_run first = start(s), second = start(s);
    advance(&first, BEFORE);
    checkpoint c = save(&first, BEFORE);
    assert_int_equal(simulation_resume(second.s, c.bytes, c.size), CHECKPOINT_FINE);
    assert_true(isnan(world_us_a_step(second.w, 1)));
    advance(&second, OWN);
    assert_int_equal(second.w->steps, BEFORE + OWN);
    assert_close(world_us_a_step(second.w, 1e-6 * OWN), 1, 1e-12);
    run_end(&first);
    run_end(&second);
    free(c.bytes);
    scene_free(s);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_saved_scenes_go_on_to_the_same_bits),
                                       cmocka_unit_test(test_times_are_of_own_steps)};
    self = argv[0];
    chosen = argv + 1;
    dInitODE2(0);
    int failed = argc == 5 && strcmp(argv[1], "--again") == 0 ? be_the_other_process(argv + 2)
                                                              : cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
