/*
 * Paths of solutions: they lead to the answer that Newton's method in the forces finds, and end where there is none.
 * The step tries them last, for islands that its other methods leave, so that these tests ask for them by themselves.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island.h"

#include "force/force_system.h"
#include "solvers/methods.h"
#include "verify/step_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void make(island *made, int kind, int seed, bool soft, bool bounded_rows)
{
    memset(made, 0, sizeof *made);
    island_make(made, (island_kind)kind, (uint64_t)seed);
    for (int i = 0; i < made->problem.contact_count; i++) made->contacts[i].may_soften = soft;
    for (int j = 0; j < made->problem.row_count && bounded_rows; j++) {
        made->rows[j].low = -2;
        made->rows[j].high = 5;
    }
}

/* Solves in the forces, along a path or by Newton's method. Returns whether there is a verified answer. */
static bool solve(island *made, pinch_force_way way, pinch_step_result *result)
{
    pinch_arena arena;
    pinch_mobility mobility;
    pinch_force_system system;
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_arena_init(&arena);
    memset(result, 0, sizeof *result);
    result->solve.status = PINCH_SOLVE_MAX_ITERATIONS; /* as after a solve that was none */
    assert_true(pinch_mobility_build(&arena, &made->problem, PINCH_ELIMINATE_INDEPENDENT, &mobility));
    assert_true(pinch_force_solve(&arena, &made->problem, &mobility, &settings, way, &system, result));
    bool answered = result->solve.status == PINCH_SOLVE_CONVERGED &&
                    pinch_step_verify(&made->problem, settings.tolerance, system.body_scratch, result);
    pinch_arena_free(&arena);
    return answered;
}

/* Answers need not be unique, but what a path leads to has to be one, and the velocities of islands without slip are.
 */
static void test_paths_lead_to_answers(void **state)
{
    (void)state;
    static island path, newton;
    int count = draw_count(6000) / 2, tried = 0, found = 0, both = 0, same = 0;
    for (int kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES) continue; /* drives have no mass, which the forces as unknowns need */
        for (int seed = 1; seed <= count; seed++) {
            pinch_step_result by_path, by_newton;
            make(&path, kind, seed, seed % 2, seed % 3 == 0);
            make(&newton, kind, seed, seed % 2, seed % 3 == 0);
            tried++;
            bool arrived = solve(&path, PINCH_FORCE_BY_PATH, &by_path),
                 solved = solve(&newton, PINCH_FORCE_BY_NEWTON, &by_newton);
            found += arrived;
            if (arrived) assert_true(by_path.solve.by_flow && by_path.solve.iterations > 0);
            if (!arrived || !solved || by_path.floor_level != by_newton.floor_level) continue;
            both++;
            double apart = 0, size = 0;
            for (int b = 0; b < path.problem.body_count; b++)
                for (int i = 0; i < 6; i++) {
                    apart = fmax(apart, fabs(path.bodies[b].velocity_end[i] - newton.bodies[b].velocity_end[i]));
                    size = fmax(size, fabs(newton.bodies[b].velocity_end[i]));
                }
            same += apart <= 1e-6 * size;
        }
    }
    print_message("%d islands: paths found %d answers; beside Newton's %d, the same velocities in %d\n", tried, found,
                  both, same);
    assert_true(found >= tried * 9 / 10);
    assert_true(same >= both * 9 / 10);
}

/* ---- paths of small systems whose shape is known ---- */

typedef struct shape {
    double (*f)(double x), (*slope)(double x);
    double jacobian;
    pinch_row_segment segment;
} shape;

static void residual(void *self, const double *x, double *f)
{
    f[0] = ((shape *)self)->f(x[0]);
}

static void linearize(void *self, const double *x)
{
    shape *s = self;
    s->jacobian = s->slope(x[0]);
}

static pinch_row row_of(void *self, int row)
{
    shape *s = self;
    (void)row;
    s->segment = (pinch_row_segment){.start = 0, .length = 1, .values = &s->jacobian};
    return (pinch_row){1, &s->segment};
}

/* Follows the path from x = 0. Returns whether it arrives. */
static bool follow(double (*f)(double x), double (*slope)(double x), int steps, double *x, int *used)
{
    shape s = {.f = f, .slope = slope};
    pinch_system system = {.size = 1, .self = &s, .residual = residual, .linearize = linearize, .row = row_of};
    double anchor = 0, *scratch = malloc(sizeof *scratch * pinch_path_scratch(1));
    assert_non_null(scratch);
    pinch_path_start start = {.anchor = &anchor, .size = 1};
    *x = -77;
    *used = steps;
    bool arrived = pinch_path(&system, &start, scratch, x, used);
    free(scratch);
    return arrived;
}

