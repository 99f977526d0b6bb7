/*
 * Every solver gets random linear complementarity problems with known solutions, infeasible ones, and ones that end in
 * a ray. PINCH_TEST_FULL or `--full` makes it a hundred times as many.
 */
#include "solvers/fischer_burmeister.h"
#include "support/random.h"

#include <pinch/lcp.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX = 24 };

static int trials = 100;

static double uniform(pinch_random *random, double low, double high)
{
    return low + (high - low) * pinch_random_uniform(random);
}

typedef struct problem {
    int n;
    double m[MAX * MAX], q[MAX], z[MAX];
    bool free[MAX];
    pinch_lcp lcp;
} problem;

/* M = B B^T + skew: positive definite and asymmetric, so the solution is unique; q makes z that solution. */
static void draw_monotone(pinch_random *random, int n, bool mixed, problem *p)
{
    double b[MAX * MAX], w[MAX];
    p->n = n;
    for (int i = 0; i < n * n; i++) b[i] = uniform(random, -1.0, 1.0);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = i == j ? 0.1 : b[i * n + j] - b[j * n + i];
            for (int k = 0; k < n; k++) sum += b[i * n + k] * b[j * n + k];
            p->m[i * n + j] = sum;
        }
    for (int i = 0; i < n; i++) {
        p->free[i] = mixed && i % 3 == 0;
        bool active = pinch_random_uniform(random) < 0.5;
        p->z[i] = p->free[i] ? uniform(random, -1.0, 1.0) : active ? uniform(random, 0.1, 1.0) : 0.0;
        w[i] = p->free[i] || active ? 0.0 : uniform(random, 0.1, 1.0);
    }
    for (int i = 0; i < n; i++) {
        p->q[i] = w[i];
        for (int j = 0; j < n; j++) p->q[i] -= p->m[i * n + j] * p->z[j];
    }
    p->lcp = (pinch_lcp){.size = n, .m = p->m, .q = p->q, .free = mixed ? p->free : NULL};
}

static void known_solutions_are_found(void **state)
{
    (void)state;
    static const pinch_solver solvers[] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NEWTON, PINCH_SOLVER_LEMKE};
    pinch_random random;
    pinch_random_seed(&random, 21);
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(MAX, &ws), PINCH_OK);
    problem p;
    for (int trial = 0; trial < trials; trial++) {
        draw_monotone(&random, 1 + trial % MAX, trial % 2, &p);
        for (size_t s = 0; s < sizeof solvers / sizeof *solvers; s++) {
            pinch_solver_settings settings = pinch_default_solver_settings();
            settings.solver = solvers[s];
            double z[MAX] = {0}, w[MAX];
            pinch_solver_result result;
            assert_int_equal(pinch_lcp_solve(&p.lcp, &settings, ws, z, w, &result), PINCH_OK);
            assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
            /* the least eigenvalue of the symmetric part is 0.1, so an error is at most ten residuals and their roots
             */
            for (int i = 0; i < p.n; i++) assert_true(fabs(z[i] - p.z[i]) <= 1e-8);
        }
    }
    pinch_lcp_workspace_destroy(ws);
}

static void slow_methods_arrive_too(void **state)
{
    (void)state;
    static const pinch_solver solvers[] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NSNGRK, PINCH_SOLVER_PGS};
    pinch_random random;
    pinch_random_seed(&random, 22);
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(MAX, &ws), PINCH_OK);
    problem p;
    for (int trial = 0; trial < trials / 5; trial++) {
        draw_monotone(&random, 1 + trial % 6, trial % 2, &p);
        /* a heavy diagonal: Gauss-Seidel contracts and the Kaczmarz rows are nearly orthogonal */
        for (int i = 0; i < p.n; i++) {
            p.m[i * p.n + i] += 10.0;
            p.q[i] -= 10.0 * p.z[i];
        }
        for (size_t s = 0; s < sizeof solvers / sizeof *solvers; s++) {
            pinch_solver_settings settings = pinch_default_solver_settings();
            settings.solver = solvers[s];
            settings.newton_finish = false;
            settings.max_iterations = 200000;
            double z[MAX] = {0}, w[MAX];
            pinch_solver_result result;
            assert_int_equal(pinch_lcp_solve(&p.lcp, &settings, ws, z, w, &result), PINCH_OK);
            assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
            for (int i = 0; i < p.n; i++) assert_true(fabs(z[i] - p.z[i]) <= 1e-8);
        }
    }
    pinch_lcp_workspace_destroy(ws);
}

