/* Tests the iterative solvers on small systems with known roots, and the support code below them. */
#include "support/lu.h"
#include "support/random.h"

#include <pinch/solver.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

enum { N = 4 };

/* F_i = A_i x - b_i + bend |x_i|: linear for bend 0, piecewise linear otherwise; `poison` makes F NaN beyond |x_0| >
 * poison */
typedef struct kinked {
    double a[N * N], b[N], bend, poison;
    double v[N * N], lu[N * N], scratch[N];
    int pivot[N];
    pinch_row_segment segment;
    int evaluations, linearizations;
} kinked;

static double kinked_row(void *self, const double *x, int i)
{
    kinked *k = self;
    double sum = k->bend * fabs(x[i]) - k->b[i];
    for (int j = 0; j < N; j++) sum += k->a[i * N + j] * x[j];
    return fabs(x[0]) > k->poison ? NAN : sum;
}

static void kinked_residual(void *self, const double *x, double *f)
{
    ((kinked *)self)->evaluations++;
    for (int i = 0; i < N; i++) f[i] = kinked_row(self, x, i);
}

static void kinked_linearize(void *self, const double *x)
{
    kinked *k = self;
    k->linearizations++;
    memcpy(k->v, k->a, sizeof k->v);
    for (int i = 0; i < N; i++) k->v[i * N + i] += x[i] < 0.0 ? -k->bend : k->bend;
}

static pinch_row kinked_v(void *self, int row)
{
    kinked *k = self;
    k->segment = (pinch_row_segment){0, N, k->v + row * N};
    return (pinch_row){1, &k->segment};
}

static bool kinked_solve(void *self, const double *rhs, double *dx)
{
    kinked *k = self;
    memcpy(k->lu, k->v, sizeof k->lu);
    if (!pinch_lu_factor(N, k->lu, k->pivot, k->scratch)) return false;
    pinch_lu_solve(N, k->lu, k->pivot, rhs, dx);
    return true;
}

static pinch_system system_of(kinked *k)
{
    return (pinch_system){.size = N,
                          .self = k,
                          .residual = kinked_residual,
                          .residual_row = kinked_row,
                          .linearize = kinked_linearize,
                          .row = kinked_v,
                          .solve = kinked_solve};
}

static const double ROOT[N] = {1.0, -2.0, 0.5, 3.0};

static kinked make_kinked(double bend)
{
    kinked k = {.a = {4, 1, 0, -1, 1, 5, 1, 0, 0, -1, 3, 1, 1, 0, 2, 6}, .bend = bend, .poison = INFINITY};
    double b[N];
    for (int i = 0; i < N; i++) b[i] = kinked_row(&k, ROOT, i);
    memcpy(k.b, b, sizeof b);
    return k;
}

static void assert_root(const double *x, double tolerance)
{
    for (int i = 0; i < N; i++) assert_true(fabs(x[i] - ROOT[i]) <= tolerance);
}

static void every_method_finds_the_root(void **state)
{
    (void)state;
    for (int solver = PINCH_SOLVER_NSNMGK; solver <= PINCH_SOLVER_NEWTON; solver++)
        for (int newton_finish = 0; newton_finish <= 1; newton_finish++)
            for (double bend = 0.0; bend < 2.0; bend += 0.9) {
                kinked k = make_kinked(bend);
                pinch_system system = system_of(&k);
                pinch_solver_settings settings = pinch_default_solver_settings();
                settings.solver = (pinch_solver)solver;
                settings.newton_finish = newton_finish;
                double x[N] = {0}, scratch[64];
                assert_true(pinch_solver_scratch(N) <= 64);
                pinch_solver_result result;
                assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
                assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
                assert_true(result.residual <= 1e-10);
                assert_root(x, 1e-9);
                if (solver != PINCH_SOLVER_NEWTON && !newton_finish) assert_true(result.projections > 0);
            }
}

static void a_start_at_the_root_costs_one_evaluation(void **state)
{
    (void)state;
    kinked k = make_kinked(0.9);
    pinch_system system = system_of(&k);
    pinch_solver_settings settings = pinch_default_solver_settings();
    double x[N], scratch[64];
    memcpy(x, ROOT, sizeof x);
    k.evaluations = 0;
    pinch_solver_result result;
    assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
    assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
    assert_int_equal(result.iterations, 0);
    assert_int_equal(k.evaluations, 1);
    assert_int_equal(k.linearizations, 0);
    assert_memory_equal(x, ROOT, sizeof x);
}

