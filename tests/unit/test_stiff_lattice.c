/*
 * Hundreds of balls with stiff contacts are packed in a cube. They are so well connected that complete factors of the
 * linear systems would fill in, and these are solved by iteration.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <math.h>
#include <pinch/problem.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 6, BALLS = SIDE * SIDE * SIDE, TOUCHES = 3 * SIDE * SIDE * (SIDE - 1) + SIDE * SIDE };
static const double RADIUS = 0.1, OVERLAP = 1e-4, GRAVITY = 9.81, STEP = 0.01;

typedef struct lattice {
    pinch_body bodies[BALLS];
    pinch_contact contacts[TOUCHES];
    pinch_problem problem;
} lattice;

/* ODE's defaults, ERP 0.2 and CFM 1e-5, with as stiff tangents. */
static void touch(lattice *l, int above, int below, int axis)
{
    pinch_contact *c = &l->contacts[l->problem.contact_count++];
    c->body1 = above;
    c->body2 = below;
    c->model = PINCH_CONTACT_HARD;
    memcpy(c->position, l->bodies[above].position, sizeof c->position);
    c->position[axis] -= RADIUS - 0.5 * OVERLAP;
    c->normal[axis] = 1;
    c->tangent1[(axis + 1) % 3] = 1;
    c->depth = OVERLAP;
    for (int i = 0; i < 3; i++) {
        c->stiffness[i] = 0.2 / (STEP * 1e-5);
        c->damping[i] = 0.8 / 1e-5;
    }
    c->friction[0] = c->friction[1] = 0.3;
    c->max_force = INFINITY;
    c->may_soften = true;
}

/* At rest but for a shove of each ball and gravity. */
static lattice *pack(uint64_t seed)
{
    static const int stride[3] = {1, SIDE, SIDE * SIDE};
    lattice *l = calloc(1, sizeof *l);
    assert_non_null(l);
    pinch_random random;
    pinch_random_seed(&random, seed);
    for (int b = 0; b < BALLS; b++) {
        pinch_body *body = &l->bodies[b];
        body->mass = draw_uniform(&random, 0.5, 2);
        body->radius = RADIUS;
        for (int i = 0; i < 3; i++) {
            body->inertia[4 * i] = 0.4 * body->mass * RADIUS * RADIUS;
            body->position[i] = b / stride[i] % SIDE * (2 * RADIUS - OVERLAP);
            body->velocity[i] = draw_uniform(&random, -0.05, 0.05);
        }
        body->velocity[2] -= STEP * GRAVITY;
    }
    for (int b = 0; b < BALLS; b++)
        for (int axis = 0; axis < 3; axis++) {
            if (b / stride[axis] % SIDE > 0)
                touch(l, b, b - stride[axis], axis);
            else if (axis == 2)
                touch(l, b, PINCH_STATIC_BODY, axis);
        }
    l->problem.step = STEP;
    l->problem.body_count = BALLS;
    l->problem.bodies = l->bodies;
    l->problem.contacts = l->contacts;
    return l;
}

static pinch_step_result solve(lattice *l)
{
    pinch_step_solver *solver;
    pinch_step_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    assert_int_equal(pinch_step_solve(solver, &l->problem, &settings, &result), PINCH_OK);
    pinch_step_solver_destroy(solver);
    return result;
}

/* All momentum comes from the ground, and no friction exceeds its limit. */
static void check_forces(const lattice *l)
{
    double momentum[3] = {0}, ground[3] = {0}, size = 0;
    for (int b = 0; b < BALLS; b++)
        for (int i = 0; i < 3; i++)
            momentum[i] += l->bodies[b].mass * (l->bodies[b].velocity_end[i] - l->bodies[b].velocity[i]);
    for (int k = 0; k < l->problem.contact_count; k++) {
        const pinch_contact *c = &l->contacts[k];
        assert_true(c->force[0] >= 0);
        assert_true(hypot(c->force[1], c->force[2]) <= c->friction[0] * c->force[0] * (1 + 1e-12));
        if (c->body2 >= 0) continue;
        ground[2] += STEP * c->force[0]; /* normal z, tangents x and y */
        ground[0] += STEP * c->force[1];
        ground[1] += STEP * c->force[2];
        size += STEP * c->force[0];
    }
    for (int i = 0; i < 3; i++) assert_true(fabs(momentum[i] - ground[i]) <= 1e-12 * size);
}

static void test_large_islands_are_solved(void **state)
{
    (void)state;
    lattice *l = pack(21);
    pinch_step_result result = solve(l);
    assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
    assert_true(result.residual_max <= 1e-10);
    assert_true(result.complementarity <= 1e-9 * result.force_scale);
    assert_true(result.slip_direction <= 1e-9 * result.force_scale);
    check_forces(l);
    int states[4] = {0};
    for (int k = 0; k < l->problem.contact_count; k++) states[l->contacts[k].state]++;
    assert_true(states[PINCH_CONTACT_OPEN] > 50);
    assert_true(states[PINCH_CONTACT_STICK] > 50);
    assert_true(states[PINCH_CONTACT_SLIP] > 50);
    free(l);
}

static void test_the_same_island_has_the_same_answer(void **state)
{
    (void)state;
    lattice *first = pack(22), *second = pack(22);
    (void)solve(first);
    (void)solve(second);
    for (int b = 0; b < BALLS; b++)
        assert_memory_equal(first->bodies[b].velocity_end, second->bodies[b].velocity_end, 6 * sizeof(double));
    free(first);
    free(second);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_large_islands_are_solved),
        cmocka_unit_test(test_the_same_island_has_the_same_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
