/*
 * What the check of a step takes for rounding, and what not: contacts without a load, and fingers of a hand whose
 * distal motors work against dry friction, so that the links before them bear nothing but the rounding of these
 * torques.
 */
#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/island_check.h"

#include "verify/step_check.h"

#include <math.h>
#include <string.h>

enum { LINKS = 6, ROWS_PER_JOINT = 8, FINGERS = 500 };

typedef struct finger {
    pinch_problem problem;
    pinch_body links[LINKS];
    pinch_joint_row rows[LINKS * ROWS_PER_JOINT];
    double force; /* the largest torque of a motor over the radius of the links, N */
} finger;

static void cross3(const double *a, const double *b, double *c)
{
    for (int i = 0; i < 3; i++) c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Adds a row of the joint between a link and the one before it: along `axis` at the anchor, or about it. */
static pinch_joint_row *add_row(finger *f, int link, const double *anchor, const double *axis)
{
    pinch_joint_row *row = &f->rows[f->problem.row_count++];
    double *const j[2] = {row->j1, row->j2};
    memset(row, 0, sizeof *row);
    row->body1 = link;
    row->body2 = link > 0 ? link - 1 : PINCH_STATIC_BODY;
    row->low = -INFINITY;
    row->high = INFINITY;
    for (int side = 0; side < 2; side++) {
        double sign = side ? -1 : 1, arm[3] = {0, 0, 0};
        if (!anchor) {
            for (int i = 0; i < 3; i++) j[side][3 + i] = sign * axis[i];
            continue;
        }
        for (int i = 0; i < 3 && link >= side; i++) arm[i] = anchor[i] - f->links[link - side].position[i];
        cross3(arm, axis, j[side] + 3);
        for (int i = 0; i < 3; i++) {
            j[side][i] = sign * axis[i];
            j[side][3 + i] *= sign;
        }
    }
    return row;
}

/* A hinge with damping, a motor of `torque`, which is always at its bound, and dry friction that can hold it. */
static void add_hinge(finger *f, pinch_random *random, int link, const double *anchor, double torque)
{
    double R[9];
    draw_frame(random, R);
    for (int i = 0; i < 3; i++) add_row(f, link, anchor, (const double[3]){i == 0, i == 1, i == 2});
    add_row(f, link, NULL, R);
    add_row(f, link, NULL, R + 3);
    add_row(f, link, NULL, R + 6)->cfm = draw_uniform(random, 10, 100);
    pinch_joint_row *friction = add_row(f, link, NULL, R + 6), *motor = add_row(f, link, NULL, R + 6);
    friction->low = -2 * torque - 1e-3;
    friction->high = -friction->low;
    motor->low = -torque;
    motor->high = torque;
    motor->rhs = torque > 0 ? 1000 : 0;
}

static void finger_make(finger *f, uint64_t seed)
{
    pinch_random random;
    double anchor[3] = {0, 0, 0};
    pinch_random_seed(&random, seed);
    memset(f, 0, sizeof *f);
    f->problem =
        (pinch_problem){.step = 0.001, .body_count = LINKS, .bodies = f->links, .rows = f->rows, .contacts = NULL};
    for (int k = 0; k < LINKS; k++) {
        pinch_body *b = &f->links[k];
        double way[3], torque = k < LINKS / 2 ? 0 : draw_log_uniform(&random, 1e-3, 0.3);
        draw_direction(&random, way);
        b->mass = draw_log_uniform(&random, 0.01, 0.05);
        b->radius = 0.02;
        for (int i = 0; i < 3; i++) {
            b->position[i] = anchor[i] + 0.015 * way[i];
            b->inertia[4 * i] = 0.4 * b->mass * 4e-4 * draw_uniform(&random, 0.5, 1);
        }
        add_hinge(f, &random, k, anchor, torque);
        for (int i = 0; i < 3; i++) anchor[i] += 0.03 * way[i];
        f->force = fmax(f->force, torque / b->radius);
    }
}

static bool holds(const finger *f, const pinch_step_result *as)
{
    double scratch[11 * LINKS];
    pinch_step_result check = *as;
    return pinch_step_verify(&f->problem, island_settings().tolerance, scratch, &check);
}

static pinch_step_result finger_solve(finger *f)
{
    pinch_solver_settings settings = island_settings();
    pinch_step_result result;
    assert_int_equal(pinch_step_solve(island_solver, &f->problem, &settings, &result), PINCH_OK);
    return result;
}

/* An answer that bears only rounding in some of its bodies is an answer. */
static void test_rounding_of_a_tree(void **state)
{
    (void)state;
    static finger f;
    for (int k = 0; k < draw_count(FINGERS * 10); k++) {
        finger_make(&f, (uint64_t)k + 1);
        pinch_step_result result = finger_solve(&f);
        if (result.solve.status != PINCH_SOLVE_CONVERGED) fail_msg("finger %d: %d", k, (int)result.solve.status);
        assert_true(holds(&f, &result));
    }
}

/* Each body and each force that acts by 1e-7 of the forces is wrong; so is a NaN. */
static void test_small_errors_are_seen(void **state)
{
    (void)state;
    static finger f;
    static const double WRONG = 1e-7;
    for (int k = 0; k < draw_count(FINGERS * 10); k++) {
        finger_make(&f, (uint64_t)k + 1);
        pinch_step_result result = finger_solve(&f);
        for (int b = 0; b < LINKS; b++) {
            pinch_body *link = &f.links[b], before = *link;
            link->velocity_end[k % 3] += WRONG * f.problem.step * f.force / link->mass;
            assert_false(holds(&f, &result));
            *link = before;
            link->velocity_end[3 + k % 3] += WRONG * f.problem.step * f.force * link->radius / link->inertia[0];
            assert_false(holds(&f, &result));
            link->velocity_end[k % 6] = NAN;
            assert_false(holds(&f, &result));
            *link = before;
        }
        for (int r = 0; r < f.problem.row_count; r++) {
            pinch_joint_row *row = &f.rows[r], before = *row;
            row->force += WRONG * (row->j1[0] + row->j1[1] + row->j1[2] == 0 ? 0.02 : 1) * f.force;
            assert_false(holds(&f, &result));
            *row = before;
        }
    }
}

/* Two boxes fall side by side, and touch without a load. Whatever their contact makes of the last bit of their
 * velocities is no force that it misses; what it makes of a larger difference is one. */
static void test_rounding_of_a_contact(void **state)
{
    (void)state;
    const double eps = 2.2e-16, apart[5] = {0, -2 * eps, -4 * eps, -1e-9, -1e-6};
    for (int k = 0; k < 5; k++) {
        pinch_body bodies[2];
        pinch_contact contact = {.body1 = 0, .body2 = 1, .model = PINCH_CONTACT_FRICTIONLESS, .max_force = INFINITY};
        memset(bodies, 0, sizeof bodies);
        for (int b = 0; b < 2; b++) {
            bodies[b].mass = 200;
            for (int i = 0; i < 3; i++) bodies[b].inertia[4 * i] = 200;
            bodies[b].radius = 1;
            bodies[b].position[0] = b == 0 ? 0.5 : -0.5;
            bodies[b].external[2] = -200 * 9.81;
            bodies[b].velocity[2] = bodies[b].velocity_end[2] = -9.81;
        }
        contact.normal[0] = contact.tangent1[1] = 1;
        contact.stiffness[0] = 1e9;
        bodies[0].velocity_end[0] = 9.81 * apart[k];
        pinch_problem problem = {
            .step = 0.001, .body_count = 2, .bodies = bodies, .contact_count = 1, .contacts = &contact};
        double scratch[22];
        pinch_step_result result;
        memset(&result, 0, sizeof result);
        if (pinch_step_verify(&problem, 1e-10, scratch, &result) != (k < 3))
            fail_msg("%g apart: residual %g, law missed by %g N", apart[k], result.residual_max,
                     result.complementarity);
    }
}

/* A body at rest that another one flies away from has nothing but the rounding of their velocities. */
static void test_rounding_of_what_is_at_rest(void **state)
{
    (void)state;
    const double moved[4] = {0, 3e-19, 1e-15, 1e-9};
    for (int k = 0; k < 4; k++) {
        pinch_body bodies[2];
        pinch_contact contact = {.body1 = 0, .body2 = 1, .model = PINCH_CONTACT_FRICTIONLESS, .max_force = INFINITY};
        memset(bodies, 0, sizeof bodies);
        for (int b = 0; b < 2; b++) {
            bodies[b].mass = bodies[b].radius = 1;
            for (int i = 0; i < 3; i++) bodies[b].inertia[4 * i] = 1;
        }
        contact.normal[0] = contact.tangent1[1] = 1;
        contact.stiffness[0] = 1e12;
        bodies[0].velocity[0] = bodies[0].velocity_end[0] = 0.05;
        bodies[1].velocity_end[0] = moved[k];
        pinch_problem problem = {
            .step = 0.001, .body_count = 2, .bodies = bodies, .contact_count = 1, .contacts = &contact};
        double scratch[22];
        pinch_step_result result;
        memset(&result, 0, sizeof result);
        if (pinch_step_verify(&problem, 1e-10, scratch, &result) != (k < 2))
            fail_msg("moves at %g m/s: residual %g", moved[k], result.residual_max);
    }
}

/* A row without bounds that asks for another velocity than it has is not excused by a bound. */
static void test_rows_without_bounds_are_seen(void **state)
{
    (void)state;
    static finger f;
    static const double OTHER = 1e-7; /* m/s or rad/s */
    for (int k = 0; k < draw_count(FINGERS * 10); k++) {
        finger_make(&f, (uint64_t)k + 1);
        pinch_step_result result = finger_solve(&f);
        for (int r = 0; r < f.problem.row_count; r++) {
            pinch_joint_row *row = &f.rows[r], before = *row;
            if (isfinite(row->low)) continue;
            for (int sign = -1; sign <= 1; sign += 2) {
                row->rhs += sign * OTHER;
                assert_false(holds(&f, &result));
                *row = before;
            }
        }
        assert_true(holds(&f, &result));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_without_bounds_are_seen), cmocka_unit_test(test_rounding_of_a_tree),
        cmocka_unit_test(test_rounding_of_a_contact),        cmocka_unit_test(test_rounding_of_what_is_at_rest),
        cmocka_unit_test(test_small_errors_are_seen),
    };
    return cmocka_run_group_tests_name("check of a step", tests, island_create_solver, island_destroy_solver);
}
