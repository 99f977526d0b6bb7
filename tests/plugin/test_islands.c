/*
 * Checks what comparisons need of the plugin: reading the islands of a solved step, cold starts, fewer manifold points,
 * and ODE's own stepper on Pinch's manifolds.
 */
#include "support/cmocka_all.h"

#include "support/block.h"

#include <math.h>
#include <string.h>

static const double STEP = 1e-3;

/* A block whose plugin was made with `settings`. */
static void make_with(block *b, const pinch_ode_settings *settings)
{
    pinch_material m = pinch_default_material();
    m.damping[0] = 60;
    m.damping[1] = 40;
    block_make(b, NULL, 0);
    pinch_ode_destroy(b->plugin);
    assert_int_equal(pinch_ode_create(b->world, settings, &b->plugin), PINCH_OK);
    assert_int_equal(pinch_ode_set_material(b->plugin, b->table, &m), PINCH_OK);
}

/* Between solve and advance the islands are those of the step, with its answer; at other times there are none. */
static void test_islands_of_a_solved_step(void **state)
{
    (void)state;
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_problem problem;
    int places[16];
    block b;
    settings.keep_islands = true;
    make_with(&b, &settings);
    block_steps(&b, 50);
    assert_int_equal(pinch_ode_island_count(b.plugin), 0);
    assert_int_equal(pinch_ode_read_island(b.plugin, 0, &problem, places), PINCH_INVALID_ARGUMENT);
    block_hand_over(&b, false);
    assert_int_equal(pinch_ode_solve(b.plugin, STEP), PINCH_OK);
    assert_int_equal(pinch_ode_island_count(b.plugin), 1);
    assert_int_equal(pinch_ode_read_island(b.plugin, 1, &problem, places), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_read_island(b.plugin, 0, &problem, places), PINCH_OK);
    const pinch_ode_contact *list;
    int count;
    double momentum = 0;
    assert_int_equal(pinch_ode_contacts(b.plugin, &list, &count), PINCH_OK);
    assert_int_equal(problem.contact_count, count);
    assert_int_equal(problem.body_count, 1);
    assert_true(problem.step == STEP && problem.bodies[0].mass == 0.1);
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *c = &list[places[k]];
        assert_memory_equal(problem.contacts[k].position, c->position, sizeof c->position);
        assert_true(problem.contacts[k].force[0] == c->normal_force);
        momentum += STEP * c->force[2] * (c->body1 == b.body ? 1 : -1);
    }
    /* m (v+ - v*) is what the contacts gave */
    assert_close(0.1 * (problem.bodies[0].velocity_end[2] - problem.bodies[0].velocity[2]), momentum, 1e-15);
    assert_int_equal(pinch_ode_advance(b.plugin, STEP), PINCH_OK);
    assert_int_equal(pinch_ode_island_count(b.plugin), 0);
    block_free(&b);
}

static void add_start(void *context, int iteration, double residual)
{
    if (iteration == 0) *(double *)context += residual;
}

/* From a cold start the answers are the same, to the solver's tolerance, step by step; the solves start farther off. */
static void test_cold_start(void **state)
{
    (void)state;
    pinch_ode_settings settings = pinch_ode_default_settings();
    block warm, cold;
    double starts[2] = {0, 0};
    settings.solver.progress = add_start;
    settings.solver.progress_context = &starts[0];
    make_with(&warm, &settings);
    settings.cold_start = true;
    settings.solver.progress_context = &starts[1];
    make_with(&cold, &settings);
    for (int k = 0; k < 300; k++) {
        dBodyAddForce(warm.body, 0.2, 0.1, 0);
        dBodyAddForce(cold.body, 0.2, 0.1, 0);
        block_step(&warm, STEP);
        block_step(&cold, STEP);
        for (int i = 0; i < 3; i++) assert_close(dBodyGetPosition(warm.body)[i], dBodyGetPosition(cold.body)[i], 1e-12);
    }
    assert_true(starts[1] > 10 * starts[0]);
    block_free(&warm);
    block_free(&cold);
}

/* Where the solver fails, the island shows the forces that it ended with and says so, and ODE carries the block. Where
 * it fails again and again, it is not tried in each step. */
