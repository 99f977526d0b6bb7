/*
 * Trees of bodies whose joints are driven along all of their freedoms, as hands are, have the rates of their joints as
 * unknowns. They must move as the joints allow, each row along a joint must act on its own rate alone, and the step
 * must have the same answer as in orthonormal directions.
 */
#include "support/cmocka_all.h"

#include "kinematics/mobility.h"
#include "support/draw.h"
#include "support/driven_island.h"
#include "velocity/velocity_system.h"

#include <pinch/problem.h>
#include <string.h>

enum { ROOM = 6 * ISLAND_BODIES };

static void velocities(const pinch_problem *p, const pinch_mobility *m, const double *x, double *v)
{
    for (int b = 0; b < p->body_count; b++) pinch_mobility_velocity(m, b, x, v + 6 * b);
}

static double kinetic_product(const pinch_problem *p, const double *v, const double *w)
{
    double sum = 0;
    for (int b = 0; b < p->body_count; b++) {
        const pinch_body *body = &p->bodies[b];
        const double *a = v + 6 * b, *c = w + 6 * b;
        sum += body->mass * dot(a, c);
        for (int i = 0; i < 3; i++) sum += a[3 + i] * dot(body->inertia + 3 * i, c + 3);
    }
    return sum;
}

static int spaces_of(const pinch_mobility *m)
{
    int count = 0;
    for (int c = 0; c < m->cluster_count; c++) count += m->clusters[c].space != NULL;
    return count;
}

/* Hard rows hold at any rates, rows along joints have the velocity that their rate says, U^T M U is what the space
 * says, and `moved` is U^T M (v0 - v*). Tolerances: a few hundred roundings of the largest numbers that are compared.
 */
static void check_space(const pinch_problem *p, const pinch_mobility *m, const pinch_cluster *cluster,
                        pinch_random *random)
{
    const pinch_joint_space *space = cluster->space;
    double x[ROOM] = {0}, v[ROOM], v0[ROOM], u[ROOM][ROOM], change[ROOM];
    velocities(p, m, x, v0);
    for (int f = 0; f < m->unknowns; f++) {
        x[f] = 1;
        velocities(p, m, x, u[f]);
        x[f] = 0;
        for (int i = 0; i < 6 * p->body_count; i++) u[f][i] -= v0[i];
    }
    double largest = 1;
    for (int f = 0; f < m->unknowns; f++) x[f] = draw_uniform(random, -1, 1);
    velocities(p, m, x, v);
    for (int i = 0; i < 6 * p->body_count; i++) largest = fmax(largest, fabs(v[i]) + fabs(v0[i]));
    for (int k = 0; k < p->row_count; k++) {
        const pinch_joint_row *row = &p->rows[k];
        int body = row->body1 >= 0 ? row->body1 : row->body2;
        if (&m->clusters[m->cluster_of[body]] != cluster) continue;
        double expected = row->rhs;
        if (!m->eliminated[k]) {
            const pinch_joint_rate *rate = &m->loose.rate[k];
            assert_in_range(rate->direction, 0, space->rates - 1);
            expected = rate->factor * (space->speed[rate->direction] +
                                       space->scale[rate->direction] * x[cluster->first + rate->direction]);
        }
        assert_close(island_row_velocity(row, v), expected, 1e-10 * largest * (1 + fabs(expected)));
    }
    for (int b = 0; b < p->body_count; b++)
        for (int i = 0; i < 6; i++) change[6 * b + i] = v0[6 * b + i] - p->bodies[b].velocity[i];
    for (int f = 0; f < space->freedoms; f++) {
        const double *own = u[cluster->first + f];
        double size = sqrt(kinetic_product(p, change, change));
        assert_close(space->moved[f], kinetic_product(p, own, change), 1e-9 * (1e-3 + size));
        for (int g = 0; g < space->freedoms; g++)
            assert_close(space->inertia[f * space->freedoms + g], kinetic_product(p, own, u[cluster->first + g]), 1e-9);
        assert_close(space->inertia[f * (space->freedoms + 1)], 1, 1e-12);
    }
    double y[ROOM] = {0}; /* H^-1 H x = x */
    memcpy(y, x + cluster->first, sizeof *y * (size_t)space->freedoms);
    pinch_joint_space_add_coupling(space, x + cluster->first, y);
    pinch_joint_space_solve(space, y);
    for (int f = 0; f < space->freedoms; f++) assert_close(y[f], x[cluster->first + f], 1e-6);
}

static void test_rates_are_coordinates(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 64);
    pinch_arena arena;
    pinch_arena_init(&arena);
    int spaces = 0;
    for (uint64_t seed = 1; seed <= 400; seed++) {
        static island made;
        pinch_mobility m;
        driven_island_make(&made, seed);
        pinch_arena_reset(&arena);
        assert_true(pinch_mobility_build(&arena, &made.problem, PINCH_ELIMINATE_INTO_RATES, &m));
        for (int c = 0; c < m.cluster_count; c++)
            if (m.clusters[c].space) check_space(&made.problem, &m, &m.clusters[c], &random);
        spaces += spaces_of(&m);
    }
    pinch_arena_free(&arena);
    assert_true(spaces > 300);
}

