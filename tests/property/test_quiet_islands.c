/* Next to nothing happens in these islands: contacts hardly touch, bodies fly freely, or there is nothing to solve. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island_check.h"

#include <string.h>

/* Contacts that all but open while the forces of the step before say otherwise: what is left is measured by what is
 * left, not by what was. Next to no force, next to no velocity, a warm start a thousand times too large. */
static void test_contacts_that_hardly_touch(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    pinch_random random;
    pinch_random_seed(&random, 12);
    int unverified = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES || kind == ISLAND_JOINTS) continue;
        for (int seed = 1; seed <= 200; seed++) {
            static island made;
            island_make(&made, kind, (uint64_t)seed);
            for (int b = 0; b < made.problem.body_count; b++) {
                memset(made.bodies[b].external, 0, sizeof made.bodies[b].external);
                for (int i = 0; i < 6; i++) made.bodies[b].velocity[i] *= 1e-7;
            }
            for (int k = 0; k < made.problem.contact_count; k++) {
                pinch_contact *c = &made.contacts[k];
                c->depth = draw_uniform(&random, -1, 1) * 1e-6 / c->stiffness[0];
                memset(c->surface_velocity, 0, sizeof c->surface_velocity);
                memset(c->elastic, 0, sizeof c->elastic);
                c->force[0] = draw_uniform(&random, 0, 1e-3);
            }
            pinch_step_result result = island_solve(&made, &settings);
            if (result.solve.status == PINCH_SOLVE_UNVERIFIED) {
                print_error("%s, seed %d: residual %g\n", island_kind_name(kind), seed, result.residual_max);
                unverified++;
            }
        }
    }
    assert_int_equal(unverified, 0);
}

/* Bodies that fly freely, joints and all, with contacts that do not touch: nothing but rounding to balance. */
static void test_free_flight(void **state)
{
    (void)state;
    pinch_solver_settings settings = pinch_default_solver_settings();
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES) continue; /* a drive goes on until it touches */
        for (int seed = 1; seed <= 200; seed++) {
            static island made;
            island_make(&made, kind, (uint64_t)seed);
            int hard = 0;
            for (int k = 0; k < made.problem.contact_count; k++) made.contacts[k].depth = -1;
            for (int k = 0; k < made.problem.row_count; k++) {
                pinch_joint_row *row = &made.rows[k];
                if (row->cfm > 0 || isfinite(row->low) || isfinite(row->high)) continue;
                row->rhs = 0;
                made.rows[hard++] = *row;
            }
            made.problem.row_count = hard;
            for (int b = 0; b < made.problem.body_count; b++) {
                /* at v* the joints hold to rounding already, as after a step */
                memset(made.bodies[b].external, 0, sizeof made.bodies[b].external);
            }
            pinch_step_result result = island_solve(&made, &settings);
            assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
            for (int b = 0; b < made.problem.body_count; b++)
                memcpy(made.bodies[b].velocity, made.bodies[b].velocity_end, sizeof made.bodies[b].velocity);
            result = island_solve(&made, &settings);
            if (result.solve.status) print_error("%s, seed %d\n", island_kind_name(kind), seed);
            assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
            for (int k = 0; k < made.problem.contact_count; k++) assert_true(made.contacts[k].force[0] == 0);
        }
    }
}

/* A body without contacts and an island without unknowns. */
static void test_trivial_islands(void **state)
{
    (void)state;
    static island made;
    pinch_solver_settings settings = island_settings();
    island_make(&made, ISLAND_HARD, 1);
    made.problem.contact_count = 0;
    assert_int_equal(island_solve(&made, &settings).solve.status, PINCH_SOLVE_CONVERGED);
    for (int b = 0; b < made.problem.body_count; b++)
        for (int i = 0; i < 6; i++) assert_close(made.bodies[b].velocity_end[i], made.bodies[b].velocity[i], 1e-15);

    /* a body held by six hard rows has no freedom left: its contacts still get their forces, its rows take them */
    island_make(&made, ISLAND_GRASP, 1);
    made.problem.row_count = 6;
    for (int k = 0; k < 6; k++) {
        memset(&made.rows[k], 0, sizeof made.rows[k]);
        made.rows[k].body2 = PINCH_STATIC_BODY;
        made.rows[k].j1[k] = 1;
        made.rows[k].low = -INFINITY;
        made.rows[k].high = INFINITY;
    }
    pinch_step_result result = island_solve(&made, &settings);
    assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
    assert_int_equal(result.unknowns, 0);
    referee_verdict v;
    referee_judge(&made.problem, &v);
    assert_null(island_fault(&made.problem, &v));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_contacts_that_hardly_touch),
        cmocka_unit_test(test_free_flight),
        cmocka_unit_test(test_trivial_islands),
    };
    return cmocka_run_group_tests_name("quiet islands", tests, island_create_solver, island_destroy_solver);
}