static void infeasible_problems_are_proven_so(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 23);
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(MAX, &ws), PINCH_OK);
    problem p;
    for (int trial = 0; trial < trials; trial++) {
        draw_monotone(&random, 2 + trial % (MAX - 1), false, &p);
        double y[MAX];
        assert_false(pinch_lcp_prove_infeasible(&p.lcp, ws, y));
        /* make a positive combination of the rows non-positive and its right-hand side negative */
        int n = p.n;
        double combination[MAX], q = 0.0;
        for (int i = 0; i < n - 1; i++) combination[i] = uniform(&random, 0.1, 1.0);
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int i = 0; i < n - 1; i++) sum += combination[i] * p.m[i * n + j];
            p.m[(n - 1) * n + j] = -sum - uniform(&random, 0.1, 1.0);
        }
        for (int i = 0; i < n - 1; i++) q += combination[i] * p.q[i];
        p.q[n - 1] = -q - 1.0;
        assert_true(pinch_lcp_prove_infeasible(&p.lcp, ws, y));
        for (int solver = 0; solver < PINCH_SOLVER_COUNT; solver++) {
            pinch_solver_settings settings = pinch_default_solver_settings();
            settings.solver = (pinch_solver)solver;
            settings.max_iterations = 200;
            double z[MAX] = {0}, w[MAX];
            pinch_solver_result result;
            assert_int_equal(pinch_lcp_solve(&p.lcp, &settings, ws, z, w, &result), PINCH_OK);
            assert_int_not_equal(result.status, PINCH_SOLVE_CONVERGED);
            assert_true(isnan(z[0]) && isnan(w[0]));
        }
    }
    pinch_lcp_workspace_destroy(ws);
}

static void lemke_names_a_ray(void **state)
{
    (void)state;
    /* feasible (z = (1, 1)) and without a complementary solution */
    const double m[] = {0.0, 1.0, 0.0, 0.0}, q[] = {-1.0, 1.0};
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(2, &ws), PINCH_OK);
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.solver = PINCH_SOLVER_LEMKE;
    double z[2], w[2], y[2];
    pinch_solver_result result;
    pinch_lcp lcp = {.size = 2, .m = m, .q = q};
    assert_int_equal(pinch_lcp_solve(&lcp, &settings, ws, z, w, &result), PINCH_OK);
    assert_int_equal(result.status, PINCH_SOLVE_RAY);
    assert_true(isnan(z[0]));
    assert_false(pinch_lcp_prove_infeasible(&lcp, ws, y));
    pinch_lcp_workspace_destroy(ws);
}

/* By how much z, w with w = M z + q miss the conditions, over what the sums' terms allow. Long doubles stand apart from
 * the arithmetic of the solvers. */
static double missed_beyond_rounding(const problem *p, const double *z, double tolerance)
{
    double worst = 0;
    for (int i = 0; i < p->n; i++) {
        long double w = p->q[i], terms = fabs(p->q[i]);
        for (int j = 0; j < p->n; j++) {
            long double term = (long double)p->m[i * p->n + j] * z[j];
            w += term;
            terms += fabsl(term);
        }
        double allowed = 2 * tolerance + 1e-14 * (double)terms;
        worst = fmax(worst, fabs(fmin(z[i], (double)w)) / allowed);
    }
    return worst;
}

/* Rows and columns of a monotone problem are multiplied by 1e-8 to 1e8. It keeps its one solution, so no solver may
 * call it infeasible, and what a solver calls converged must meet the conditions. */