/* A bend: F falls first and rises then, so that t goes back on the way. */
static double bend(double x)
{
    return x < 1 ? -1 - x : x < 3 ? -2 + 0.01 * (x - 1) : -1.98 + 2 * (x - 3);
}

static double bend_slope(double x)
{
    return x < 1 ? -1 : x < 3 ? 0.01 : 2;
}

static double no_zero(double x)
{
    return -1 - x * x;
}

static double no_zero_slope(double x)
{
    return -2 * x;
}

static double not_a_number(double x)
{
    return x > 0.1 ? NAN : -1;
}

static double flat(double x)
{
    (void)x;
    return 0;
}

static double infinite(double x)
{
    (void)x;
    return INFINITY;
}

static double line(double x)
{
    return x - 0.5;
}

static double line_slope(double x)
{
    (void)x;
    return 1;
}

static void test_shapes(void **state)
{
    (void)state;
    double x;
    int used;
    assert_true(follow(line, line_slope, 100, &x, &used));
    assert_close(x, 0.5, 1e-9);
    assert_true(used > 0 && used <= 100);
    assert_true(follow(bend, bend_slope, 2000, &x, &used)); /* over two kinks, where Newton's method goes in circles */
    assert_close(x, 3.99, 1e-8);
    assert_false(follow(bend, bend_slope, 3, &x, &used)); /* too few steps, and x is left alone */
    assert_true(x == -77 && used >= 3);
    assert_false(follow(no_zero, no_zero_slope, 500, &x, &used));
    assert_true(x == -77);
    assert_false(follow(not_a_number, flat, 500, &x, &used));
    assert_false(follow(infinite, flat, 500, &x, &used));
    assert_false(follow(line, infinite, 500, &x, &used)); /* no derivative */
    assert_false(follow(line, line_slope, 0, &x, &used));
}

/* A kink so sharp that no correction gets around it, and the path turns into the next piece. */
static double kinked(double x)
{
    return x < 0.3 ? -1 + 0.5 * x : -0.85 + 1e4 * (x - 0.3);
}

static double kinked_slope(double x)
{
    return x < 0.3 ? 0.5 : 1e4;
}

/* A cliff down: t turns back at once there. */
static double cliff(double x)
{
    return x < 0.3 ? -1 + 0.5 * x : x < 0.4 ? -0.85 - 1e6 * (x - 0.3) : -0.85 - 1e5 + 4e5 * (x - 0.4);
}

static double cliff_slope(double x)
{
    return x < 0.3 ? 0.5 : x < 0.4 ? -1e6 : 4e5;
}

static void test_kinks(void **state)
{
    (void)state;
    double x;
    int used;
    assert_true(follow(kinked, kinked_slope, 4000, &x, &used));
    assert_close(x, 0.3 + 0.85e-4, 1e-9);
    if (follow(cliff, cliff_slope, 4000, &x, &used)) assert_close(cliff(x), 0, 1e-3);
}

/* A path that does not arrive leaves velocities that its forces give, not what was in memory: a recording of the solve
 * has them, and a replay has to find the same. */
static void test_velocities_where_no_path_arrives(void **state)
{
    (void)state;
    enum { MUCH = 1 << 17 }; /* numbers: more than the islands take */
    static island made;
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.max_iterations = 1;
    for (int kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES) continue;
        pinch_arena arena;
        pinch_mobility mobility;
        pinch_force_system system = {0};
        pinch_step_result result = {.solve.status = PINCH_SOLVE_MAX_ITERATIONS};
        make(&made, kind, 1, false, false);
        pinch_arena_init(&arena);
        double *garbage = PINCH_ARENA_ARRAY(&arena, double, MUCH);
        assert_non_null(garbage);
        pinch_arena_reset(&arena); /* into one block */
        garbage = PINCH_ARENA_ARRAY(&arena, double, MUCH);
        for (int i = 0; i < MUCH; i++) garbage[i] = NAN;
        pinch_arena_reset(&arena);
        assert_true(pinch_mobility_build(&arena, &made.problem, PINCH_ELIMINATE_INDEPENDENT, &mobility));
        assert_true(
            pinch_force_solve(&arena, &made.problem, &mobility, &settings, PINCH_FORCE_BY_PATH, &system, &result));
        assert_int_equal(result.solve.status, PINCH_SOLVE_MAX_ITERATIONS);
        size_t bytes = sizeof *system.q * (size_t)mobility.unknowns;
        double *left = malloc(bytes);
        assert_non_null(left);
        memcpy(left, system.q, bytes);
        for (int i = 0; i < mobility.unknowns; i++) assert_true(isfinite(left[i]));
        pinch_force_move(&system);
        assert_memory_equal(left, system.q, bytes);
        free(left);
        pinch_arena_free(&arena);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_paths_lead_to_answers),
        cmocka_unit_test(test_velocities_where_no_path_arrives),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_kinks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