/* Solves the step in velocities with one kind of coordinates. */
static bool solve(pinch_arena *arena, pinch_problem *p, pinch_elimination elimination, int *spaces)
{
    pinch_mobility m;
    pinch_velocity_system system;
    pinch_solver_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_arena_reset(arena);
    assert_true(pinch_mobility_build(arena, p, elimination, &m));
    *spaces = spaces_of(&m);
    assert_true(pinch_velocity_system_build(arena, p, &m, &system));
    assert_int_equal(pinch_velocity_solve(arena, &system, &settings, &result), PINCH_OK);
    pinch_velocity_read_back(&system, p);
    return result.status == PINCH_SOLVE_CONVERGED;
}

/* A step may have several answers where friction couples, so that a few may differ; see test_same_answer. */
static void test_answers_are_those_in_directions(void **state)
{
    (void)state;
    pinch_arena arena;
    pinch_arena_init(&arena);
    int compared = 0, others = 0, failed = 0;
    for (uint64_t seed = 1; seed <= 400; seed++) {
        static island made[2];
        int spaces[2];
        bool solved[2];
        for (int way = 0; way < 2; way++) {
            driven_island_make(&made[way], seed);
            solved[way] =
                solve(&arena, &made[way].problem, way ? PINCH_ELIMINATE_ALL : PINCH_ELIMINATE_INTO_RATES, &spaces[way]);
        }
        if (spaces[0] == 0) continue;
        failed += !solved[0];
        if (!solved[0] || !solved[1]) continue;
        compared++;
        double miss = 0, fastest = 0, force = 0, size = 0;
        for (int b = 0; b < made[0].problem.body_count; b++)
            for (int i = 0; i < 6; i++) {
                miss = fmax(miss, fabs(made[0].bodies[b].velocity_end[i] - made[1].bodies[b].velocity_end[i]));
                fastest = fmax(fastest, fabs(made[1].bodies[b].velocity_end[i]));
            }
        for (int k = 0; k < made[0].problem.row_count; k++) {
            force = fmax(force, fabs(made[0].rows[k].force - made[1].rows[k].force));
            size = fmax(size, fabs(made[1].rows[k].force));
        }
        others += miss > 1e-7 * fastest || force > 1e-6 * size;
    }
    pinch_arena_free(&arena);
    print_message("%d islands compared, %d with another answer, %d without one\n", compared, others, failed);
    assert_true(compared > 200);
    assert_true(others <= compared / 50 && failed <= compared / 50);
}

/* The whole step: chosen unknowns, retries, and the check that shares nothing with them. */
static void test_steps_are_verified(void **state)
{
    (void)state;
    pinch_step_solver *solver;
    pinch_solver_settings settings = pinch_default_solver_settings();
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    for (uint64_t seed = 1; seed <= 400; seed++) {
        static island made;
        pinch_step_result result;
        driven_island_make(&made, seed);
        if (seed % 4 == 0) made.problem.contact_count = 0; /* fingers that touch nothing */
        assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_OK);
        assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
    }
    pinch_step_solver_destroy(solver);
}

/*
 * Two sliders on rails that a coupling ties, each with dry friction, pushed by less than both frictions bear: three
 * rows say that two rates are zero. When the push is more, both slide with one speed. In every other step the coupling
 * contradicts the frictions by what it would move its joints back by, after a rounding: then one of them gives way.
 */
static void test_coupled_rates_that_are_held(void **state)
{
    (void)state;
    static island made;
    pinch_step_solver *solver;
    pinch_solver_settings settings = pinch_default_solver_settings();
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    double before[2] = {0}, coupled = 0;
    for (int step = 0; step < 40; step++) {
        pinch_step_result result;
        double push = step < 20 ? 0.1 * step : 4 - 0.1 * step, speed = 0; /* N, up to twice 0.5 N and beyond */
        driven_island_sliders(&made, push, before, coupled);
        pinch_joint_row *coupling = &made.rows[made.problem.row_count - 2];
        double apart = coupling->rhs = step % 2 ? 4e-12 : 0;
        assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_OK);
        assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
        assert_true(result.solve.newton_steps <= 4 && result.solve.projections == 0 && !result.solve.by_flow);
        for (int b = 0; b < 2; b++) {
            const pinch_joint_row *friction = &made.rows[made.problem.row_count - 4 + b];
            before[b] = friction->force;
            assert_true(fabs(friction->force) <= 0.5);
            speed = fmax(speed, fabs(made.bodies[b].velocity_end[0]));
        }
        coupled = coupling->force;
        assert_close(fabs(made.bodies[0].velocity_end[0] - made.bodies[1].velocity_end[0]), apart, 1e-14);
        if (push < 0.999) assert_close(speed, 0, apart + 1e-14);
        if (push > 1.001) assert_close(speed, 0.5 * (push - 1) * made.problem.step, apart + 1e-12);
    }
    pinch_step_solver_destroy(solver);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rates_are_coordinates),
        cmocka_unit_test(test_answers_are_those_in_directions),
        cmocka_unit_test(test_steps_are_verified),
        cmocka_unit_test(test_coupled_rates_that_are_held),
    };
    return cmocka_run_group_tests_name("rates of joints", tests, NULL, NULL);
}
