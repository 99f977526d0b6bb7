/*
 * Complementarity problems of seven classes, drawn at random or from the literature, by every solver. What a solver
 * calls converged meets the conditions, whatever the class, and none calls a problem infeasible that has a solution:
 * none is wrong in silence. Lemke's method has to solve the classes that it is known to process. PINCH_TEST_FULL or
 * `--full` makes it 1,500 of each class instead of 60; a name after `--full` runs that class alone.
 */
#include "support/random.h"

#include <pinch/lcp.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX = 24, LARGEST = 40 }; /* size of the random problems, and of the file's */

static int trials = 60;
static const char *only; /* the name of a class; NULL: all of them */

typedef struct problem {
    int n;
    double m[LARGEST * LARGEST], q[LARGEST];
} problem;

static double uniform(pinch_random *random, double low, double high)
{
    return low + (high - low) * pinch_random_uniform(random);
}

static double *entry(problem *p, int i, int j)
{
    return &p->m[i * p->n + j];
}

/* M = B B^T + skew with B of half the rank: positive semidefinite, singular in its symmetric part. */
static void draw_semidefinite(pinch_random *random, problem *p)
{
    double b[MAX * MAX];
    int rank = p->n / 2;
    for (int i = 0; i < p->n * rank; i++) b[i] = uniform(random, -1.0, 1.0);
    for (int i = 0; i < p->n; i++)
        for (int j = 0; j <= i; j++) {
            double sum = 0.0, skew = i == j ? 0.0 : uniform(random, -1.0, 1.0);
            for (int k = 0; k < rank; k++) sum += b[i * rank + k] * b[j * rank + k];
            *entry(p, i, j) = sum + skew;
            *entry(p, j, i) = sum - skew;
        }
}

/* q = w - M z of complementary z, w; `biactive`: in a third of the rows both are zero. */
static void set_solution(pinch_random *random, bool biactive, problem *p)
{
    double z[MAX], w[MAX];
    for (int i = 0; i < p->n; i++) {
        bool active = pinch_random_uniform(random) < 0.5, corner = biactive && i % 3 == 0;
        z[i] = active && !corner ? uniform(random, 0.1, 1.0) : 0.0;
        w[i] = active || corner ? 0.0 : uniform(random, 0.1, 1.0);
    }
    for (int i = 0; i < p->n; i++) {
        p->q[i] = w[i];
        for (int j = 0; j < p->n; j++) p->q[i] -= *entry(p, i, j) * z[j];
    }
}

static void draw_monotone(pinch_random *random, problem *p)
{
    draw_semidefinite(random, p);
    set_solution(random, false, p);
}

static void draw_degenerate(pinch_random *random, problem *p)
{
    draw_semidefinite(random, p);
    set_solution(random, true, p);
}

/* Entries of no sign but on the diagonal, as in a copositive matrix that is far from monotone: M = N with N >= 0 and a
 * positive diagonal is strictly copositive. Every q has a solution. */
static void draw_copositive(pinch_random *random, problem *p)
{
    for (int i = 0; i < p->n; i++) {
        for (int j = 0; j < p->n; j++)
            *entry(p, i, j) = pinch_random_uniform(random) < 0.5 ? uniform(random, 0.0, 3.0) : 0.0;
        *entry(p, i, i) += uniform(random, 0.05, 1.0);
        p->q[i] = uniform(random, -1.0, 0.5);
    }
}

/* An equilibrium of a game of two players with costs A, B > 0: M = [0 A; B^T 0], q = -1. Copositive, zero diagonal. */
static void draw_game(pinch_random *random, problem *p)
{
    int half = p->n / 2;
    memset(p->m, 0, sizeof p->m);
    for (int i = 0; i < half; i++)
        for (int j = half; j < p->n; j++) {
            *entry(p, i, j) = uniform(random, 0.1, 1.0);
            *entry(p, j, i) = uniform(random, 0.1, 1.0);
        }
    for (int i = 0; i < p->n; i++) p->q[i] = -1.0;
}

/* A P-matrix, strictly dominant by rows, whose rows and columns then get scales from 1e-3 to 1e3: the solution has
 * parts that are far apart. Every q has one. */
static void draw_scaled(pinch_random *random, problem *p)
{
    double columns[MAX];
    for (int j = 0; j < p->n; j++) columns[j] = pow(10.0, uniform(random, -3.0, 3.0));
    for (int i = 0; i < p->n; i++) {
        double scale = pow(10.0, uniform(random, -3.0, 3.0)), sum = 0.0;
        for (int j = 0; j < p->n; j++) sum += fabs(*entry(p, i, j) = uniform(random, -1.0, 1.0));
        *entry(p, i, i) = sum + 0.1;
        for (int j = 0; j < p->n; j++) *entry(p, i, j) *= scale * columns[j];
        p->q[i] = scale * uniform(random, -1.0, 1.0);
    }
}

