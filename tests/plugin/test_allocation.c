/*
 * Nothing is allocated inside a step once a scene has been running. The linker sends this program's calls of the
 * allocator, those of libpinch and libpinch_ode included, through a counter; ODE's own stay its own.
 */
#include "support/cmocka_all.h"

#include "../demos/bench/allocations.h"
#include "support/block.h"
#include "support/draw.h"

#include <stdlib.h>
#include <string.h>

static long allocations_of(block *b, dJointID slider, int steps)
{
    pinch_random random;
    pinch_random_seed(&random, 2);
    long before = allocations_counted();
    for (int step = 0; step < steps; step++) {
        /* tossed about: contacts come and go, sticking and slipping */
        dBodyAddForce(b->body, draw_uniform(&random, -2, 2), draw_uniform(&random, -2, 2),
                      draw_uniform(&random, -4, 6));
        dBodyAddTorque(b->body, draw_uniform(&random, -0.05, 0.05), draw_uniform(&random, -0.05, 0.05), 0);
        if (step % 50 == 25) dJointDisable(slider);
        if (step % 50 == 0) dJointEnable(slider);
        if (step % 97 == 0) {
            dBodySetPosition(b->body, 0, 0, 0.0199);
            dBodySetLinearVel(b->body, 0, 0, 0);
        }
        block_step(b, 1e-3);
    }
    return allocations_counted() - before;
}

static void test_a_running_scene_allocates_nothing(void **state)
{
    (void)state;
    pinch_material m = pinch_default_material();
    m.model = PINCH_CONTACT_SOFT;
    block b;
    long start = allocations_counted();
    block_make(&b, &m, 0);
    assert_true(allocations_counted() > start); /* the counters do count */
    dBodyID rail = dBodyCreate(b.world);
    dBodySetPosition(rail, 0, 0, 0.1);
    dJointID slider = dJointCreateSlider(b.world, NULL);
    dJointAttach(slider, b.body, rail);
    dJointSetSliderAxis(slider, 0, 0, 1);
    assert_true(allocations_of(&b, slider, 1000) > 0);
    assert_int_equal(allocations_of(&b, slider, 3000), 0);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_true(stats.contacts_solved > 1000 && stats.memory > 0);
    block_free(&b);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_running_scene_allocates_nothing)};
    int failed = cmocka_run_group_tests_name("allocation", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