static void test_an_island_without_an_answer(void **state)
{
    (void)state;
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_ode_outcome outcome;
    pinch_problem problem;
    int places[16], left = 0, untried = 0;
    double pressed = 0;
    block b;
    settings.keep_islands = true;
    settings.solver.max_iterations = 1; /* enough where the states of the contacts stay, and not else */
    make_with(&b, &settings);
    dBodySetLinearVel(b.body, 0.3, 0.1, 0);
    dBodySetAngularVel(b.body, 0.3, 0.2, 1);
    for (int k = 0; k < 50; k++) {
        block_hand_over(&b, false);
        assert_int_equal(pinch_ode_solve(b.plugin, STEP), PINCH_OK);
        for (int i = 0; i < pinch_ode_island_count(b.plugin); i++) {
            assert_int_equal(pinch_ode_read_island(b.plugin, i, &problem, places), PINCH_OK);
            assert_int_equal(pinch_ode_read_outcome(b.plugin, i, &outcome), PINCH_OK);
            bool converged = outcome.tried && outcome.result.solve.status == PINCH_SOLVE_CONVERGED;
            assert_true(!outcome.asleep && outcome.solved == converged);
            left += !outcome.solved;
            untried += !outcome.tried;
            for (int c = 0; c < problem.contact_count; c++) {
                for (int j = 0; j < 4; j++) assert_true(isfinite(problem.contacts[c].force[j]));
                if (!outcome.solved) pressed = fmax(pressed, problem.contacts[c].force[0]);
            }
            for (int j = 0; j < 6; j++) assert_true(isfinite(problem.bodies[0].velocity_end[j]));
        }
        assert_int_equal(pinch_ode_read_outcome(b.plugin, 9, &outcome), PINCH_INVALID_ARGUMENT);
        assert_int_equal(pinch_ode_advance(b.plugin, STEP), PINCH_OK);
        assert_int_equal(pinch_ode_read_outcome(b.plugin, 0, &outcome), PINCH_INVALID_ARGUMENT);
    }
    assert_int_equal(left, pinch_ode_statistics(b.plugin).fallback_islands);
    assert_true(left > 0 && pressed > 0);
    assert_true((untried > 0) == (pinch_ode_statistics(b.plugin).backoffs > 0));
    block_free(&b);
}

/* Puts another block onto the table. */
static block another_block(const block *b)
{
    block other = *b;
    dMass mass;
    other.body = dBodyCreate(b->world);
    other.cube = dCreateBox(NULL, 0.04, 0.04, 0.04);
    dGeomSetBody(other.cube, other.body);
    dMassSetBoxTotal(&mass, 0.1, 0.04, 0.04, 0.04);
    dBodySetMass(other.body, &mass);
    dBodySetPosition(other.body, 0.2, 0, 0.0199);
    return other;
}

/* One of two blocks is thrown about, so that a single iteration is not enough for it. The spans for which it is left to
 * ODE without a try double, and the other block is solved in every step. When it lies still, it is solved again. */
static void test_backoff_of_one_island(void **state)
{
    (void)state;
    enum { SETTLING = 300, STEPS = 400, LIES = 0, THROWN = 1 };
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_ode_outcome outcome;
    long longest = 0, span = 0, tries = 0;
    block b;
    settings.solver.max_iterations = 1;
    make_with(&b, &settings);
    block other = another_block(&b);
    for (int k = -SETTLING; k < STEPS; k++) {
        if (k >= 0) dBodySetLinearVel(b.body, k % 2 ? 0.3 : -0.3, 0.1 * (k % 3), -0.1);
        if (k >= 0) dBodySetAngularVel(b.body, 2 - k % 5, 1, 3 * (k % 2) - 1);
        block_hand_over(&b, false);
        block_hand_over(&other, false);
        assert_int_equal(pinch_ode_solve(b.plugin, STEP), PINCH_OK);
        if (k >= 0) {
            assert_int_equal(pinch_ode_island_count(b.plugin), 2);
            assert_int_equal(pinch_ode_read_outcome(b.plugin, LIES, &outcome), PINCH_OK);
            assert_true(outcome.solved);
            assert_int_equal(pinch_ode_read_outcome(b.plugin, THROWN, &outcome), PINCH_OK);
            span = outcome.tried ? 0 : span + 1;
            longest = span > longest ? span : longest;
            tries += outcome.tried;
        }
        assert_int_equal(pinch_ode_advance(b.plugin, STEP), PINCH_OK);
        if (k >= 0) dBodySetPosition(b.body, 0, 0, 0.0195);
    }
    assert_true(longest >= 32 && tries >= 3 && tries < STEPS / 4);
    assert_true(pinch_ode_statistics(b.plugin).backoffs >= 3);
    for (int k = 0; k < 8 * STEPS; k++) {
        block_hand_over(&b, false);
        block_hand_over(&other, false);
        assert_int_equal(pinch_ode_solve(b.plugin, STEP), PINCH_OK);
        assert_int_equal(pinch_ode_read_outcome(b.plugin, THROWN, &outcome), PINCH_OK);
        assert_int_equal(pinch_ode_advance(b.plugin, STEP), PINCH_OK);
    }
    assert_true(outcome.solved);
    dGeomDestroy(other.cube);
    block_free(&b);
}