static void newton_ends_at_rounding_level(void **state)
{
    (void)state;
    kinked k = make_kinked(0.9);
    pinch_system system = system_of(&k);
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.solver = PINCH_SOLVER_NEWTON;
    settings.tolerance = 0.1;
    double x[N] = {0}, scratch[64];
    pinch_solver_result result;
    assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
    assert_true(result.residual <= 1e-14);
    assert_int_equal(result.newton_steps, result.iterations);
    assert_int_equal(pinch_solver_solved_by(&settings, &result), PINCH_SOLVED_BY_NEWTON);
}

static void what_is_not_finite_is_divergence_with_a_finite_point(void **state)
{
    (void)state;
    for (int solver = PINCH_SOLVER_NSNMGK; solver <= PINCH_SOLVER_NSNGRK; solver++) {
        kinked k = make_kinked(0.0);
        k.poison = 1e-3;
        pinch_system system = system_of(&k);
        pinch_solver_settings settings = pinch_default_solver_settings();
        settings.solver = (pinch_solver)solver;
        settings.newton_finish = false;
        double x[N] = {0}, scratch[64];
        pinch_solver_result result;
        assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
        assert_int_equal(result.status, PINCH_SOLVE_DIVERGED);
        assert_true(isfinite(result.residual));
        for (int i = 0; i < N; i++) assert_true(isfinite(x[i]));
    }
    kinked k = make_kinked(0.0);
    pinch_system system = system_of(&k);
    pinch_solver_settings settings = pinch_default_solver_settings();
    double x[N] = {NAN}, scratch[64];
    pinch_solver_result result;
    assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
    assert_int_equal(result.status, PINCH_SOLVE_DIVERGED);
}

static void running_out_of_iterations_is_no_answer(void **state)
{
    (void)state;
    kinked k = make_kinked(0.9);
    pinch_system system = system_of(&k);
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.newton_finish = false;
    settings.max_iterations = 3;
    double x[N] = {0}, scratch[64];
    pinch_solver_result result;
    assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
    assert_int_equal(result.status, PINCH_SOLVE_MAX_ITERATIONS);
    assert_int_equal(result.iterations, 3);
}

static void draws_depend_on_the_seed_and_on_nothing_else(void **state)
{
    (void)state;
    double first[3][N];
    for (int run = 0; run < 3; run++) {
        kinked k = make_kinked(0.9);
        pinch_system system = system_of(&k);
        pinch_solver_settings settings = pinch_default_solver_settings();
        settings.solver = PINCH_SOLVER_NSNGRK;
        settings.seed = run < 2 ? 7 : 8;
        settings.max_iterations = 20;
        double x[N] = {0}, scratch[64];
        pinch_solver_result result;
        assert_int_equal(pinch_solve_system(&system, &settings, scratch, x, &result), PINCH_OK);
        memcpy(first[run], x, sizeof x);
    }
    assert_memory_equal(first[0], first[1], sizeof first[0]);
    assert_memory_not_equal(first[0], first[2], sizeof first[0]);
}

static void settings_out_of_range_are_refused(void **state)
{
    (void)state;
    kinked k = make_kinked(0.0);
    pinch_system system = system_of(&k);
    double x[N] = {0}, scratch[64];
    pinch_solver_result result;
    pinch_solver_settings bad[6];
    for (int i = 0; i < 6; i++) bad[i] = pinch_default_solver_settings();
    bad[0].tolerance = 0.0;
    bad[1].tolerance = NAN;
    bad[2].goal = -1.0;
    bad[3].goal = 1.0;
    bad[4].max_iterations = 0;
    bad[5].solver = PINCH_SOLVER_COUNT;
    for (int i = 0; i < 6; i++)
        assert_int_equal(pinch_solve_system(&system, &bad[i], scratch, x, &result), PINCH_INVALID_ARGUMENT);
    pinch_solver_settings lemke = pinch_default_solver_settings();
    lemke.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_solve_system(&system, &lemke, scratch, x, &result), PINCH_UNSUPPORTED);
}

static void names_go_both_ways(void **state)
{
    (void)state;
    for (int i = 0; i < PINCH_SOLVER_COUNT; i++) {
        pinch_solver solver;
        assert_int_equal(pinch_solver_from_name(pinch_solver_name((pinch_solver)i), &solver), PINCH_OK);
        assert_int_equal(solver, i);
    }
    pinch_solver solver;
    assert_int_equal(pinch_solver_from_name("dantzig", &solver), PINCH_INVALID_ARGUMENT);
}

