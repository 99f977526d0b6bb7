/* The force law of a contact: its values from the equations of problem.h, its tangent from differences. */
#include "support/cmocka_all.h"

#include "law/contact_law.h"
#include "support/draw.h"

#include <string.h>

static pinch_contact plain_contact(pinch_contact_model model)
{
    pinch_contact c;
    memset(&c, 0, sizeof c);
    c.model = model;
    c.depth = 1e-3;
    c.stiffness[0] = 1e4;
    c.stiffness[1] = 5e3;
    c.stiffness[2] = 2;
    c.damping[0] = 20;
    c.damping[1] = 10;
    c.damping[2] = 0.01;
    c.friction[0] = c.friction[1] = 0.5;
    c.torsional_friction = 0.01;
    c.max_force = INFINITY;
    return c;
}

static pinch_contact_state evaluate(const pinch_contact *c, double h, const double w[4], double r[4])
{
    pinch_contact_law law;
    pinch_trial_force trial;
    memset(r, 0, 4 * sizeof *r);
    pinch_contact_law_of(c, 0, &law);
    pinch_trial_force_of(c, h, &trial);
    return pinch_contact_law_evaluate(&law, &trial, w, r, NULL);
}

/* Exact decimal arithmetic on paper; a few roundings of numbers of size 10 are 1e-14. */
static const double ROUNDING = 1e-14;

static void test_normal_law(void **state)
{
    (void)state;
    pinch_contact c = plain_contact(PINCH_CONTACT_FRICTIONLESS);
    double r[4];
    /* at rest: kn depth */
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_STICK);
    assert_close(r[0], 10, ROUNDING);
    /* closing at 0.1 m/s: kn (depth + h 0.1) + cn 0.1 = 10 + 1 + 2 */
    evaluate(&c, 1e-3, (double[4]){-0.1, 0, 0, 0}, r);
    assert_close(r[0], 13, ROUNDING);
    /* pulled away fast enough to stick by damping: adhesion is cut */
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){1, 0, 0, 0}, r), PINCH_CONTACT_OPEN);
    assert_true(r[0] == 0);
    /* the force limit */
    c.max_force = 7;
    evaluate(&c, 1e-3, (double[4]){0}, r);
    assert_true(r[0] == 7);
    /* separated */
    c.depth = -1e-3;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_OPEN);
    assert_true(r[0] == 0);
    /* just touching carries nothing */
    c.depth = 0;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_OPEN);
}

static void test_friction_disc(void **state)
{
    (void)state;
    pinch_contact c = plain_contact(PINCH_CONTACT_HARD);
    double r[4];
    /* sticks: -kt (e + h w) - ct w along t1, t2; limit 0.5 * 10 N */
    c.elastic[0] = 2e-4;
    c.elastic[1] = -1e-4;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0, 0, 0.1, 0}, r), PINCH_CONTACT_STICK);
    assert_close(r[1], -1, ROUNDING);
    assert_close(r[2], 0.5 - 0.5 - 1, ROUNDING);
    /* slips: radially back to the disc of 5 N. Trial (-6, 8) N. */
    c.elastic[0] = 1.2e-3;
    c.elastic[1] = -1.6e-3;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_SLIP);
    assert_close(r[1], -3, ROUNDING);
    assert_close(r[2], 4, ROUNDING);
    /* the disc scales with the clamped normal force */
    c.max_force = 2;
    evaluate(&c, 1e-3, (double[4]){0}, r);
    assert_close(hypot(r[1], r[2]), 1, ROUNDING);
    /* no normal force: no friction, whatever the spring says */
    c.depth = -1;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_OPEN);
    assert_true(r[0] == 0 && r[1] == 0 && r[2] == 0);
    /* no friction coefficient: nothing sideways */
    c = plain_contact(PINCH_CONTACT_HARD);
    c.elastic[0] = 1e-3;
    c.friction[0] = c.friction[1] = 0;
    evaluate(&c, 1e-3, (double[4]){0}, r);
    assert_true(r[0] > 0 && r[1] == 0 && r[2] == 0);
    /* unlimited friction sticks always */
    c.friction[0] = c.friction[1] = INFINITY;
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_STICK);
    assert_close(r[1], -5, ROUNDING);
}

static void test_torsion(void **state)
{
    (void)state;
    pinch_contact c = plain_contact(PINCH_CONTACT_SOFT);
    double r[4];
    c.elastic[2] = 0.02; /* -ktau theta = -0.04 N m; limit 0.01 m * 10 N */
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_STICK);
    assert_close(r[3], -0.04, ROUNDING);
    c.elastic[2] = 0.2; /* trial -0.4 N m: pure torsion slips at the limit */
    assert_int_equal(evaluate(&c, 1e-3, (double[4]){0}, r), PINCH_CONTACT_SLIP);
    assert_close(r[3], -0.1, ROUNDING);
    /* combined: on the ellipse */
    c.elastic[0] = 1e-3;
    evaluate(&c, 1e-3, (double[4]){0}, r);
    assert_close(hypot(r[1] / 5, r[3] / 0.1), 1, 1e-12); /* the projection's root is found to 1e-12 or better */
    assert_true(r[1] < 0 && r[3] < 0);
}

