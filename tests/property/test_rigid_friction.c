/* Rigid frictional problems: closed forms, random ones of many kinds, degenerate ones, and what is refused. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/rigid_pile.h"

#include <math.h>
#include <pinch/friction.h>
#include <stdlib.h>
#include <string.h>

static pinch_friction_result solve(rigid_pile *p)
{
    pinch_friction_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.tolerance = 1e-8;
    assert_int_equal(pinch_friction_solve(&p->problem, &settings, &result), PINCH_OK);
    return result;
}

/* A point of mass 1/w^2 that comes down on a floor with velocity 1 and along it with `along`. */
static void drop_point(rigid_pile *p, double w, double along, double friction)
{
    memset(p, 0, sizeof *p);
    p->freedoms[0] = RIGID_AXES;
    for (int i = 0; i < RIGID_AXES; i++) p->g[0][0][RIGID_AXES * i + i] = w;
    p->contacts[0] = (pinch_friction_contact){
        .body = {0, -1}, .g = {p->g[0][0], NULL}, .free = {-1, along, 0}, .friction = friction};
    p->problem = (pinch_friction_problem){1, p->freedoms, 1, p->contacts};
}

static void test_point(void **state)
{
    (void)state;
    static const double roots[] = {1e-3, 1, 1e3};
    for (int k = 0; k < 3; k++) {
        rigid_pile p;
        double mass = 1 / (roots[k] * roots[k]);
        drop_point(&p, roots[k], 0.2, 0.5); /* sticks */
        assert_int_equal(solve(&p).solve.status, PINCH_SOLVE_CONVERGED);
        assert_close(p.contacts[0].impulse[0] / mass, 1, 1e-7);
        assert_close(p.contacts[0].impulse[1] / mass, -0.2, 1e-7);
        assert_close(p.contacts[0].velocity[1], 0, 1e-7);
        drop_point(&p, roots[k], 2, 0.5); /* slips: the impulse is mu r_n against the slip */
        assert_int_equal(solve(&p).solve.status, PINCH_SOLVE_CONVERGED);
        assert_close(p.contacts[0].impulse[1] / mass, -0.5, 1e-7);
        assert_close(p.contacts[0].velocity[1], 1.5, 1e-7);
        drop_point(&p, roots[k], 2, 0.5);
        p.contacts[0].free[0] = 1; /* leaves */
        assert_int_equal(solve(&p).solve.status, PINCH_SOLVE_CONVERGED);
        for (int i = 0; i < RIGID_AXES; i++) assert_true(p.contacts[0].impulse[i] == 0);
        assert_true(p.contacts[0].velocity[1] == 2);
    }
}

/* A contact that cannot move presses without end when it comes closer, and there is no answer. */
static void test_no_answer(void **state)
{
    (void)state;
    rigid_pile p;
    drop_point(&p, 1, 0, 0.5);
    p.contacts[0].body[0] = -1;
    p.contacts[0].g[0] = NULL;
    p.problem.body_count = 0;
    pinch_friction_result r = solve(&p);
    assert_true(r.solve.status != PINCH_SOLVE_CONVERGED && r.error > 1e-8);
    p.contacts[0].free[0] = 1; /* goes away */
    assert_int_equal(solve(&p).solve.status, PINCH_SOLVE_CONVERGED);
    p.problem.contact_count = 0;
    assert_int_equal(solve(&p).solve.status, PINCH_SOLVE_CONVERGED);
}

