/* 10,000 times one bit of a run's checkpoint is turned over: none is taken for a checkpoint, and the run that it was
 * offered to still takes the one that is whole. */
#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/started_run.h"

#include <stdlib.h>
#include <string.h>

enum { FLIPS = 10000, BEFORE = 50 };

static started_run start(const scene *of)
{
    started_run r = run_start(of);
    assert_non_null(r.s);
    return r;
}

static void step_both(started_run *a, started_run *b)
{
    unsigned char *bytes[2];
    size_t size[2];
    for (int i = 0; i < BEFORE; i++) {
        assert_int_equal(simulation_step(a->s), WORLD_OK);
        assert_int_equal(simulation_step(b->s), WORLD_OK);
    }
    assert_true(simulation_checkpoint(a->s, &bytes[0], &size[0]) && simulation_checkpoint(b->s, &bytes[1], &size[1]));
    assert_true(size[0] == size[1] && memcmp(bytes[0], bytes[1], size[0]) == 0);
    free(bytes[0]);
    free(bytes[1]);
}

static void test_no_flip_is_accepted(void **state)
{
    (void)state;
    scene *shared;
    scene_error error;
    unsigned char *good;
    size_t size;
    pinch_random random;
    pinch_random_seed(&random, 11);
    assert_int_equal(scene_load(PINCH_SOURCE_DIR "/assets/scenes/egg.json", &shared, &error), SCENE_OK);
    started_run first = start(shared), other = start(shared);
    for (int i = 0; i < BEFORE; i++) assert_int_equal(simulation_step(first.s), WORLD_OK);
    assert_true(simulation_checkpoint(first.s, &good, &size));
    for (int i = 0; i < FLIPS; i++) {
        size_t at = pinch_random_next(&random) % size;
        unsigned char bit = (unsigned char)(1u << draw_index(&random, 8));
        good[at] ^= bit;
        assert_int_equal(simulation_resume(other.s, good, size), CHECKPOINT_DAMAGED);
        good[at] ^= bit;
    }
    for (size_t shorter = 0; shorter < size; shorter += 1 + size / 500)
        assert_int_equal(simulation_resume(other.s, good, shorter), CHECKPOINT_DAMAGED);
    assert_int_equal(simulation_resume(other.s, good, size), CHECKPOINT_FINE);
    step_both(&first, &other);
    free(good);
    run_end(&first);
    run_end(&other);
    scene_free(shared);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_no_flip_is_accepted)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
