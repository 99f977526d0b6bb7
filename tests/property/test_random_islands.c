/*
 * Solves random islands from a cold start. What the solver calls converged must be an answer, and it must say so where
 * it has none.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island_check.h"

/* State words, elastic state and slip are those of the forces. */
static const char *state_fault(const pinch_problem *p, const referee_verdict *v)
{
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        if ((c->state == PINCH_CONTACT_OPEN) != (c->force[0] == 0)) return "open state";
        if ((c->state == PINCH_CONTACT_YIELD) != (c->force[0] >= c->max_force)) return "yield state";
        for (int i = 0; i < 3; i++) {
            if (c->state == PINCH_CONTACT_STICK && c->slip[i] != 0) return "slip while sticking";
            if (c->state == PINCH_CONTACT_OPEN && (c->slip[i] != 0 || c->elastic_end[i] != 0))
                return "open and strained";
            double kt = c->stiffness[i < 2 ? 1 : 2], ct = c->damping[i < 2 ? 1 : 2];
            if (c->state == PINCH_CONTACT_OPEN || i + 1 >= (int)c->model) continue;
            /* r_t = -kt e+ - ct (e+ - e)/h */
            double force = -kt * c->elastic_end[i] - ct * (c->elastic_end[i] - c->elastic[i]) / p->step;
            double lever = i < 2 ? 1 : sqrt(c->stiffness[2] / c->stiffness[1]);
            if (!(fabs(force - c->force[1 + i]) <= island_law_tolerance(v) * fmax(lever, 1))) return "elastic state";
        }
    }
    return NULL;
}

static void test_answers_satisfy_the_laws(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    int wrong = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island made;
        int count = draw_count(10000), failed = 0;
        for (int seed = 1; seed <= count; seed++) {
            island_make(&made, kind, (uint64_t)seed);
            pinch_step_result result = island_solve(&made, &settings);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) {
                island_assert_nan(&made);
                failed++;
                if (draw_full())
                    print_message("%s %d: %s, residual %g\n", island_kind_name(kind), seed,
                                  pinch_solve_status_text(result.solve.status), result.solve.residual);
                continue;
            }
            island_assert_finite(&made);
            referee_verdict v;
            referee_judge(&made.problem, &v);
            const char *fault = island_fault(&made.problem, &v);
            if (!fault) fault = state_fault(&made.problem, &v);
            if (!fault && !(result.solve.residual <= settings.tolerance)) fault = "residual above the tolerance";
            if (!fault) continue;
            wrong++;
            print_error("%s, seed %d: %s (scale %g N)\n", island_kind_name(kind), seed, fault, v.scale);
        }
        print_message("%s: %d of %d cold starts did not converge\n", island_kind_name(kind), failed, count);
        assert_int_equal(failed, 0); /* measured: none in 10,000 of any kind */
    }
    assert_int_equal(wrong, 0);
}

/* What the verification reports must not be better than what the referee finds: both in newtons. */
static void test_reported_errors_are_true(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    settings.tolerance = 1e-6; /* coarse, so that there is something to report */
    settings.goal = 1e-6;
    int seen = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island made;
        for (int seed = 1; seed <= 100; seed++) {
            island_make(&made, kind, (uint64_t)seed);
            pinch_step_result result = island_solve(&made, &settings);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) continue;
            referee_verdict v;
            referee_judge(&made.problem, &v);
            assert_true(v.normal <= result.complementarity + 64 * v.rounding + 1e-13 * v.scale);
            assert_true(v.cone <= result.cone + 1e-13 * v.scale);
            /* relative to sums of magnitudes, which are at least the largest force over two bodies' worth */
            seen += v.balance > 1e-9 * v.scale;
            if (v.balance > 1e-9 * v.scale) assert_true(result.residual_max > 0);
            assert_true(v.balance <= 100 * settings.tolerance * 10 * v.scale);
        }
    }
    assert_true(seen > 50);
}

static void test_running_out_of_iterations_is_no_answer(void **state)
{
    (void)state;
    static const pinch_solver solvers[3] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NSNGRK, PINCH_SOLVER_NEWTON};
    int stopped = 0;
    for (int s = 0; s < 3; s++) {
        pinch_solver_settings settings = island_settings();
        settings.solver = solvers[s];
        settings.max_iterations = 1;
        for (int seed = 1; seed <= 50; seed++) {
            static island made;
            island_make(&made, ISLAND_JOINTS, (uint64_t)seed);
            pinch_step_result result = island_solve(&made, &settings);
            assert_true(result.solve.iterations <= 1);
            if (result.solve.status == PINCH_SOLVE_CONVERGED) continue;
            assert_int_equal(result.solve.status, PINCH_SOLVE_MAX_ITERATIONS);
            assert_true(result.solve.residual > settings.tolerance);
            island_assert_nan(&made);
            stopped++;
        }
    }
    assert_true(stopped > 75);
}

static void test_same_bits_again(void **state)
{
    (void)state;
    static const pinch_solver solvers[3] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NSNGRK, PINCH_SOLVER_NEWTON};
    for (int s = 0; s < 3; s++) {
        pinch_solver_settings settings = island_settings();
        settings.solver = solvers[s];
        settings.max_iterations = 300;
        for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
            for (int seed = 1; seed <= 10; seed++) {
                static island a, b, other;
                island_make(&a, kind, (uint64_t)seed);
                island_make(&b, kind, (uint64_t)seed);
                island_make(&other, kind, (uint64_t)seed + 1000);
                island_solve(&a, &settings);
                island_solve(&other, &settings); /* something else in between */
                island_solve(&b, &settings);
                assert_memory_equal(a.bodies, b.bodies, sizeof a.bodies);
                assert_memory_equal(a.contacts, b.contacts, sizeof a.contacts);
                assert_memory_equal(a.rows, b.rows, sizeof a.rows);
            }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answers_satisfy_the_laws),
        cmocka_unit_test(test_reported_errors_are_true),
        cmocka_unit_test(test_running_out_of_iterations_is_no_answer),
        cmocka_unit_test(test_same_bits_again),
    };
    return cmocka_run_group_tests_name("random islands", tests, island_create_solver, island_destroy_solver);
}
