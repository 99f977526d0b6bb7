/* Collisions of fingertip geoms allocate nothing. */
#include "support/cmocka_all.h"

#include "../demos/bench/allocations.h"
#include "support/tips.h"

#include <stdlib.h>

/* Every pair of shapes: an overlap of a thousandth of the reach, then of half of it. */
static void test_no_allocation(void **state)
{
    (void)state;
    static const double R[9] = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1}, S[9] = {1, 0, 0, 0, 0.6, -0.8, 0, 0.8, 0.6};
    static const double origin[3] = {0, 0, 0}, down[3] = {0, 0, -1};
    pinch_random random;
    pinch_random_seed(&random, 8);
    for (int i = 0; i < PINCH_TIP_COUNT; i++)
        for (int j = i; j < PINCH_TIP_COUNT; j++) {
            test_tip a, b;
            dContactGeom contacts[16];
            test_tip_make(&random, (pinch_tip_type)i, &a);
            test_tip_make(&random, (pinch_tip_type)j, &b);
            test_tip_place(&a, origin, R);
            for (int deep = 0; deep < 2; deep++) {
                test_tip_place(&b, origin, S);
                double touch = test_overlap(&a, &b, down);
                test_tip_place(&b, (const double[3]){0, 0, touch * (deep ? 0.5 : 0.999)}, S);
                long before = allocations_counted();
                int count = dCollide(a.geom, b.geom, 16, contacts, sizeof contacts[0]);
                assert_int_equal(allocations_counted(), before);
                assert_true(count > 0 || !deep);
            }
            test_tip_free(&a);
            test_tip_free(&b);
        }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_no_allocation)};
    int failed = cmocka_run_group_tests_name("tip allocation", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
