/* Islands of joints without contacts, which a program hands over by their bodies: who solves them, and how well. */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <math.h>
#include <string.h>

enum { MOST_BODIES = 32 };
static const double STEP = 0.005;

/* Rods that hang from the world, one from the other. */
typedef struct chain {
    dWorldID world;
    pinch_ode *plugin; /* NULL: ODE alone */
    dBodyID body[MOST_BODIES];
    dJointID joint[MOST_BODIES + 1];
    int bodies, joints;
} chain;

static void make(chain *c, int bodies, bool with_pinch, pinch_ode_stepper stepper)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    dMass mass;
    memset(c, 0, sizeof *c);
    settings.stepper = stepper;
    c->world = dWorldCreate();
    dWorldSetGravity(c->world, 0, 0, -10);
    for (int k = 0; k < bodies; k++) {
        dBodyID body = c->body[c->bodies++] = dBodyCreate(c->world);
        dMassSetBoxTotal(&mass, 0.2 + 0.1 * (k % 3), 0.2, 0.03, 0.03);
        dBodySetMass(body, &mass);
        dBodySetPosition(body, 0.1 + 0.2 * k, 0, 0);
        dJointID joint = c->joint[c->joints++] = dJointCreateHinge(c->world, NULL);
        dJointAttach(joint, body, k > 0 ? c->body[k - 1] : NULL);
        dJointSetHingeAnchor(joint, 0.2 * k, 0, 0);
        dJointSetHingeAxis(joint, 0, 1, 0);
    }
    if (with_pinch) assert_int_equal(pinch_ode_create(c->world, &settings, &c->plugin), PINCH_OK);
    for (int k = 0; k < c->joints && with_pinch; k++)
        assert_int_equal(pinch_ode_note_joint(c->plugin, c->joint[k]), PINCH_OK);
}

static void steps(chain *c, int count, pinch_ode_stepper stepper)
{
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < c->bodies && c->plugin; k++)
            assert_int_equal(pinch_ode_add_body(c->plugin, c->body[k]), PINCH_OK);
        if (c->plugin)
            assert_int_equal(pinch_ode_step(c->plugin, STEP), PINCH_OK);
        else if (stepper == PINCH_ODE_QUICKSTEP)
            dWorldQuickStep(c->world, STEP);
        else
            dWorldStep(c->world, STEP);
    }
}

static void destroy(chain *c)
{
    pinch_ode_destroy(c->plugin);
    dWorldDestroy(c->world);
}

