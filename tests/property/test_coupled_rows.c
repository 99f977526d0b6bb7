/*
 * Rows for more than two bodies: rows of joints that are cut into parts move everything as before, and random sums over
 * many bodies, hard, compliant and bounded, keep the law of a row.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island_check.h"

#include <string.h>

enum { MOST_ROWS = 3 * ISLAND_ROWS };

static double along(const pinch_problem *p, const pinch_joint_row *row)
{
    double u = 0;
    for (int i = 0; i < 6; i++) {
        if (row->body1 >= 0) u += row->j1[i] * p->bodies[row->body1].velocity_end[i];
        if (row->body2 >= 0) u += row->j2[i] * p->bodies[row->body2].velocity_end[i];
    }
    return u;
}

/* Cuts about half of the rows into parts that add up to them. Returns how many were cut. */
static int cut_rows(pinch_random *random, const pinch_problem *from, pinch_joint_row *rows, int *count)
{
    int cut = 0;
    *count = 0;
    for (int k = 0; k < from->row_count; k++) {
        pinch_joint_row *row = &rows[(*count)++];
        *row = from->rows[k];
        if (draw_chance(random, 0.5)) continue;
        pinch_joint_row *part = &rows[(*count)++];
        *part = *row;
        part->continues = true;
        for (int i = 0; i < 6; i++) {
            double share1 = draw_uniform(random, -1, 2), share2 = draw_uniform(random, -1, 2);
            part->j1[i] = share1 * row->j1[i];
            part->j2[i] = share2 * row->j2[i];
            row->j1[i] -= part->j1[i];
            row->j2[i] -= part->j2[i];
        }
        cut++;
    }
    return cut;
}

static void test_cut_rows_change_nothing(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    int compared = 0, different = 0, count = draw_count(20000);
    for (int seed = 1; seed <= count; seed++) {
        static island a, b;
        pinch_joint_row rows[MOST_ROWS];
        pinch_random random;
        double apart = 0, speed = 0;
        int row_count;
        pinch_random_seed(&random, (uint64_t)seed);
        island_make(&a, ISLAND_JOINTS, (uint64_t)seed);
        island_make(&b, ISLAND_JOINTS, (uint64_t)seed);
        if (cut_rows(&random, &a.problem, rows, &row_count) == 0) continue;
        b.problem.rows = rows;
        b.problem.row_count = row_count;
        if (island_solve(&a, &settings).solve.status) continue;
        pinch_step_result result = island_solve(&b, &settings);
        if (result.solve.status != PINCH_SOLVE_CONVERGED) print_error("seed %d: not solved\n", seed);
        assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
        for (int k = 0; k < a.problem.body_count; k++)
            for (int i = 0; i < 6; i++) {
                apart = fmax(apart, fabs(a.bodies[k].velocity_end[i] - b.bodies[k].velocity_end[i]));
                speed = fmax(speed, fabs(a.bodies[k].velocity_end[i]));
            }
        compared++;
        different += apart > 1e-7 * (1 + speed); /* friction may leave a step several answers */
    }
    print_message("%d of %d islands had another answer\n", different, compared);
    assert_true(compared > count / 2);
    assert_true(different <= 1 + compared / 100);
}

