/* A program hands over contacts that are none, and makes calls that are not legal. */
#include "support/cmocka_all.h"

#include "support/block.h"

#include <string.h>

static void test_malformed_contacts_are_skipped_and_counted(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 1e-4);
    dBodyID kinematic = dBodyCreate(b.world);
    dBodySetKinematic(kinematic);
    dContact good;
    memset(&good, 0, sizeof good);
    good.geom.g1 = b.cube;
    good.geom.g2 = b.table;
    good.geom.depth = 1e-4;
    good.geom.normal[2] = 1;
    int bad = 0;
    for (int kind = 0; kind < 10; kind++) {
        dContact c = good;
        dBodyID body1 = b.body, body2 = NULL;
        switch (kind) {
        case 0:
            c.geom.depth = NAN;
            break;
        case 1:
            c.geom.depth = INFINITY;
            break;
        case 2:
            c.geom.normal[2] = 0;
            break;
        case 3:
            c.geom.normal[2] = NAN;
            break;
        case 4:
            c.geom.normal[0] = 1;
            break;
        case 5:
            c.geom.pos[1] = NAN;
            break;
        case 6:
            c.geom.pos[2] = -INFINITY;
            break;
        case 7:
            body2 = body1;
            break;
        case 8:
            body1 = NULL;
            break;
        default:
            body1 = kinematic;
            break;
        }
        assert_int_equal(pinch_ode_add_contact(b.plugin, &c, body1, body2), PINCH_OK);
        bad++;
    }
    assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_int_equal(stats.contacts_malformed, bad);
    assert_int_equal(stats.contacts_solved + stats.contacts_left, 0);
    assert_close(dBodyGetLinearVel(b.body)[2], -0.01, 1e-15); /* nothing acted */
    block_free(&b);
}

static void test_illegal_calls_are_refused(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 1e-4);
    dContact contact;
    memset(&contact, 0, sizeof contact);
    pinch_ode *other = NULL;
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(NULL, &settings, &other), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_create(b.world, NULL, &other), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_create(b.world, &settings, NULL), PINCH_INVALID_ARGUMENT);
    settings.merge_distance = 0;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    settings = pinch_ode_default_settings();
    settings.stale_tilt = NAN;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    settings = pinch_ode_default_settings();
    settings.solver.tolerance = -1;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    for (int wrong = 0; wrong < 6; wrong++) {
        settings = pinch_ode_default_settings();
        if (wrong == 0) settings.solver.budget = -1;
        if (wrong == 1) settings.solver.budget = NAN;
        if (wrong == 2) settings.solver.sweeps = -1;
        if (wrong == 3) settings.solver.tolerance = INFINITY;
        if (wrong >= 4) settings.stepper = (pinch_ode_stepper)(wrong == 4 ? 2 : -1);
        assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_INVALID_ARGUMENT);
    }
    settings = pinch_ode_default_settings();
    settings.solver.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_ode_create(b.world, &settings, &other), PINCH_UNSUPPORTED);
    assert_null(other);

    assert_int_equal(pinch_ode_step(NULL, 1e-3), PINCH_INVALID_ARGUMENT);
    const double steps[] = {0, -1e-3, NAN, INFINITY};
    for (int i = 0; i < 4; i++) assert_int_equal(pinch_ode_step(b.plugin, steps[i]), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_add_contact(b.plugin, NULL, b.body, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(b.plugin, 1e-3), PINCH_INVALID_ARGUMENT); /* nothing solved yet */
    assert_int_equal(pinch_ode_solve(b.plugin, 1e-3), PINCH_OK);
    assert_int_equal(pinch_ode_solve(b.plugin, 1e-3), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_add_contact(b.plugin, &contact, b.body, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(b.plugin, 1e-3), PINCH_OK);
    pinch_ode_destroy(NULL);

    struct {
        size_t offset;
        double value;
    } wrong[] = {
        {offsetof(pinch_material, stiffness), 0},
        {offsetof(pinch_material, stiffness) + sizeof(double), -1},
        {offsetof(pinch_material, stiffness), INFINITY},
        {offsetof(pinch_material, stiffness) + 2 * sizeof(double), 0},
        {offsetof(pinch_material, damping), -1},
        {offsetof(pinch_material, damping) + sizeof(double), NAN},
        {offsetof(pinch_material, friction), NAN},
        {offsetof(pinch_material, friction), -1},
        {offsetof(pinch_material, friction_kinetic), 0.6},
        {offsetof(pinch_material, friction_kinetic), -0.1},
        {offsetof(pinch_material, torsional_friction), -1e-3},
        {offsetof(pinch_material, max_force), 0},
        {offsetof(pinch_material, max_force), NAN},
        {offsetof(pinch_material, facet_axis), NAN},
        {offsetof(pinch_material, facet_axis) + 2 * sizeof(double), INFINITY},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        pinch_material bad = pinch_default_material();
        bad.model = PINCH_CONTACT_SOFT;
        *(double *)(void *)((char *)&bad + wrong[i].offset) = wrong[i].value;
        assert_int_equal(pinch_ode_set_material(b.plugin, b.table, &bad), PINCH_INVALID_ARGUMENT);
    }
    pinch_material bad = pinch_default_material();
    bad.model = (pinch_contact_model)2;
    assert_int_equal(pinch_ode_set_material(b.plugin, b.table, &bad), PINCH_INVALID_ARGUMENT);
    block_steps(&b, 1); /* the good material is still there */
    assert_int_equal(pinch_ode_statistics(b.plugin).contacts_left, 0);
    block_free(&b);
}

/* The forces of a step are for no step of another length; the body moves as if nobody had asked for one. */
static void test_a_step_has_one_length(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b[2];
    for (int k = 0; k < 2; k++) {
        block_make(&b[k], &m, 1e-4);
        block_steps(&b[k], 3);
        assert_int_equal(pinch_ode_solve(b[k].plugin, 1e-3), PINCH_OK);
        static const double others[] = {4e-3, 1e-3 * (1 + 1e-15), 0, -1e-3, NAN, INFINITY};
        for (int i = 0; k == 1 && i < 6; i++)
            assert_int_equal(pinch_ode_advance(b[k].plugin, others[i]), PINCH_INVALID_ARGUMENT);
        assert_int_equal(pinch_ode_advance(b[k].plugin, 1e-3), PINCH_OK);
    }
    assert_memory_equal(dBodyGetPosition(b[0].body), dBodyGetPosition(b[1].body), 3 * sizeof(dReal));
    assert_memory_equal(dBodyGetLinearVel(b[0].body), dBodyGetLinearVel(b[1].body), 3 * sizeof(dReal));
    for (int k = 0; k < 2; k++) block_free(&b[k]);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_malformed_contacts_are_skipped_and_counted),
        cmocka_unit_test(test_illegal_calls_are_refused),
        cmocka_unit_test(test_a_step_has_one_length),
    };
    int failed = cmocka_run_group_tests_name("wrong contacts and calls", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