/* The widest gap of all hinges, m. */
static double gap(const chain *c)
{
    double most = 0;
    for (int k = 0; k < c->joints; k++) {
        dVector3 a, b;
        dJointGetHingeAnchor(c->joint[k], a);
        dJointGetHingeAnchor2(c->joint[k], b);
        most = fmax(most, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
    }
    return most;
}

/* Ties the chain's end to the world, in line: a loop whose hinges say three things twice. */
static void close_loop(chain *c)
{
    dJointID joint = c->joint[c->joints++] = dJointCreateHinge(c->world, NULL);
    dJointAttach(joint, c->body[c->bodies - 1], NULL);
    dJointSetHingeAnchor(joint, 0.2 * c->bodies, 0, 0);
    dJointSetHingeAxis(joint, 0, 1, 0);
    if (c->plugin) assert_int_equal(pinch_ode_note_joint(c->plugin, joint), PINCH_OK);
}

/* Under quickstep, what swings is solved and verified: joints hold as under worldstep. */
static void swinging(void **state)
{
    (void)state;
    chain ours, quick, exact;
    make(&ours, 8, true, PINCH_ODE_QUICKSTEP);
    make(&quick, 8, false, PINCH_ODE_QUICKSTEP);
    make(&exact, 8, false, PINCH_ODE_WORLDSTEP);
    steps(&ours, 200, PINCH_ODE_QUICKSTEP);
    steps(&quick, 200, PINCH_ODE_QUICKSTEP);
    steps(&exact, 200, PINCH_ODE_WORLDSTEP);
    pinch_ode_stats stats = pinch_ode_statistics(ours.plugin);
    assert_int_equal(stats.joints_solved, 200 * 8);
    assert_true(stats.joints_left == 0 && stats.fallback_islands == 0 && stats.unconverged_steps == 0);
    assert_true(stats.step_mismatch < 1e-12);
    assert_close(gap(&ours), gap(&exact), 1e-3 * gap(&exact)); /* which integration leaves */
    assert_true(gap(&ours) < gap(&quick));
    for (int k = 0; k < 8; k++) /* the world's CFM, which Pinch takes for rounding, moves them apart */
        for (int i = 0; i < 3; i++)
            assert_close(dBodyGetPosition(ours.body[k])[i], dBodyGetPosition(exact.body[k])[i], 1e-5);
    destroy(&ours);
    destroy(&quick);
    destroy(&exact);
}

/* A closed loop with redundant rows, held up by a motor that is too weak, and by one that is not. */
static void limited_motors_in_a_loop(void **state)
{
    (void)state;
    for (int strong = 0; strong < 2; strong++) {
        chain c;
        make(&c, 4, true, PINCH_ODE_QUICKSTEP);
        close_loop(&c);
        dJointSetHingeParam(c.joint[1], dParamVel, 0);
        dJointSetHingeParam(c.joint[1], dParamFMax, strong ? 100 : 1e-3);
        dBodyAddForce(c.body[1], 0, 0, -1);
        steps(&c, 400, PINCH_ODE_QUICKSTEP);
        pinch_ode_stats stats = pinch_ode_statistics(c.plugin);
        assert_int_equal(stats.fallback_islands, 0);
        assert_true(stats.joints_solved == 400 * 5 && stats.step_mismatch < 1e-12);
        assert_true(gap(&c) < 1e-5); /* it starts in line, where rows hardly hold along it */
        destroy(&c);
    }
}

/* Under worldstep, a few joints are ODE's to the bit, and many are Pinch's. */
static void worldstep(void **state)
{
    (void)state;
    chain ours, odes, many;
    make(&ours, 8, true, PINCH_ODE_WORLDSTEP);
    make(&odes, 8, false, PINCH_ODE_WORLDSTEP);
    make(&many, 20, true, PINCH_ODE_WORLDSTEP);
    steps(&ours, 100, PINCH_ODE_WORLDSTEP);
    steps(&odes, 100, PINCH_ODE_WORLDSTEP);
    steps(&many, 100, PINCH_ODE_WORLDSTEP);
    for (int k = 0; k < 8; k++)
        assert_memory_equal(dBodyGetPosition(ours.body[k]), dBodyGetPosition(odes.body[k]), 3 * sizeof(dReal));
    pinch_ode_stats few = pinch_ode_statistics(ours.plugin), stats = pinch_ode_statistics(many.plugin);
    assert_true(few.joints_solved == 0 && few.fallback_islands == 0 && few.islands == 0);
    assert_true(stats.joints_solved == 100 * 20 && stats.fallback_islands == 0 && stats.step_mismatch < 1e-12);
    destroy(&ours);
    destroy(&odes);
    destroy(&many);
}

/* Bodies are handed over for one step. Those without joints, and those that sleep, change nothing. */
static void what_is_handed_over(void **state)
{
    (void)state;
    chain c;
    pinch_ode_outcome outcome;
    make(&c, 3, true, PINCH_ODE_QUICKSTEP);
    dBodyID single = dBodyCreate(c.world);
    assert_int_equal(pinch_ode_add_body(NULL, single), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_add_body(c.plugin, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_add_body(c.plugin, single), PINCH_OK);
    assert_int_equal(pinch_ode_add_body(c.plugin, c.body[1]), PINCH_OK); /* one of an island will do */
    assert_int_equal(pinch_ode_add_body(c.plugin, c.body[1]), PINCH_OK);
    assert_int_equal(pinch_ode_solve(c.plugin, STEP), PINCH_OK);
    assert_int_equal(pinch_ode_add_body(c.plugin, single), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_island_count(c.plugin), 2);
    assert_int_equal(pinch_ode_read_outcome(c.plugin, 0, &outcome), PINCH_OK);
    assert_true(!outcome.solved && !outcome.tried && !outcome.asleep);
    assert_int_equal(pinch_ode_read_outcome(c.plugin, 1, &outcome), PINCH_OK);
    assert_true(outcome.solved);
    assert_int_equal(pinch_ode_advance(c.plugin, STEP), PINCH_OK);
    assert_close(dBodyGetLinearVel(single)[2], -10 * STEP, 1e-12);

    assert_int_equal(pinch_ode_step(c.plugin, STEP), PINCH_OK); /* nothing is handed over */
    for (int k = 0; k < 3; k++) dBodyDisable(c.body[k]);
    steps(&c, 1, PINCH_ODE_QUICKSTEP);
    assert_int_equal(pinch_ode_statistics(c.plugin).islands, 1);
    assert_int_equal(pinch_ode_statistics(c.plugin).fallback_islands, 0);
    destroy(&c);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(swinging),
        cmocka_unit_test(limited_motors_in_a_loop),
        cmocka_unit_test(worldstep),
        cmocka_unit_test(what_is_handed_over),
    };
    int failed = cmocka_run_group_tests_name("islands of joints", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