static void lu_solves_random_systems_and_knows_singular_ones(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int trial = 0; trial < 200; trial++) {
        enum { MAX = 12 };
        int n = 1 + trial % MAX, pivot[MAX];
        double a[MAX * MAX], lu[MAX * MAX], x[MAX], b[MAX], scratch[MAX];
        for (int i = 0; i < n * n; i++) a[i] = lu[i] = 2.0 * pinch_random_uniform(&random) - 1.0;
        for (int i = 0; i < n; i++) x[i] = pinch_random_uniform(&random);
        for (int i = 0; i < n; i++) {
            b[i] = 0.0;
            for (int j = 0; j < n; j++) b[i] += a[i * n + j] * x[j];
        }
        assert_true(pinch_lu_factor(n, lu, pivot, scratch));
        pinch_lu_solve(n, lu, pivot, b, b);
        for (int i = 0; i < n; i++) {
            double residual = 0.0;
            for (int j = 0; j < n; j++) residual += a[i * n + j] * (b[j] - x[j]);
            assert_true(fabs(residual) <= 1e-11);
        }
        if (n > 1) {
            /* last column a combination of the others, in any units */
            for (int i = 0; i < n; i++) a[i * n + n - 1] = 1e7 * a[i * n];
            assert_false(pinch_lu_factor(n, a, pivot, scratch));
        }
    }
    double nan_matrix[4] = {1.0, NAN, 0.0, 1.0}, scratch[2];
    int pivot[2];
    nan_matrix[0] = NAN;
    assert_false(pinch_lu_factor(2, nan_matrix, pivot, scratch));
}

/* Textbook elimination: one column after the other. */
static void factor_column_by_column(int n, double *a, int *pivot)
{
    for (int k = 0; k < n; k++) {
        pivot[k] = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[pivot[k] * n + k])) pivot[k] = i;
        for (int j = 0; j < n; j++) {
            double t = a[k * n + j];
            a[k * n + j] = a[pivot[k] * n + j];
            a[pivot[k] * n + j] = t;
        }
        double inverse = 1 / a[k * n + k];
        for (int i = k + 1; i < n; i++) {
            a[i * n + k] *= inverse;
            for (int j = k + 1; j < n; j++) a[i * n + j] -= a[i * n + k] * a[k * n + j];
        }
    }
}

static void lu_by_panels_has_the_bits_of_lu_by_columns(void **state)
{
    (void)state;
    enum { MAX = 41 };
    static double a[MAX * MAX], expected[MAX * MAX];
    pinch_random random;
    pinch_random_seed(&random, 4);
    for (int trial = 0; trial < 4 * MAX; trial++) {
        int n = 1 + trial % MAX, pivot[MAX], expected_pivot[MAX];
        double scratch[MAX], zeros = trial < 2 * MAX ? 0 : 0.6;
        for (int i = 0; i < n * n; i++) {
            bool zero = pinch_random_uniform(&random) < zeros && i % (n + 1) != 0;
            a[i] = expected[i] = zero ? 0 : 2 * pinch_random_uniform(&random) - 1;
        }
        assert_true(pinch_lu_factor(n, a, pivot, scratch));
        factor_column_by_column(n, expected, expected_pivot);
        assert_memory_equal(pivot, expected_pivot, sizeof *pivot * (size_t)n);
        for (int i = 0; i < n * n; i++) assert_true(a[i] == expected[i]);
    }
}

static void the_random_stream_is_the_published_one(void **state)
{
    (void)state;
    /* xoshiro256** from the state {1, 2, 3, 4}: first outputs of the reference implementation */
    pinch_random random = {{1, 2, 3, 4}};
    const uint64_t expected[] = {11520, 0, 1509978240, 1215971899390074240};
    for (int i = 0; i < 4; i++) assert_true(pinch_random_next(&random) == expected[i]);
    for (int i = 0; i < 1000; i++) {
        double u = pinch_random_uniform(&random);
        assert_true(u >= 0.0 && u < 1.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_finds_the_root),
        cmocka_unit_test(a_start_at_the_root_costs_one_evaluation),
        cmocka_unit_test(newton_ends_at_rounding_level),
        cmocka_unit_test(what_is_not_finite_is_divergence_with_a_finite_point),
        cmocka_unit_test(running_out_of_iterations_is_no_answer),
        cmocka_unit_test(draws_depend_on_the_seed_and_on_nothing_else),
        cmocka_unit_test(settings_out_of_range_are_refused),
        cmocka_unit_test(names_go_both_ways),
        cmocka_unit_test(lu_solves_random_systems_and_knows_singular_ones),
        cmocka_unit_test(lu_by_panels_has_the_bits_of_lu_by_columns),
        cmocka_unit_test(the_random_stream_is_the_published_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