static void test_manifold_points(void **state)
{
    (void)state;
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_ode *other;
    block b;
    for (int points = 1; points <= 4; points++) {
        const pinch_ode_contact *list;
        int count;
        settings.manifold_points = points;
        make_with(&b, &settings);
        dBodySetAngularVel(b.body, 0.3, 0.2, 0.1);
        for (int k = 0; k < 20; k++) {
            block_step(&b, STEP);
            assert_int_equal(pinch_ode_contacts(b.plugin, &list, &count), PINCH_OK);
            assert_true(count <= points);
        }
        block_free(&b);
    }
    block_make(&b, NULL, 0);
    settings.manifold_points = 0;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    settings.manifold_points = 9;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    block_free(&b);
}

/* ODE solves the manifold's points: the block rests on all of its weight, and goes with a table that moves. */
static void test_ode_solves(void **state)
{
    (void)state;
    static const pinch_ode_stepper steppers[] = {PINCH_ODE_WORLDSTEP, PINCH_ODE_QUICKSTEP};
    for (int i = 0; i < 2; i++) {
        pinch_ode_settings settings = pinch_ode_default_settings();
        settings.ode_solves = true;
        settings.stepper = steppers[i];
        block b;
        make_with(&b, &settings);
        dBodyID table = dBodyCreate(b.world);
        dBodySetPosition(table, 0, 0, -0.5);
        dBodySetKinematic(table);
        dGeomSetBody(b.table, table);
        block_steps(&b, 500);
        assert_close(block_normal_force(&b), 1, 1e-6);
        assert_int_equal(pinch_ode_statistics(b.plugin).contacts_solved, 0);
        dBodySetLinearVel(table, 0.05, 0, 0);
        block_steps(&b, 200);
        assert_close(dBodyGetLinearVel(b.body)[0], 0.05, 1e-3);
        block_free(&b);
    }
}

/* A step that is refused because of one island leaves the bodies of the others as they were, and the next one goes on.
 */
static void test_a_refused_step(void **state)
{
    (void)state;
    pinch_ode_settings settings = pinch_ode_default_settings();
    block b;
    make_with(&b, &settings);
    block_steps(&b, 500);
    block other = another_block(&b);

    dBodySetForce(b.body, 0.01, 0, 0);
    dBodySetForce(other.body, INFINITY, 0, 0);
    block_hand_over(&b, false);
    block_hand_over(&other, false);
    assert_int_equal(pinch_ode_step(b.plugin, STEP), PINCH_INVALID_ARGUMENT);
    const double *force = dBodyGetForce(b.body), *torque = dBodyGetTorque(b.body);
    assert_true(force[0] == 0.01 && force[1] == 0 && force[2] == 0);
    for (int i = 0; i < 3; i++) assert_true(torque[i] == 0);

    dBodySetForce(other.body, 0, 0, 0);
    block_hand_over(&b, false);
    block_hand_over(&other, false);
    assert_int_equal(pinch_ode_step(b.plugin, STEP), PINCH_OK);
    assert_true(fabs(dBodyGetLinearVel(b.body)[2]) < 1e-6);
    dGeomDestroy(other.cube);
    block_free(&b);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_islands_of_a_solved_step),
        cmocka_unit_test(test_cold_start),
        cmocka_unit_test(test_an_island_without_an_answer),
        cmocka_unit_test(test_backoff_of_one_island),
        cmocka_unit_test(test_manifold_points),
        cmocka_unit_test(test_ode_solves),
        cmocka_unit_test(test_a_refused_step),
    };
    int failed = cmocka_run_group_tests_name("islands", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