static void badly_scaled_problems_are_never_wrong_in_silence(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 25);
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(MAX, &ws), PINCH_OK);
    problem p;
    int solved[PINCH_SOLVER_COUNT] = {0};
    for (int trial = 0; trial < trials; trial++) {
        double column[MAX], range = uniform(&random, 0, 8);
        draw_monotone(&random, 2 + trial % 7, false, &p);
        for (int i = 0; i < p.n; i++) column[i] = pow(10, uniform(&random, -range, range));
        for (int i = 0; i < p.n; i++) {
            double row = pow(10, uniform(&random, -range, range));
            p.q[i] *= row;
            for (int j = 0; j < p.n; j++) p.m[i * p.n + j] *= row * column[j];
        }
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
            pinch_solver_settings settings = pinch_default_solver_settings();
            settings.solver = (pinch_solver)s;
            settings.max_iterations = 2000;
            double z[MAX] = {0}, w[MAX];
            pinch_solver_result result;
            assert_int_equal(pinch_lcp_solve(&p.lcp, &settings, ws, z, w, &result), PINCH_OK);
            if (result.status == PINCH_SOLVE_CONVERGED) {
                solved[s]++;
                assert_true(missed_beyond_rounding(&p, z, settings.tolerance) <= 1);
            } else {
                assert_true(isnan(z[0]) && isnan(w[0]));
            }
        }
        double y[MAX];
        assert_false(pinch_lcp_prove_infeasible(&p.lcp, ws, y));
    }
    assert_true(solved[PINCH_SOLVER_LEMKE] > trials / 2);
    pinch_lcp_workspace_destroy(ws);
}

/* Without the diagonal, y = (0.68, 1, 7e-7) would be a ray with M^T y = 0 and q^T y < 0, and with it M^T y is positive
 * by 5e-11 of its terms: by so little that only z of 1e8 makes up for q^T y. Such a z there is: z3 = 10.625 / 0.16875,
 * z1 and z2 in proportion to it, so that w = 0. */
static void a_large_solution_is_one(void **state)
{
    (void)state;
    const double m[] = {0, -0.00121484375, 1683.59375, 0.00121484375, 0, -1144.53125, -1683.59375, 1144.53125, 0.16875};
    const double q[] = {0, 0, -10.625};
    pinch_lcp lcp = {.size = 3, .m = m, .q = q};
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(3, &ws), PINCH_OK);
    double y[3];
    assert_false(pinch_lcp_prove_infeasible(&lcp, ws, y));
    pinch_lcp_workspace_destroy(ws);
}

/* The third row is negative for every z >= 0, but not at z3 = -1e-14, which a tolerance takes for 0: its column moves w
 * by 1e12 times as much. Only max(z, 0) may be called an answer. */
static void what_is_below_zero_does_not_count(void **state)
{
    (void)state;
    const double m[] = {1859.375, 1e6, 196.875, -193.75, 15.977, -0.1, -1343.75, -0.18984, -1e12};
    const double q[] = {-192.578, -1.17578, -0.0130078};
    pinch_lcp lcp = {.size = 3, .m = m, .q = q};
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(3, &ws), PINCH_OK);
    double y[3];
    assert_true(pinch_lcp_prove_infeasible(&lcp, ws, y));
    for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
        pinch_solver_settings settings = pinch_default_solver_settings();
        settings.solver = (pinch_solver)s;
        double z[3] = {0}, w[3];
        pinch_solver_result result;
        assert_int_equal(pinch_lcp_solve(&lcp, &settings, ws, z, w, &result), PINCH_OK);
        assert_int_not_equal(result.status, PINCH_SOLVE_CONVERGED);
        assert_true(isnan(z[0]) && isnan(w[0]));
    }
    pinch_lcp_workspace_destroy(ws);
}

/* Numbers that leave double precision on the way are no answer. */
static void overflow_is_no_solution(void **state)
{
    (void)state;
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(2, &ws), PINCH_OK);
    static const double m[2][4] = {{1, -2, -2, 1}, {1, -1e5, -1e5, 1}}, q[] = {-1, -1};
    for (int k = 0; k < 2; k++)
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
            pinch_lcp lcp = {.size = 2, .m = m[k], .q = q};
            pinch_solver_settings settings = pinch_default_solver_settings();
            settings.solver = (pinch_solver)s;
            double z[2] = {0}, w[2];
            pinch_solver_result result;
            assert_int_equal(pinch_lcp_solve(&lcp, &settings, ws, z, w, &result), PINCH_OK);
            assert_int_not_equal(result.status, PINCH_SOLVE_CONVERGED);
        }
    pinch_lcp_workspace_destroy(ws);
}

