/*
 * Siconos (INRIA) as a referee, where its library is installed: the complementarity problems of its tests and random
 * ones, each by its solvers and ours; and a performance profile (Dolan and More, "Benchmarking optimization software
 * with performance profiles", 2002) on rigid piles. What Siconos answers is judged by the conditions as ours is.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/rigid_pile.h"
#include "support/sanitized.h"

#include <pinch/lcp.h>

#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <LCP_Solvers.h>
#include <LinearComplementarityProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <float.h>
#include <lcp_cst.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Siconos' solvers leave matrices and options of their own behind. Without the frames of its library no function of it
 * can be named here. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libsiconos_numerics\n";
}

/* ---- complementarity problems ---- */

enum { LARGEST = 64 };

typedef struct drawn {
    int n;
    double m[LARGEST * LARGEST], q[LARGEST];
} drawn;

/* How far z is from a solution, beside the sizes of what is added up. A z so large that its rounding hides q is none,
 * however small its error is beside it: of a problem that has no solution, Siconos once gave 5e16 and missed by 1.4. */
static double missed(const drawn *p, const double *z)
{
    double worst = 0, largest = 0;
    for (int i = 0; i < p->n; i++) largest = fmax(largest, fabs(p->q[i]));
    for (int i = 0; i < p->n; i++) {
        double w = p->q[i], size = fabs(p->q[i]);
        for (int j = 0; j < p->n; j++) {
            w += p->m[i * p->n + j] * z[j];
            size += fabs(p->m[i * p->n + j] * z[j]);
        }
        if (!(p->n * DBL_EPSILON * size <= 1e-6 * largest)) return INFINITY;
        double off = fmax(fabs(fmin(z[i], w)), fmax(-z[i], -w)) / fmax(size, 1e-300);
        worst = isnan(off) ? INFINITY : fmax(worst, off);
    }
    return worst;
}

static bool solve_by_siconos(const drawn *p, int solver, double *z)
{
    double columns[LARGEST * LARGEST], w[LARGEST] = {0};
    for (int i = 0; i < p->n; i++)
        for (int j = 0; j < p->n; j++) columns[j * p->n + i] = p->m[i * p->n + j];
    double q[LARGEST];
    memcpy(q, p->q, sizeof q);
    memset(z, 0, sizeof *z * LARGEST);
    LinearComplementarityProblem theirs = {.size = p->n, .q = q};
    theirs.M = NM_create_from_data(NM_DENSE, p->n, p->n, columns);
    SolverOptions *options = solver_options_create(solver);
    options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
    options->iparam[SICONOS_IPARAM_MAX_ITER] = 10000;
    bool ended = linearComplementarity_driver(&theirs, z, w, options) == 0;
    solver_options_delete(options);
    free(options);
    free(theirs.M); /* the numbers are not its own */
    return ended && missed(p, z) < 1e-8;
}

/* Ours: the first of the solvers that converges. Returns which, -1 where none does. */
static int solve_by_pinch(const drawn *p, pinch_lcp_workspace *workspace, double *z)
{
    static const pinch_solver order[] = {PINCH_SOLVER_LEMKE, PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NEWTON,
                                         PINCH_SOLVER_PGS};
    pinch_lcp lcp = {.size = p->n, .m = p->m, .q = p->q};
    double w[LARGEST];
    for (int s = 0; s < 4; s++) {
        pinch_solver_settings settings = pinch_default_solver_settings();
        pinch_solver_result result;
        settings.solver = order[s];
        memset(z, 0, sizeof *z * LARGEST);
        assert_int_equal(pinch_lcp_solve(&lcp, &settings, workspace, z, w, &result), PINCH_OK);
        if (result.status != PINCH_SOLVE_CONVERGED) continue;
        assert_true(missed(p, z) < 1e-8);
        return s;
    }
    return -1;
}

typedef struct tally {
    int problems, theirs, ours, both, same, proven, only_theirs;
} tally;

/* `unique`: the solution is, so that two right ones are the same. */
static void compare(const drawn *p, bool unique, pinch_lcp_workspace *workspace, tally *t)
{
    static const int solvers[] = {SICONOS_LCP_LEMKE, SICONOS_LCP_PIVOT, SICONOS_LCP_NEWTON_FB_FBLSA, SICONOS_LCP_PGS};
    double z[LARGEST], theirs[LARGEST], proof[LARGEST];
    bool solved = false;
    for (size_t s = 0; s < 4 && !solved; s++) solved = solve_by_siconos(p, solvers[s], theirs);
    bool ours = solve_by_pinch(p, workspace, z) >= 0;
    pinch_lcp lcp = {.size = p->n, .m = p->m, .q = p->q};
    bool proven = !ours && pinch_lcp_prove_infeasible(&lcp, workspace, proof);
    assert_false(solved && proven); /* what has a solution is not called infeasible */
    t->problems++;
    t->theirs += solved;
    t->ours += ours;
    t->proven += proven;
    t->only_theirs += solved && !ours;
    if (!solved || !ours) return;
    t->both++;
    double apart = 0, size = 0;
    for (int i = 0; i < p->n; i++) {
        apart = fmax(apart, fabs(z[i] - theirs[i]));
        size = fmax(size, fabs(theirs[i]));
    }
    t->same += apart <= 1e-8 * fmax(size, 1);
    if (unique) assert_true(apart <= 1e-8 * fmax(size, 1));
}

