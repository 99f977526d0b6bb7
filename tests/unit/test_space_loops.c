/*
 * Joints that make loops and are driven along all of their freedoms have those of their rates as unknowns that loops
 * leave. All hard rows must hold, also those that say again what others say, and they share what they carry: the answer
 * has to be that of the system of forces, which has a multiplier for each row.
 */
#include "support/cmocka_all.h"

#include "force/force_system.h"
#include "kinematics/space_loops.h"
#include "support/draw.h"
#include "support/driven_island.h"
#include "velocity/velocity_system.h"

#include <pinch/problem.h>
#include <string.h>

enum { SEEDS = 2000 };

/* Counts the rows that close loops in the rates of joints, and those that depend on others. */
static int count_loops(const pinch_mobility *m, int *dependent)
{
    int rows = 0;
    *dependent = 0;
    for (int c = 0; c < m->cluster_count; c++) {
        const pinch_joint_space *space = m->clusters[c].space;
        if (!space || !space->loops) continue;
        rows += space->loops->count;
        *dependent += space->loops->count - space->loops->rank;
    }
    return rows;
}

/* Solves the step in the rates of joints. Returns false where these are not its unknowns, or there is no answer. */
static bool solve_in_rates(pinch_arena *arena, pinch_problem *p, int *dependent, bool *found)
{
    pinch_mobility m;
    pinch_velocity_system system;
    pinch_solver_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_arena_reset(arena);
    assert_true(pinch_mobility_build(arena, p, PINCH_ELIMINATE_INTO_RATES, &m));
    *found = count_loops(&m, dependent) > 0;
    if (!*found) return false;
    assert_int_equal(m.dependent_count > 0, *dependent > 0);
    assert_true(pinch_velocity_system_build(arena, p, &m, &system));
    assert_int_equal(pinch_velocity_solve(arena, &system, &settings, &result), PINCH_OK);
    pinch_velocity_read_back(&system, p);
    return result.status == PINCH_SOLVE_CONVERGED;
}

static bool solve_in_forces(pinch_arena *arena, pinch_problem *p)
{
    pinch_mobility m;
    pinch_force_system system;
    pinch_step_result result = {.unknowns = 0};
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_arena_reset(arena);
    assert_true(pinch_mobility_build(arena, p, PINCH_ELIMINATE_WHERE_CHEAP, &m));
    assert_true(pinch_force_solve(arena, p, &m, &settings, PINCH_FORCE_BY_NEWTON, &system, &result));
    return result.solve.status == PINCH_SOLVE_CONVERGED;
}

static double fastest_of(const pinch_problem *p)
{
    double fastest = 0;
    for (int b = 0; b < p->body_count; b++)
        for (int i = 0; i < 6; i++) fastest = fmax(fastest, fabs(p->bodies[b].velocity_end[i]));
    return fastest;
}

static double velocity_difference(const pinch_problem *p, const pinch_problem *q)
{
    double most = 0;
    for (int b = 0; b < p->body_count; b++)
        for (int i = 0; i < 6; i++)
            most = fmax(most, fabs(p->bodies[b].velocity_end[i] - q->bodies[b].velocity_end[i]));
    return most;
}

static double force_difference(const pinch_problem *p, const pinch_problem *q)
{
    double most = 0, size = 1;
    for (int k = 0; k < p->row_count; k++) {
        most = fmax(most, fabs(p->rows[k].force - q->rows[k].force));
        size = fmax(size, fabs(q->rows[k].force));
    }
    return most / size;
}

static void check_hard_rows(const pinch_problem *p)
{
    double v[6 * ISLAND_BODIES];
    for (int b = 0; b < p->body_count; b++) memcpy(v + 6 * b, p->bodies[b].velocity_end, 6 * sizeof *v);
    for (int k = 0; k < p->row_count; k++) {
        const pinch_joint_row *row = &p->rows[k];
        if (!pinch_row_is_hard(row)) continue;
        assert_close(island_row_velocity(row, v), row->rhs, 1e-9 * (1 + fastest_of(p)));
        assert_true(row->pivot >= 1e-3);
    }
}

/* The system of forces may take rows that hardly move what they ask for to contradict each other, and give way. */
static bool gives_way(const pinch_problem *p)
{
    for (int k = 0; k < p->row_count; k++)
        if (fabs(p->rows[k].violation) > 1e-9) return true;
    return false;
}

/* A step may have several answers where friction couples, so that a few may differ. */
static void test_answers_are_those_of_multipliers(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    int compared = 0, sharing = 0, others = 0, failed = 0;
    double most = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        static island made[2];
        int dependent = 0;
        bool found;
        for (int way = 0; way < 2; way++) {
            driven_island_make(&made[way], seed);
            driven_island_close(&made[way], seed);
        }
        bool solved = solve_in_rates(&arena, &made[0].problem, &dependent, &found);
        failed += found && !solved;
        if (!solved) continue;
        check_hard_rows(&made[0].problem);
        if (!solve_in_forces(&arena, &made[1].problem) || gives_way(&made[1].problem)) continue;
        compared++;
        sharing += dependent > 0;
        double miss = velocity_difference(&made[0].problem, &made[1].problem) / fastest_of(&made[1].problem);
        bool other = miss > 1e-7 || force_difference(&made[0].problem, &made[1].problem) > 1e-4;
        others += other;
        if (!other) most = fmax(most, force_difference(&made[0].problem, &made[1].problem));
    }
    pinch_arena_free(&arena);
    print_message("%d islands compared, %d share, %d with another answer, %d without one, forces within %.1e\n",
                  compared, sharing, others, failed, most);
    assert_true(compared > 200 && sharing > 60);
    assert_true(others <= compared / 50 && failed <= compared / 50);
}

/* A loop in a plane has one row too many where a ball joint closes it, and three where a hinge does. In whichever order
 * the joints are listed, the loop has one freedom, and all rows share what they carry. */
static void test_plane_loops(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    for (int order = 0; order < 48; order++) {
        static island made[2];
        int dependent;
        bool found, ball = order % 2 == 0;
        for (int way = 0; way < 2; way++) driven_island_four_bar(&made[way], order / 2, ball);
        assert_true(solve_in_rates(&arena, &made[0].problem, &dependent, &found));
        assert_int_equal(dependent, ball ? 1 : 3);
        check_hard_rows(&made[0].problem);
        assert_true(solve_in_forces(&arena, &made[1].problem));
        assert_true(velocity_difference(&made[0].problem, &made[1].problem) < 1e-9 * fastest_of(&made[1].problem));
        assert_true(force_difference(&made[0].problem, &made[1].problem) < 1e-6);
    }
    pinch_arena_free(&arena);
}

/* The whole step: chosen unknowns, retries, and the check that shares nothing with them. */
static void test_steps_are_verified(void **state)
{
    (void)state;
    pinch_step_solver *solver;
    pinch_solver_settings settings = pinch_default_solver_settings();
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    int unsolved = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        static island made;
        pinch_step_result result;
        driven_island_make(&made, seed);
        driven_island_close(&made, seed);
        if (seed % 4 == 0) made.problem.contact_count = 0; /* fingers that touch nothing */
        assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_OK);
        unsolved += result.solve.status != PINCH_SOLVE_CONVERGED;
    }
    pinch_step_solver_destroy(solver);
    print_message("%d of %d without an answer\n", unsolved, SEEDS);
    assert_int_equal(unsolved, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answers_are_those_of_multipliers),
        cmocka_unit_test(test_plane_loops),
        cmocka_unit_test(test_steps_are_verified),
    };
    return cmocka_run_group_tests_name("loops in the rates of joints", tests, NULL, NULL);
}