/* Makes the last rows of a problem a sum over three to six bodies, with any law. */
static void add_sum(pinch_random *random, pinch_problem *p, pinch_joint_row *rows)
{
    int parts = 2 + (int)draw_index(random, 2);
    bool hard = draw_chance(random, 0.5);
    for (int k = 0; k < parts; k++) {
        pinch_joint_row *row = &rows[p->row_count++];
        memset(row, 0, sizeof *row);
        row->continues = k > 0;
        row->body1 = (int)draw_index(random, (unsigned)p->body_count);
        row->body2 = draw_chance(random, 0.3) ? PINCH_STATIC_BODY : (int)draw_index(random, (unsigned)p->body_count);
        for (int i = 0; i < 6; i++) {
            row->j1[i] = draw_uniform(random, -1, 1);
            row->j2[i] = draw_uniform(random, -1, 1);
        }
        row->rhs = k == 0 ? draw_uniform(random, -0.5, 0.5) : 1000; /* that of a part does not count */
        row->low = -INFINITY;
        row->high = INFINITY;
    }
    pinch_joint_row *head = &rows[p->row_count - parts];
    head->cfm = hard ? 0 : draw_log_uniform(random, 1e-6, 10);
    if (draw_chance(random, 0.5)) head->high = draw_log_uniform(random, 1e-3, 10);
    if (draw_chance(random, 0.5)) head->low = -draw_log_uniform(random, 1e-3, 10);
}

static void test_sums_over_bodies_keep_their_law(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    int solved = 0, tried = 0, bound = 0, count = draw_count(10000);
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= count && kind != ISLAND_DRIVES; seed++) {
            static island made;
            pinch_joint_row rows[MOST_ROWS];
            pinch_random random;
            pinch_problem *p = &made.problem;
            pinch_random_seed(&random, (uint64_t)seed);
            island_make(&made, kind, (uint64_t)seed);
            memcpy(rows, p->rows, sizeof *rows * (size_t)p->row_count);
            p->rows = rows;
            for (int sums = 1 + (int)draw_index(&random, 3); sums > 0; sums--) add_sum(&random, p, rows);
            tried++;
            if (island_solve(&made, &settings).solve.status != PINCH_SOLVE_CONVERGED) continue;
            solved++;
            for (int k = 0; k < p->row_count; k++) {
                if (rows[k].continues || k + 1 == p->row_count || !rows[k + 1].continues) continue;
                double u = along(p, &rows[k]), force = rows[k].force;
                for (int i = k + 1; i < p->row_count && rows[i].continues; i++) {
                    u += along(p, &rows[i]);
                    assert_true(rows[i].force == force);
                }
                double missing = rows[k].rhs - rows[k].violation - u - rows[k].cfm * force;
                double tolerance = 1e-7 * (1 + fabs(u) + fabs(rows[k].cfm * force));
                bool low = force <= rows[k].low, high = force >= rows[k].high;
                bound += low || high;
                if (!(fabs(missing) <= tolerance || (low && missing < 0) || (high && missing > 0)))
                    print_error("%s, seed %d: misses %g, moves %g, force %g in %g to %g, cfm %g, violation %g\n",
                                island_kind_name(kind), seed, missing, u, force, rows[k].low, rows[k].high, rows[k].cfm,
                                rows[k].violation);
                assert_true(force >= rows[k].low && force <= rows[k].high);
                assert_true(fabs(missing) <= tolerance || (low && missing < 0) || (high && missing > 0));
            }
        }
    print_message("%d of %d solved, %d forces at a bound\n", solved, tried, bound);
    assert_true(solved > tried - 1 - tried / 50);
    assert_true(bound > solved / 10);
}

static void test_illegal_parts(void **state)
{
    (void)state;
    static island made;
    pinch_solver_settings settings = island_settings(), linear = settings;
    pinch_step_solver *solver;
    pinch_step_result result;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    island_make(&made, ISLAND_JOINTS, 1);
    made.rows[0].continues = true; /* of nothing */
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
    island_make(&made, ISLAND_JOINTS, 1);
    made.rows[1].continues = true;
    linear.solver = PINCH_SOLVER_LEMKE;
    made.problem.faces = 8;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &linear, &result), PINCH_UNSUPPORTED);
    pinch_step_solver_destroy(solver);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cut_rows_change_nothing),
        cmocka_unit_test(test_sums_over_bodies_keep_their_law),
        cmocka_unit_test(test_illegal_parts),
    };
    return cmocka_run_group_tests_name("coupled rows", tests, island_create_solver, island_destroy_solver);
}