static void print(const char *what, const tally *t)
{
    print_message("%-22s %4d problems: Siconos %d, Pinch %d (%d proven infeasible), both %d, the same %d\n", what,
                  t->problems, t->theirs, t->ours, t->proven, t->both, t->same);
}

static void test_problems_of_siconos(void **state)
{
    (void)state;
    drawn p;
    char name[64];
    tally t = {0};
    pinch_lcp_workspace *workspace;
    FILE *stream = fopen(PINCH_SOURCE_DIR "/tests/property/lcp_of_siconos.txt", "r");
    assert_non_null(stream);
    assert_int_equal(pinch_lcp_workspace_create(LARGEST, &workspace), PINCH_OK);
    for (int line = 0; line < 2; line++) assert_int_equal(fscanf(stream, "%*[^\n]\n"), 0);
    while (fscanf(stream, "%63s %d", name, &p.n) == 2) {
        assert_in_range(p.n, 1, LARGEST);
        for (int i = 0; i < p.n * p.n; i++) assert_int_equal(fscanf(stream, "%lf", &p.m[i]), 1);
        for (int i = 0; i < p.n; i++) assert_int_equal(fscanf(stream, "%lf", &p.q[i]), 1);
        tally one = {0};
        compare(&p, false, workspace, &one);
        print(name, &one);
        t.problems += one.problems;
        t.theirs += one.theirs;
        t.ours += one.ours;
        t.both += one.both;
        t.same += one.same;
        t.proven += one.proven;
        t.only_theirs += one.only_theirs;
    }
    print("all of them", &t);
    assert_int_equal(t.only_theirs, 0);
    pinch_lcp_workspace_destroy(workspace);
    fclose(stream);
}

/* M = B B^T + 0.1 I + skew: one solution; or B B^T with fewer columns than rows, where there may be many or none. */
static void draw_lcp(pinch_random *random, bool definite, drawn *p)
{
    p->n = 2 + draw_index(random, 20);
    int rank = definite ? p->n : 1 + p->n / 2;
    double b[LARGEST * LARGEST];
    for (int i = 0; i < p->n * rank; i++) b[i] = draw_uniform(random, -1, 1);
    for (int i = 0; i < p->n; i++) {
        p->q[i] = draw_uniform(random, -1, 1);
        for (int j = 0; j < p->n; j++) {
            double sum = definite && i == j ? 0.1 : 0;
            for (int k = 0; k < rank; k++) sum += b[i * rank + k] * b[j * rank + k];
            if (definite) sum += b[i * rank + j] - b[j * rank + i];
            p->m[i * p->n + j] = sum;
        }
    }
}

static void test_random_problems(void **state)
{
    (void)state;
    pinch_lcp_workspace *workspace;
    assert_int_equal(pinch_lcp_workspace_create(LARGEST, &workspace), PINCH_OK);
    for (int definite = 0; definite < 2; definite++) {
        tally t = {0};
        pinch_random random;
        pinch_random_seed(&random, 11);
        for (int i = 0; i < draw_count(10000); i++) {
            drawn p;
            draw_lcp(&random, definite, &p);
            compare(&p, definite, workspace, &t);
        }
        print(definite ? "positive definite" : "semidefinite", &t);
        if (definite) assert_int_equal(t.ours, t.problems);
        assert_int_equal(t.only_theirs, 0);
    }
    pinch_lcp_workspace_destroy(workspace);
}

/* ---- rigid piles: a performance profile. Siconos' methods have their own defaults, but for tolerance and iterations;
 * W is sparse. ---- */

enum { METHODS = 4, ROWS = RIGID_AXES * RIGID_CONTACTS };
static const char *const names[METHODS] = {"Pinch", "NSGS", "NSN-AC", "ADMM"};
static const int theirs[METHODS] = {0, SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_NSN_AC, SICONOS_FRICTION_3D_ADMM};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The Delassus operator W = G G^T of the pile, row by row. */
static void multiply(const rigid_pile *p, double *w)
{
    int n = RIGID_AXES * p->problem.contact_count;
    memset(w, 0, sizeof *w * (size_t)(n * n));
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            const pinch_friction_contact *x = &p->contacts[a / RIGID_AXES], *y = &p->contacts[b / RIGID_AXES];
            for (int s = 0; s < 2; s++)
                for (int t = 0; t < 2; t++) {
                    if (x->body[s] < 0 || x->body[s] != y->body[t]) continue;
                    for (int k = 0; k < RIGID_FREEDOMS; k++)
                        w[a * n + b] +=
                            x->g[s][a % RIGID_AXES * RIGID_FREEDOMS + k] * y->g[t][b % RIGID_AXES * RIGID_FREEDOMS + k];
                }
        }
}

