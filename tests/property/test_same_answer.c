/* Solves random islands with other solvers and from other starts. The answer must be the same, unless there are two. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island_check.h"

#include <string.h>

/* Friction that depends on the normal force can leave a step several answers; then both have to be right. Without
 * friction there is one. */
static void two_answers(island_kind kind, int seed, const pinch_problem *other, double difference)
{
    referee_verdict v;
    referee_judge(other, &v);
    const char *fault = island_fault(other, &v);
    if (!fault && kind != ISLAND_FRICTIONLESS) return;
    print_error("%s, seed %d: %g N apart at a scale of %g N, %s\n", island_kind_name(kind), seed, difference, v.scale,
                fault ? fault : "without friction");
    fail();
}

static void test_newton_agrees(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings(), newton = settings;
    newton.solver = PINCH_SOLVER_NEWTON;
    int compared = 0, different = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island a, b;
        int count = draw_count(10000);
        for (int seed = 1; seed <= count; seed++) {
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (island_solve(&a, &settings).solve.status || island_solve(&b, &newton).solve.status) continue;
            referee_verdict v;
            referee_judge(&a.problem, &v);
            double difference = island_force_difference(&a.problem, &b.problem);
            compared++;
            if (difference <= island_law_tolerance(&v)) continue;
            different++;
            two_answers(kind, seed, &b.problem, difference);
        }
    }
    assert_true(compared > 7 * draw_count(10000));
    /* measured: 96 of 90,000 */
    print_message("%d of %d islands had two answers\n", different, compared);
    assert_true(different <= 2 + compared / 200);
}

/* How much stiffer the contacts are than the inertia: what a residual of 1e-10 becomes in the forces. */
static double stiffness_ratio(const pinch_problem *p)
{
    double most = 1;
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        const int body[2] = {c->body1, c->body2};
        for (int side = 0; side < 2; side++) {
            if (body[side] < 0 || p->bodies[body[side]].mass == 0) continue;
            const pinch_body *b = &p->bodies[body[side]];
            double least = fmin(b->inertia[0], fmin(b->inertia[4], b->inertia[8])), arm2 = 0;
            for (int i = 0; i < 3; i++) arm2 += pow(c->position[i] - b->position[i], 2);
            double g = p->step * fmax(c->stiffness[0], c->stiffness[1]) + fmax(c->damping[0], c->damping[1]);
            most = fmax(most, p->step * g * (1 / b->mass + 2 * arm2 / least));
        }
    }
    return most;
}

/* The Kaczmarz methods by themselves stop at the tolerance: where they get there, they have the same answer. */
static void kaczmarz_agrees(pinch_solver name, int least)
{
    pinch_solver_settings settings = island_settings(), kaczmarz = settings;
    kaczmarz.solver = name;
    kaczmarz.newton_finish = false;
    kaczmarz.max_iterations = draw_full() ? 20000 : 1000;
    int compared = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island a, b;
        int count = draw_full() ? 200 : 15;
        for (int seed = 1; seed <= count; seed++) {
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (island_solve(&a, &settings).solve.status) continue;
            pinch_step_result result = island_solve(&b, &kaczmarz);
            assert_int_equal(result.solve.newton_steps, 0);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) {
                island_assert_nan(&b);
                continue;
            }
            referee_verdict v;
            referee_judge(&a.problem, &v);
            double tolerance =
                10 * kaczmarz.tolerance * stiffness_ratio(&a.problem) * v.scale + island_law_tolerance(&v);
            double difference = island_force_difference(&a.problem, &b.problem);
            if (difference > tolerance) two_answers(kind, seed, &b.problem, difference);
            compared++;
        }
    }
    print_message("%s alone converged in %d islands\n", pinch_solver_name(name), compared);
    assert_true(compared >= least);
}

static void test_nsnmgk_alone_agrees(void **state)
{
    (void)state;
    kaczmarz_agrees(PINCH_SOLVER_NSNMGK, 30);
}