/* No z has M z + q >= 0: a row of non-positive entries with a negative q. */
static void draw_infeasible(pinch_random *random, problem *p)
{
    draw_monotone(random, p);
    int row = p->n / 2;
    for (int j = 0; j < p->n; j++) *entry(p, row, j) = -uniform(random, 0.0, 1.0);
    p->q[row] = -uniform(random, 0.1, 1.0);
}

/* Problems of the literature of any size. Murty (1988): as many pivots as there are vertices; Fathi (1979): the same,
 * symmetric; Ahn (1983) and Geiger and Kanzow (1996): tridiagonal. */
static void draw_from_literature(pinch_random *random, problem *p)
{
    enum { MURTY, FATHI, AHN, GEIGER_KANZOW, KINDS };
    int kind = (int)(pinch_random_next(random) % KINDS);
    memset(p->m, 0, sizeof p->m);
    for (int i = 0; i < p->n; i++) {
        p->q[i] = -1.0;
        for (int j = 0; j < p->n; j++) {
            if (kind == MURTY) *entry(p, i, j) = i == j ? 1.0 : j > i ? 2.0 : 0.0;
            if (kind == FATHI) *entry(p, i, j) = i == j ? 1.0 + 4.0 * i : 2.0 + 4.0 * (i < j ? i : j);
            if (kind == AHN) *entry(p, i, j) = i == j ? 4.0 : j == i + 1 ? -2.0 : j == i - 1 ? 1.0 : 0.0;
            if (kind == GEIGER_KANZOW) *entry(p, i, j) = i == j ? 4.0 : abs(i - j) == 1 ? -1.0 : 0.0;
        }
    }
}

/* By how much z misses the conditions, over what the tolerance and rounding allow, in arithmetic of its own. */
static double missed(const problem *p, const double *z, double tolerance)
{
    double worst = 0.0;
    for (int i = 0; i < p->n; i++) {
        long double w = p->q[i], terms = fabs(p->q[i]);
        for (int j = 0; j < p->n; j++) {
            long double term = (long double)p->m[i * p->n + j] * z[j];
            w += term;
            terms += fabsl(term);
        }
        worst = fmax(worst, fabs(fmin(z[i], (double)w)) / (2.0 * tolerance + 1e-14 * (double)terms));
    }
    return worst;
}

/* Solves the problem by one solver. True when it converged; then its answer is one. Only a problem that is not
 * `feasible` may be called infeasible. */
static bool solve(const problem *p, pinch_solver solver, bool newton_finish, bool feasible, pinch_lcp_workspace *ws)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.solver = solver;
    settings.newton_finish = newton_finish;
    settings.max_iterations = 2000;
    double z[LARGEST] = {0}, w[LARGEST];
    pinch_solver_result result;
    pinch_lcp lcp = {.size = p->n, .m = p->m, .q = p->q};
    assert_int_equal(pinch_lcp_solve(&lcp, &settings, ws, z, w, &result), PINCH_OK);
    if (result.status == PINCH_SOLVE_CONVERGED) {
        assert_true(missed(p, z, settings.tolerance) <= 1.0);
        return true;
    }
    assert_true(!feasible || result.status != PINCH_SOLVE_INFEASIBLE);
    for (int i = 0; i < p->n; i++) assert_true(isnan(z[i]) && isnan(w[i]));
    return false;
}

/* Every solver on `trials` problems of a class. Returns how many Lemke's method solved; of a class that is not asked
 * for, `trials`. */
static int try_class(const char *name, void (*draw)(pinch_random *, problem *), uint64_t seed, int *most)
{
    *most = 0;
    if (only && strcmp(only, name) != 0) return trials;
    enum { PURE = PINCH_SOLVER_COUNT, COLUMNS };
    int solved[COLUMNS] = {0};
    pinch_random random;
    pinch_random_seed(&random, seed);
    pinch_lcp_workspace *ws;
    assert_int_equal(pinch_lcp_workspace_create(MAX, &ws), PINCH_OK);
    for (int trial = 0; trial < trials; trial++) {
        problem p = {.n = 2 + trial % (MAX - 1)};
        draw(&random, &p);
        bool feasible = draw != draw_infeasible;
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) solved[s] += solve(&p, (pinch_solver)s, true, feasible, ws);
        solved[PURE] += solve(&p, PINCH_SOLVER_NSNMGK, false, feasible, ws);
    }
    print_message("%s, of %d:", name, trials);
    for (int s = 0; s < COLUMNS; s++) {
        print_message(" %s %d", s == PURE ? "nsnmgk without Newton" : pinch_solver_name((pinch_solver)s), solved[s]);
        if (solved[s] > *most) *most = solved[s];
    }
    print_message("\n");
    pinch_lcp_workspace_destroy(ws);
    return solved[PINCH_SOLVER_LEMKE];
}