/* Solves from zero. Returns the seconds that it took, infinite where what comes out is no answer to 1e-8 by W and q. */
static double time_of(int method, const rigid_pile *pile, const double *w)
{
    rigid_pile p = *pile;
    int contacts = p.problem.contact_count, n = RIGID_AXES * contacts;
    static double columns[ROWS * ROWS];
    double r[ROWS] = {0}, u[ROWS] = {0}, q[ROWS], mu[RIGID_CONTACTS], start, seconds;
    for (int c = 0; c < contacts; c++) {
        mu[c] = p.contacts[c].friction;
        memcpy(q + RIGID_AXES * c, p.contacts[c].free, sizeof p.contacts[c].free);
    }
    if (method == 0) {
        pinch_friction_problem problem = {p.problem.body_count, p.freedoms, contacts, p.contacts};
        pinch_solver_settings settings = pinch_default_solver_settings();
        pinch_friction_result result;
        settings.tolerance = 1e-8;
        start = now();
        assert_int_equal(pinch_friction_solve(&problem, &settings, &result), PINCH_OK);
        seconds = now() - start;
    } else {
        memcpy(columns, w, sizeof *w * (size_t)(n * n)); /* W is symmetric */
        NumericsMatrix *dense = NM_create_from_data(NM_DENSE, n, n, columns);
        NumericsMatrix *sparse = NM_create(NM_SPARSE, n, n);
        NM_copy_to_sparse(dense, sparse, 0);
        free(dense);
        FrictionContactProblem *problem = frictionContactProblem_new_with_data(RIGID_AXES, contacts, sparse, q, mu);
        SolverOptions *options = solver_options_create(theirs[method]);
        options->dparam[SICONOS_DPARAM_TOL] = 5e-9;
        options->iparam[SICONOS_IPARAM_MAX_ITER] = method == 2 ? 500 : 10000;
        start = now();
        (void)fc3d_driver(problem, r, u, options);
        seconds = now() - start;
        solver_options_delete(options);
        free(options);
        NM_clear(sparse);
        free(sparse);
        free(problem);
        for (int c = 0; c < contacts; c++)
            memcpy(p.contacts[c].impulse, r + RIGID_AXES * c, sizeof p.contacts[c].impulse);
    }
    for (int a = 0; a < n; a++) { /* the velocities by W */
        double sum = q[a];
        for (int b = 0; b < n; b++) sum += w[a * n + b] * p.contacts[b / RIGID_AXES].impulse[b % RIGID_AXES];
        p.contacts[a / RIGID_AXES].velocity[a % RIGID_AXES] = sum;
    }
    return pinch_friction_missed(p.contacts, contacts) <= 1.01e-8 ? seconds : INFINITY;
}

static void test_profile(void **state)
{
    (void)state;
    if (SANITIZED) skip(); /* times are of the other build, and its solves are the same */
    static const char *const kinds[] = {"plain", "masses 1 to 1e-6", "doubled contacts", "masses, doubled"};
    static const double factors[] = {1, 2, 5, 10, 100, INFINITY};
    enum { FACTORS = sizeof factors / sizeof *factors };
    int count = draw_count(400), times = draw_full() ? 3 : 1;
    for (int kind = 0; kind < 4; kind++) {
        int within[METHODS][FACTORS] = {{0}};
        for (int i = 0; i < count; i++) {
            static double w[ROWS * ROWS];
            rigid_pile p;
            pinch_random random;
            double seconds[METHODS], best = INFINITY;
            pinch_random_seed(&random, 4 * (uint64_t)i + (uint64_t)kind);
            rigid_pile_draw(&random, kind & 1, kind & 2, &p);
            multiply(&p, w);
            for (int m = 0; m < METHODS; m++) {
                seconds[m] = INFINITY;
                for (int k = 0; k < times; k++) seconds[m] = fmin(seconds[m], time_of(m, &p, w));
                best = fmin(best, seconds[m]);
            }
            for (int m = 0; m < METHODS; m++)
                for (int f = 0; f < FACTORS; f++)
                    within[m][f] += isfinite(seconds[m]) && seconds[m] <= factors[f] * best;
        }
        print_message("%s, %d piles: solved within a factor of the fastest, %%\n", kinds[kind], count);
        print_message("  %-8s %6s %6s %6s %6s %6s %6s\n", "", "1", "2", "5", "10", "100", "at all");
        for (int m = 0; m < METHODS; m++) {
            print_message("  %-8s", names[m]);
            for (int f = 0; f < FACTORS; f++) print_message(" %6.1f", 100.0 * within[m][f] / count);
            print_message("\n");
        }
        assert_true(within[0][FACTORS - 1] >= count - count / 20);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_problems_of_siconos),
        cmocka_unit_test(test_random_problems),
        cmocka_unit_test(test_profile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