static void test_nsngrk_agrees(void **state)
{
    (void)state;
    kaczmarz_agrees(PINCH_SOLVER_NSNGRK, 30);
}

/* From the answer's own forces the same answer is found, at once. */
static void test_warm_start(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    int solved = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 100; seed++) {
            static island a, b;
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (island_solve(&a, &settings).solve.status) continue;
            referee_verdict v;
            referee_judge(&a.problem, &v);
            for (int k = 0; k < a.problem.contact_count; k++)
                memcpy(b.contacts[k].force, a.contacts[k].force, sizeof a.contacts[k].force);
            for (int k = 0; k < a.problem.row_count; k++) b.rows[k].force = a.rows[k].force;
            for (int k = 0; k < a.problem.body_count; k++)
                if (a.bodies[k].mass == 0) memcpy(b.bodies[k].velocity, a.bodies[k].velocity_end, sizeof(double[6]));
            pinch_step_result again = island_solve(&b, &settings);
            assert_int_equal(again.solve.status, PINCH_SOLVE_CONVERGED);
            assert_true(again.solve.iterations <= 3); /* rounding may leave it above the goal for a step or two */
            assert_true(island_force_difference(&a.problem, &b.problem) <= island_law_tolerance(&v));
            solved++;
        }
    assert_true(solved > 700);
}

/* What is remembered from the step before may save work but not change the answer, even where it does not fit. */
static void test_memory_does_not_change_answers(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings();
    pinch_step_memory *memory;
    assert_int_equal(pinch_step_memory_create(&memory), PINCH_OK);
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 100; seed++) {
            static island a, b;
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            b.problem.memory = memory;
            b.problem.tag = 7; /* always the same: it claims to be the island it was */
            if (island_solve(&a, &settings).solve.status) continue;
            referee_verdict v;
            pinch_step_result with = island_solve(&b, &settings);
            if (with.solve.status) print_error("%s, seed %d\n", island_kind_name(kind), seed);
            assert_int_equal(with.solve.status, PINCH_SOLVE_CONVERGED);
            referee_judge(&b.problem, &v);
            assert_null(island_fault(&b.problem, &v));
            assert_true(island_force_difference(&a.problem, &b.problem) <= island_law_tolerance(&v));
        }
    pinch_step_memory_destroy(memory);
}

static void count_calls(void *context, int iteration, double residual)
{
    (void)iteration;
    (void)residual;
    ++*(int *)context;
}

/* A single body is solved by equations of its own, unless somebody watches: then by those of any island. */
static void test_watched_islands_agree(void **state)
{
    (void)state;
    pinch_solver_settings settings = island_settings(), watched = settings;
    int single = 0, calls = 0;
    watched.progress = count_calls;
    watched.progress_context = &calls;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island a, b;
        int count = draw_count(10000);
        for (int seed = 1; seed <= count; seed++) {
            int masses = 0;
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            for (int k = 0; k < a.problem.body_count; k++) masses += a.bodies[k].mass > 0;
            if (masses != 1 || island_solve(&a, &settings).solve.status) continue;
            assert_int_equal(island_solve(&b, &watched).solve.status, PINCH_SOLVE_CONVERGED);
            referee_verdict v;
            referee_judge(&a.problem, &v);
            assert_null(island_fault(&a.problem, &v));
            double difference = island_force_difference(&a.problem, &b.problem);
            if (difference > island_law_tolerance(&v)) two_answers(kind, seed, &b.problem, difference);
            single++;
        }
    }
    print_message("%d islands of a single body\n", single);
    assert_true(single > 2 * draw_count(10000) && calls > single);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_newton_agrees),
        cmocka_unit_test(test_nsnmgk_alone_agrees),
        cmocka_unit_test(test_nsngrk_agrees),
        cmocka_unit_test(test_warm_start),
        cmocka_unit_test(test_memory_does_not_change_answers),
        cmocka_unit_test(test_watched_islands_agree),
    };
    return cmocka_run_group_tests_name("the same answer", tests, island_create_solver, island_destroy_solver);
}
