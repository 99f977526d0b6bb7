/*
 * Solves steps with the linearized friction cone twice: by Newton's method on the velocity system with polygons, and by
 * Lemke's method on the complementarity problem of the same step. The two share the law's data and nothing of the way
 * to the answer.
 */
#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/island.h"

#include <math.h>
#include <string.h>

static pinch_step_solver *solver;

static int make_solver(void **state)
{
    (void)state;
    return pinch_step_solver_create(&solver) == PINCH_OK ? 0 : -1;
}

static int destroy_solver(void **state)
{
    (void)state;
    pinch_step_solver_destroy(solver);
    return 0;
}

static pinch_step_result solve(island *made, pinch_solver method)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_step_result result;
    settings.solver = method;
    assert_int_equal(pinch_step_solve(solver, &made->problem, &settings, &result), PINCH_OK);
    return result;
}

/* The pyramid is taken from the first friction coefficient, the same in all directions. */
static void linearize(island *made, int faces)
{
    made->problem.faces = faces;
    for (int k = 0; k < made->problem.contact_count; k++)
        made->problem.contacts[k].friction[1] = made->problem.contacts[k].friction[0];
}

static double scale_of(const pinch_problem *p)
{
    double most = 0;
    for (int k = 0; k < p->contact_count; k++)
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(p->contacts[k].force[i]));
    return most;
}

static void test_lemke_agrees(void **state)
{
    (void)state;
    static const island_kind kinds[] = {ISLAND_FRICTIONLESS, ISLAND_HARD, ISLAND_SOFT, ISLAND_GRASP};
    int compared = 0, different = 0, unsolved = 0;
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        for (int seed = 1; seed <= draw_count(4000); seed++) {
            static island a, b;
            int faces = 3 + seed % 8;
            island_make(&a, kinds[kind], (uint64_t)seed);
            island_make(&b, kinds[kind], (uint64_t)seed);
            linearize(&a, faces);
            linearize(&b, faces);
            unsolved += solve(&a, PINCH_SOLVER_NSNMGK).solve.status != PINCH_SOLVE_CONVERGED;
            if (solve(&b, PINCH_SOLVER_LEMKE).solve.status != PINCH_SOLVE_CONVERGED) continue;
            if (isnan(a.problem.contacts[0].force[0])) continue;
            double apart = 0, scale = scale_of(&a.problem);
            for (int k = 0; k < a.problem.contact_count; k++)
                for (int i = 0; i < 3; i++)
                    apart = fmax(apart, fabs(a.problem.contacts[k].force[i] - b.problem.contacts[k].force[i]));
            compared++;
            different +=
                apart > 1e-6 * scale; /* Lemke's residual of 1e-10, times stiffness over inertia of up to 1e4 */
        }
    }
    print_message("%d compared, %d with two answers, %d unsolved\n", compared, different, unsolved);
    assert_int_equal(unsolved, 0);
    assert_true(compared > 2 * draw_count(4000));
    assert_true(different <= 2 + compared / 100); /* friction can leave several answers, each verified */
}

/* A soft finger's prism does not become an ellipsoid with any number of facets. */
static void harden(island *made)
{
    for (int k = 0; k < made->problem.contact_count; k++)
        if (made->problem.contacts[k].model == PINCH_CONTACT_SOFT) made->problem.contacts[k].model = PINCH_CONTACT_HARD;
}

/* The more facets, the nearer the forces come to those of the exact cone. A corner can point off by half a facet's
 * angle, so the error falls as the number of facets grows: a quarter for four times as many, a third with some slack.
 */
static void test_facets_approach_the_cone(void **state)
{
    (void)state;
    double error[3] = {0, 0, 0};
    for (int seed = 1; seed <= 40; seed++) {
        static island exact, pyramid;
        island_make(&exact, ISLAND_GRASP, (uint64_t)seed);
        harden(&exact);
        linearize(&exact, 0);
        solve(&exact, PINCH_SOLVER_NSNMGK);
        for (int i = 0; i < 3; i++) {
            island_make(&pyramid, ISLAND_GRASP, (uint64_t)seed);
            harden(&pyramid);
            linearize(&pyramid, 8 << (2 * i));
            solve(&pyramid, PINCH_SOLVER_NSNMGK);
            for (int k = 0; k < exact.problem.contact_count; k++)
                error[i] += fabs(exact.problem.contacts[k].force[1] - pyramid.problem.contacts[k].force[1]);
        }
    }
    print_message("8, 32, 128 facets: %g, %g, %g N off in all\n", error[0], error[1], error[2]);
    assert_true(error[0] > 0);
    assert_true(error[1] < 0.35 * error[0] && error[2] < 0.35 * error[1]);
}

static void test_the_exact_cone_needs_another_solver(void **state)
{
    (void)state;
    static island made;
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_step_result result;
    island_make(&made, ISLAND_GRASP, 1);
    settings.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_UNSUPPORTED);
    made.problem.faces = 1;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lemke_agrees),
        cmocka_unit_test(test_facets_approach_the_cone),
        cmocka_unit_test(test_the_exact_cone_needs_another_solver),
    };
    return cmocka_run_group_tests(tests, make_solver, destroy_solver);
}