static void classes_that_lemke_processes(void **state)
{
    (void)state;
    int most;
    assert_int_equal(try_class("monotone", draw_monotone, 41, &most), trials);
    assert_int_equal(try_class("degenerate", draw_degenerate, 42, &most), trials);
    assert_int_equal(try_class("copositive", draw_copositive, 43, &most), trials);
    assert_int_equal(try_class("from the literature", draw_from_literature, 44, &most), trials);
}

/* Nothing is promised for games, whose M has a zero diagonal, but silence about a wrong answer. */
static void games(void **state)
{
    (void)state;
    int most;
    try_class("games", draw_game, 45, &most);
}

/* Nor for scales that are far apart. */
static void scaled_problems(void **state)
{
    (void)state;
    int most;
    try_class("scaled", draw_scaled, 47, &most);
}

static void infeasible_problems_have_no_answer(void **state)
{
    (void)state;
    int most;
    try_class("infeasible", draw_infeasible, 46, &most);
    assert_int_equal(most, 0);
}

/* ---- The test problems of another library. ---- */

/* CPS_4 and CPS_4bis have M = [A -B^T; B 0] with A positive definite: monotone. Those with a positive definite,
 * copositive-plus or P matrix are for Lemke's method, too. Of the others nothing is promised. */
static const struct {
    const char *name;
    bool by_lemke;
} of_siconos[] = {{"trivial", true},
                  {"deudeu", true},
                  {"ortiz", true},
                  {"exp_murty", true},
                  {"exp_murty2", true},
                  {"CPS_1", true},
                  {"CPS_2", false},
                  {"CPS_3", false},
                  {"CPS_4", true},
                  {"CPS_4bis", true},
                  {"CPS_5", true},
                  {"Pang_isolated_sol", false},
                  {"Pang_isolated_sol_perturbed", false},
                  {"inf_sol_perturbed", false},
                  {"enum_fails", false},
                  {"mmc", true},
                  {"tobenna", false}};

static bool read_problem(FILE *stream, char name[64], problem *p)
{
    if (fscanf(stream, "%63s %d", name, &p->n) != 2) return false;
    assert_in_range(p->n, 1, LARGEST);
    for (int i = 0; i < p->n * p->n; i++) assert_int_equal(fscanf(stream, "%lf", &p->m[i]), 1);
    for (int i = 0; i < p->n; i++) assert_int_equal(fscanf(stream, "%lf", &p->q[i]), 1);
    return true;
}

static void test_problems_of_another_library(void **state)
{
    (void)state;
    enum { FILES = sizeof of_siconos / sizeof *of_siconos };
    problem p;
    char name[64];
    int read = 0;
    pinch_lcp_workspace *ws;
    FILE *stream = fopen(PINCH_SOURCE_DIR "/tests/property/lcp_of_siconos.txt", "r");
    assert_non_null(stream);
    for (int line = 0; line < 2; line++) assert_int_equal(fscanf(stream, "%*[^\n]\n"), 0);
    assert_int_equal(pinch_lcp_workspace_create(LARGEST, &ws), PINCH_OK);
    for (; read_problem(stream, name, &p); read++) {
        assert_true(read < FILES);
        assert_string_equal(name, of_siconos[read].name);
        print_message("%-28s %2d:", name, p.n);
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
            bool solved = solve(&p, (pinch_solver)s, true, strcmp(name, "Pang_isolated_sol_perturbed") != 0, ws);
            print_message(" %s %s", pinch_solver_name((pinch_solver)s), solved ? "solved " : "-      ");
            if (s == PINCH_SOLVER_LEMKE && of_siconos[read].by_lemke) assert_true(solved);
        }
        print_message("\n");
    }
    assert_int_equal(read, FILES);
    pinch_lcp_workspace_destroy(ws);
    fclose(stream);
}

int main(int argc, char **argv)
{
    if (getenv("PINCH_TEST_FULL") || (argc > 1 && strcmp(argv[1], "--full") == 0)) trials = 1500;
    if (argc > 2) only = argv[2];
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classes_that_lemke_processes),
        cmocka_unit_test(games),
        cmocka_unit_test(scaled_problems),
        cmocka_unit_test(infeasible_problems_have_no_answer),
        cmocka_unit_test(test_problems_of_another_library),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