static pinch_contact random_contact(pinch_random *random, pinch_contact_model model)
{
    pinch_contact c;
    memset(&c, 0, sizeof c);
    c.model = model;
    double load = draw_log_uniform(random, 0.01, 100);
    for (int i = 0; i < 3; i++) {
        c.stiffness[i] = draw_log_uniform(random, 1e2, 1e6) * (i == 2 ? 1e-5 : 1);
        c.damping[i] = c.stiffness[i] * draw_log_uniform(random, 1e-4, 1e-2);
    }
    c.depth = load / c.stiffness[0];
    c.friction[0] = draw_uniform(random, 0.05, 1.2);
    c.friction[1] = draw_chance(random, 0.5) ? c.friction[0] : draw_uniform(random, 0.05, 1.2);
    c.torsional_friction = draw_log_uniform(random, 1e-4, 1e-2);
    for (int i = 0; i < 2; i++) c.elastic[i] = draw_uniform(random, -2, 2) * c.friction[0] * load / c.stiffness[1];
    c.elastic[2] = draw_uniform(random, -2, 2) * c.torsional_friction * load / c.stiffness[2];
    c.max_force = draw_chance(random, 0.3) ? load * draw_uniform(random, 0.3, 2) : INFINITY;
    return c;
}

/* Inside one branch the law is smooth: central differences with a step d err by about d^2 times the third derivative
 * and rounding over d. Both stay below 1e-5 of the tangent's size at d = 1e-5 of the velocity that unloads. */
static void test_tangent_by_differences(void **state)
{
    (void)state;
    static const pinch_contact_model models[3] = {PINCH_CONTACT_FRICTIONLESS, PINCH_CONTACT_HARD, PINCH_CONTACT_SOFT};
    pinch_random random;
    pinch_random_seed(&random, 11);
    int compared = 0, slipped = 0;
    for (int trial = 0; trial < 3000; trial++) {
        pinch_contact c = random_contact(&random, models[trial % 3]);
        pinch_contact_law law;
        pinch_trial_force force;
        double w[4], r[4], tangent[16], h = draw_log_uniform(&random, 1e-4, 1e-2);
        pinch_contact_law_of(&c, 0, &law);
        pinch_trial_force_of(&c, h, &force);
        for (int i = 0; i < law.rows; i++)
            w[i] = draw_uniform(&random, -0.5, 0.5) * (i == 0 ? force.a[0] : fabs(force.a[i])) / force.g[i];
        pinch_contact_state here = pinch_contact_law_evaluate(&law, &force, w, r, tangent);
        double largest = 0;
        for (int i = 0; i < law.rows; i++) largest = fmax(largest, fabs(tangent[i * law.rows + i]));
        for (int j = 0; j < law.rows; j++) {
            double d = 1e-5 * force.a[0] / force.g[0], up[4], down[4], ahead[4], behind[4];
            if (j > 0) d = 1e-5 * fmax(fabs(force.a[j]), law.friction[j - 1] * r[0]) / force.g[j];
            memcpy(ahead, w, sizeof ahead);
            memcpy(behind, w, sizeof behind);
            ahead[j] += d;
            behind[j] -= d;
            pinch_contact_state after = pinch_contact_law_evaluate(&law, &force, ahead, up, NULL),
                                before = pinch_contact_law_evaluate(&law, &force, behind, down, NULL);
            bool clamp_moves = isfinite(law.high) && (up[0] >= law.high) != (down[0] >= law.high);
            if (after != here || before != here || clamp_moves) continue; /* a kink in between */
            for (int i = 0; i < law.rows; i++) {
                double slope = -(up[i] - down[i]) / (2 * d),
                       size = force.g[i < 3 ? 1 : 3] + force.g[j] * (i < 3 ? 1 : 1e-2);
                if (i == 0) size = force.g[0];
                if (i > 0 && j == 0) size += law.friction[i - 1] * force.g[0];
                if (i > 0 && j > 0)
                    size = sqrt(force.g[i] * force.g[j]) + law.friction[i - 1] / law.friction[j - 1] * force.g[j];
                assert_close(tangent[i * law.rows + j], slope, 1e-5 * size);
            }
            compared++;
        }
        slipped += here == PINCH_CONTACT_SLIP;
    }
    assert_true(compared > 6000 && slipped > 500); /* the test has seen what it is about */
}