static void test_random_piles(void **state)
{
    (void)state;
    int count = draw_count(4000), found[4] = {0};
    for (int kind = 0; kind < 4; kind++) {
        for (int i = 0; i < count; i++) {
            pinch_random random;
            rigid_pile p;
            pinch_random_seed(&random, 4 * (uint64_t)i + (uint64_t)kind);
            rigid_pile_draw(&random, kind & 1, kind & 2, &p);
            pinch_friction_result r = solve(&p);
            found[kind] += r.solve.status == PINCH_SOLVE_CONVERGED;
            /* what is called an answer has to be one by the laws, written out once more */
            if (r.solve.status != PINCH_SOLVE_CONVERGED) continue;
            double scale = 0;
            for (int c = 0; c < p.problem.contact_count; c++)
                for (int k = 0; k < RIGID_AXES; k++) scale += p.contacts[c].free[k] * p.contacts[c].free[k];
            double small = 1e-7 * sqrt(scale);
            for (int c = 0; c < p.problem.contact_count; c++) {
                const double *u = p.contacts[c].velocity, *f = p.contacts[c].impulse, mu = p.contacts[c].friction;
                double slip = hypot(u[1], u[2]), friction = hypot(f[1], f[2]);
                assert_true(f[0] >= -small && u[0] >= -small && fmin(f[0], u[0]) <= small);
                assert_true(friction <= mu * f[0] + small);
                /* friction is against the slip, and at its limit where there is slip */
                assert_true(fmin(slip, mu * f[0] - friction) <= 2 * small);
                if (slip > 1e-3 && friction > 1e-3)
                    assert_true(u[1] * f[1] + u[2] * f[2] <= -(1 - 1e-3) * slip * friction);
            }
        }
        print_message("kind %d: %d of %d solved\n", kind, found[kind], count);
        assert_true(found[kind] >= count - count / 20); /* with masses of 1 to 1e-6, one in a hundred is not found */
    }
}

static void test_wrong_calls(void **state)
{
    (void)state;
    rigid_pile p;
    pinch_friction_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    static const int one[1] = {0};
    drop_point(&p, 1, 0.2, 0.5);
    const rigid_pile good = p;
#define REFUSED(change)                                                                                                \
    do {                                                                                                               \
        p = good;                                                                                                      \
        p.contacts[0].g[0] = p.g[0][0];                                                                                \
        p.problem.contacts = p.contacts;                                                                               \
        p.problem.freedoms = p.freedoms;                                                                               \
        change;                                                                                                        \
        assert_int_equal(pinch_friction_solve(&p.problem, &settings, &result), PINCH_INVALID_ARGUMENT);                \
    } while (0)
    assert_int_equal(pinch_friction_solve(NULL, &settings, &result), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_friction_solve(&p.problem, NULL, &result), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_friction_solve(&p.problem, &settings, NULL), PINCH_INVALID_ARGUMENT);
    REFUSED(p.contacts[0].friction = -1);
    REFUSED(p.contacts[0].friction = NAN);
    REFUSED(p.contacts[0].friction = INFINITY);
    REFUSED(p.contacts[0].free[1] = NAN);
    REFUSED(p.contacts[0].impulse[2] = INFINITY);
    REFUSED(p.contacts[0].body[0] = 1);
    REFUSED(p.contacts[0].body[1] = 0);
    REFUSED(p.contacts[0].g[0] = NULL);
    REFUSED(p.g[0][0][4] = NAN);
    REFUSED(p.problem.body_count = -1);
    REFUSED(p.problem.contact_count = -1);
    REFUSED(p.problem.freedoms = one);
    settings.tolerance = 0;
    REFUSED((void)0);
    settings.tolerance = 1e-8;
    settings.max_iterations = 0;
    REFUSED((void)0);
    settings.max_iterations = 1; /* too few, and said so */
    p = good;
    drop_point(&p, 1, 2, 0.5);
    assert_int_equal(pinch_friction_solve(&p.problem, &settings, &result), PINCH_OK);
    assert_true(result.solve.status != PINCH_SOLVE_CONVERGED && result.error > settings.tolerance);
    p.contacts[0].velocity[0] = NAN;
    assert_true(isinf(pinch_friction_missed(p.contacts, 1)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point),
        cmocka_unit_test(test_no_answer),
        cmocka_unit_test(test_random_piles),
        cmocka_unit_test(test_wrong_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