static void rows_of_v_are_subgradients(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 24);
    problem p;
    for (int trial = 0; trial < trials; trial++) {
        draw_monotone(&random, 1 + trial % MAX, trial % 2, &p);
        static double scratch[2 * MAX * MAX + 8 * MAX];
        int pivot[MAX];
        pinch_row_segment segments[MAX];
        pinch_fischer_burmeister fb;
        pinch_system system = pinch_fischer_burmeister_init(&fb, &p.lcp, scratch, pivot, segments);
        double x[MAX], y[MAX], f[MAX], g[MAX];
        for (int i = 0; i < p.n; i++) x[i] = uniform(&random, -1.0, 1.0);
        for (int i = 0; i < p.n; i++) y[i] = uniform(&random, -1.0, 1.0);
        system.residual(system.self, x, f);
        double norms2[MAX];
        system.linearize(system.self, x);
        system.row_norms2(system.self, norms2);
        system.residual(system.self, y, g);
        for (int i = 0; i < p.n; i++) {
            pinch_row row = system.row(system.self, i);
            double slope = 0.0, norm2 = 0.0, added[MAX] = {0};
            for (int j = 0; j < p.n; j++) {
                slope += row.segments[0].values[j] * (y[j] - x[j]);
                norm2 += row.segments[0].values[j] * row.segments[0].values[j];
            }
            system.add_row(system.self, i, 2.0, added);
            for (int j = 0; j < p.n; j++)
                assert_true(fabs(added[j] - 2.0 * row.segments[0].values[j]) <= 1e-12 * sqrt(norm2));
            assert_true(fabs(norms2[i] - norm2) <= 1e-12 * norm2);
            assert_true(system.row_norm2(system.self, i) == norms2[i]);
            assert_true(fabs(system.residual_row(system.self, x, i) - f[i]) <= 1e-13 * (1.0 + fabs(f[i])));
            /* convex: the linearization is a lower bound */
            assert_true(g[i] >= f[i] + slope - 1e-12);
        }
    }
}

static void inputs_out_of_range_are_refused(void **state)
{
    (void)state;
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(0, &ws), PINCH_INVALID_ARGUMENT);
    assert_null(ws);
    assert_int_equal(pinch_lcp_workspace_create(1, &ws), PINCH_OK);
    const double m[] = {1.0, 0.0, 0.0, 1.0}, q[] = {1.0, 1.0}, bad[] = {NAN, 1.0};
    double z[2] = {0}, w[2];
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_solver_result result;
    pinch_lcp big = {.size = 2, .m = m, .q = q}, nan_q = {.size = 1, .m = m, .q = bad};
    assert_int_equal(pinch_lcp_solve(&big, &settings, ws, z, w, &result), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_lcp_solve(&nan_q, &settings, ws, z, w, &result), PINCH_INVALID_ARGUMENT);
    pinch_lcp_workspace_destroy(ws);
}

int main(int argc, char **argv)
{
    if (getenv("PINCH_TEST_FULL") || (argc > 1 && strcmp(argv[1], "--full") == 0)) trials *= 100;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_solutions_are_found),
        cmocka_unit_test(slow_methods_arrive_too),
        cmocka_unit_test(infeasible_problems_are_proven_so),
        cmocka_unit_test(lemke_names_a_ray),
        cmocka_unit_test(badly_scaled_problems_are_never_wrong_in_silence),
        cmocka_unit_test(what_is_below_zero_does_not_count),
        cmocka_unit_test(a_large_solution_is_one),
        cmocka_unit_test(overflow_is_no_solution),
        cmocka_unit_test(rows_of_v_are_subgradients),
        cmocka_unit_test(inputs_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