/* The projection form of a rolling contact, in a metric that differs from row to row: what moves by a small change of z
 * is what the derivative says, and the moments of rolling lie on their ellipse where they slip. */
static void test_rolling_by_differences(void **state)
{
    (void)state;
    enum { N = PINCH_CONTACT_ROWS_MAX };
    pinch_random random;
    pinch_random_seed(&random, 12);
    int compared = 0, rolled = 0;
    for (int trial = 0; trial < 2000; trial++) {
        pinch_contact c = random_contact(&random, PINCH_CONTACT_ROLLING);
        for (int i = 0; i < 2; i++) c.rolling_friction[i] = draw_log_uniform(&random, 1e-4, 1e-1);
        pinch_contact_law law;
        pinch_contact_law_of(&c, 0, &law);
        double rho[N], z[N], r[N], derivative[N * N], normal = draw_uniform(&random, 0.1, 0.9) * fmin(law.high, 10);
        for (int i = 0; i < N; i++) {
            rho[i] = draw_log_uniform(&random, 1e-2, 1e2);
            z[i] = i == 0 ? normal : draw_uniform(&random, -2, 2) * law.friction[i - 1] * normal;
        }
        pinch_contact_state here = pinch_contact_law_project(&law, rho, z, r, derivative);
        double reach = hypot(r[4] / law.friction[3], r[5] / law.friction[4]) / r[0];
        bool slips = z[4] != r[4] || z[5] != r[5];
        if (slips) assert_close(reach, 1, 1e-9);
        assert_true(slips || reach <= 1);
        rolled += slips;
        for (int j = 0; j < N; j++) {
            double d = 1e-5 * normal * (j == 0 ? 1 : law.friction[j - 1]), up[N], down[N], ahead[N], behind[N];
            memcpy(ahead, z, sizeof ahead);
            memcpy(behind, z, sizeof behind);
            ahead[j] += d;
            behind[j] -= d;
            pinch_contact_state after = pinch_contact_law_project(&law, rho, ahead, up, NULL),
                                before = pinch_contact_law_project(&law, rho, behind, down, NULL);
            bool kink = after != here || before != here;
            for (int i = 1; i < N; i++)
                kink = kink || (ahead[i] == up[i]) != (z[i] == r[i]) || (behind[i] == down[i]) != (z[i] == r[i]);
            for (int i = 0; i < N && !kink; i++) {
                double size = (i == 0 ? 1 : law.friction[i - 1]) * normal / d * 1e-5;
                assert_close(derivative[i * N + j], (up[i] - down[i]) / (2 * d), 1e-4 * size);
            }
            compared += !kink;
        }
    }
    assert_true(compared > 6000 && rolled > 500);
}

/* A body that rises and slides over what it touches: an infinite coefficient gives nothing where nothing presses, in
 * both systems of unknowns and with facets; an infinite limit holds all the same. */
static void test_unlimited_friction_of_what_lifts_off(void **state)
{
    (void)state;
    pinch_step_solver *solver;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    for (int kind = 0; kind < 5; kind++) {
        bool limit = kind == 4;
        pinch_body body = {.mass = 1, .inertia = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .radius = 0.1, .velocity = {1, 0, 0.5}};
        pinch_contact c = plain_contact(PINCH_CONTACT_HARD);
        c.body2 = PINCH_STATIC_BODY;
        c.normal[2] = c.tangent1[0] = 1;
        c.friction[0] = c.friction[1] = limit ? 0 : INFINITY;
        c.friction_limit[0] = c.friction_limit[1] = limit ? INFINITY : 0;
        c.may_soften = kind == 1;
        if (kind == 2) {
            c.model = PINCH_CONTACT_ROLLING;
            c.torsional_friction = c.rolling_friction[0] = c.rolling_friction[1] = INFINITY;
        }
        pinch_problem problem = {.step = 1e-2, .bodies = &body, .body_count = 1, .contacts = &c, .contact_count = 1};
        problem.faces = kind == 3 ? 8 : 0;
        pinch_solver_settings settings = pinch_default_solver_settings();
        pinch_step_result result;
        assert_int_equal(pinch_step_solve(solver, &problem, &settings, &result), PINCH_OK);
        assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
        assert_true(c.force[0] == 0 && body.velocity_end[2] == 0.5);
        assert_true(limit ? c.force[1] < -1 : c.force[1] == 0 && body.velocity_end[0] == 1);
    }
    pinch_step_solver_destroy(solver);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normal_law),
        cmocka_unit_test(test_friction_disc),
        cmocka_unit_test(test_unlimited_friction_of_what_lifts_off),
        cmocka_unit_test(test_torsion),
        cmocka_unit_test(test_tangent_by_differences),
        cmocka_unit_test(test_rolling_by_differences),
    };
    return cmocka_run_group_tests_name("contact law", tests, NULL, NULL);
}
