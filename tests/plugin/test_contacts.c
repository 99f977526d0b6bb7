/* A program hands contacts over in real ODE worlds, and takes them away again. */
#include "support/cmocka_all.h"

#include "support/block.h"

#include <string.h>

static const double WEIGHT = 1; /* N, of the block */

static void assert_same_state(dBodyID a, dBodyID b)
{
    assert_memory_equal(dBodyGetPosition(a), dBodyGetPosition(b), 3 * sizeof(double));
    assert_memory_equal(dBodyGetQuaternion(a), dBodyGetQuaternion(b), 4 * sizeof(double));
    assert_memory_equal(dBodyGetLinearVel(a), dBodyGetLinearVel(b), 3 * sizeof(double));
    assert_memory_equal(dBodyGetAngularVel(a), dBodyGetAngularVel(b), 3 * sizeof(double));
}

static void test_rests_at_its_weight_over_stiffness(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 0);
    block_steps(&b, 2000);
    /* the tip's stiffness counts once, whatever the number of points; equilibrium of a linear spring, to rounding */
    assert_close(0.02 - dBodyGetPosition(b.body)[2], WEIGHT / m.stiffness[0], 1e-6 * WEIGHT / m.stiffness[0]);
    assert_close(block_normal_force(&b), WEIGHT, 1e-9);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_int_equal(stats.steps, 2000);
    assert_int_equal(stats.unconverged_steps, 0);
    assert_int_equal(stats.contacts_left, 0);
    assert_true(stats.points_high_water >= 4 && stats.points_high_water <= 8);
    block_free(&b);
}

/* ODE's spaces hand the geoms of a pair over in either order, and change it between steps. */
static void test_order_of_geoms_does_not_matter(void **state)
{
    (void)state;
    pinch_material m = block_material();
    m.model = PINCH_CONTACT_SOFT;
    block straight, mixed;
    block_make(&straight, &m, 0);
    block_make(&mixed, &m, 0);
    for (int step = 0; step < 400; step++) {
        block_hand_over(&straight, false);
        block_hand_over(&mixed, step % 3 == 1);
        dBodyAddForce(straight.body, 0.2, 0.1, 0);
        dBodyAddForce(mixed.body, 0.2, 0.1, 0);
        assert_int_equal(pinch_ode_step(straight.plugin, 1e-3), PINCH_OK);
        assert_int_equal(pinch_ode_step(mixed.plugin, 1e-3), PINCH_OK);
        assert_same_state(straight.body, mixed.body);
    }
    double force[3];
    block_force(&mixed, force);
    assert_close(force[0], -0.2, 1e-6); /* it sticks, and both tell the same force on the cube */
    block_free(&straight);
    block_free(&mixed);
}

/* A manifold point acts only for pairs that were handed over in this step. */
static void test_what_is_not_handed_over_does_not_act(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 1e-4);
    block_steps(&b, 10);
    dBodySetLinearVel(b.body, 0, 0, 0);
    dBodySetAngularVel(b.body, 0, 0, 0);
    for (int step = 0; step < 5; step++) {
        assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
        assert_close(dBodyGetLinearVel(b.body)[2], -10 * 1e-3 * (step + 1), 1e-15);
        const pinch_ode_contact *list;
        int count;
        assert_int_equal(pinch_ode_contacts(b.plugin, &list, &count), PINCH_OK);
        assert_int_equal(count, 0);
    }
    /* handed over again, the history starts anew: no shear is left from before */
    block_step(&b, 1e-3);
    assert_true(block_normal_force(&b) > 0);
    block_free(&b);
}

static void test_forgotten_geoms_may_be_destroyed(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 1e-4);
    block_steps(&b, 50);
    assert_int_equal(pinch_ode_forget_geom(b.plugin, b.cube), PINCH_OK);
    dGeomDestroy(b.cube);
    b.cube = dCreateSphere(NULL, 0.02); /* often in the same place of memory */
    dGeomSetBody(b.cube, b.body);
    block_steps(&b, 50);
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(b.plugin, &list, &count), PINCH_OK);
    assert_int_equal(count, 1); /* the sphere's one point; the cube's four are gone */

    /* forgotten between hand-over and step: those contacts are gone, too */
    assert_int_equal(block_hand_over(&b, false), 1);
    assert_int_equal(pinch_ode_forget_geom(b.plugin, b.cube), PINCH_OK);
    dGeomDestroy(b.cube);
    b.cube = NULL;
    assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
    assert_int_equal(pinch_ode_contacts(b.plugin, &list, &count), PINCH_OK);
    assert_int_equal(count, 0);

    /* the table's material goes when it is taken away */
    assert_int_equal(pinch_ode_set_material(b.plugin, b.table, NULL), PINCH_OK);
    b.cube = dCreateBox(NULL, 0.04, 0.04, 0.04);
    dGeomSetBody(b.cube, b.body);
    dBodySetPosition(b.body, 0, 0, 0.0199);
    pinch_ode_reset_statistics(b.plugin);
    int left = block_hand_over(&b, false);
    assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_true(left > 0);
    assert_int_equal(stats.contacts_left, left);
    assert_int_equal(stats.contacts_solved, 0);
    block_free(&b);
}

/* A geom that was re-shaped counts with its new size: points merge by the distances of the new shape. */
static void test_forgetting_measures_again(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 1e-4);
    dGeomBoxSetLengths(b.cube, 4, 4, 0.04);
    block_step(&b, 1e-3); /* seen at 4 m: points within 28 cm of each other would merge */
    assert_int_equal(pinch_ode_forget_geom(b.plugin, b.cube), PINCH_OK);
    dGeomBoxSetLengths(b.cube, 0.04, 0.04, 0.04);
    dBodySetPosition(b.body, 0, 0, 0.0199);
    dBodySetLinearVel(b.body, 0, 0, 0);
    dBodySetAngularVel(b.body, 0, 0, 0);
    block_step(&b, 1e-3);
    /* one corner is handed over 1 cm away from where it was: farther than a small cube's points continue one another */
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.geom.g1 = b.cube;
    contact.geom.g2 = b.table;
    contact.geom.depth = 1e-4;
    contact.geom.normal[2] = 1;
    contact.geom.pos[0] = 0.01;
    contact.geom.pos[1] = 0.01;
    const pinch_ode_contact *list;
    int before, after;
    assert_int_equal(pinch_ode_contacts(b.plugin, &list, &before), PINCH_OK);
    assert_int_equal(pinch_ode_add_contact(b.plugin, &contact, b.body, NULL), PINCH_OK);
    assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
    assert_int_equal(pinch_ode_contacts(b.plugin, &list, &after), PINCH_OK);
    assert_int_equal(before, 4);
    assert_int_equal(after, 5);
    block_free(&b);
}

static void test_contacts_of_neither_tip_are_odes(void **state)
{
    (void)state;
    block b;
    block_make(&b, NULL, 0);
    dWorldSetERP(b.world, 0.2);
    dWorldSetCFM(b.world, 1e-5);
    block_steps(&b, 1000);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_true(stats.contacts_left >= 3 * 900);
    assert_int_equal(stats.contacts_solved, 0);
    assert_close(dBodyGetLinearVel(b.body)[2], 0, 1e-9); /* ODE holds it */
    assert_true(fabs(dBodyGetPosition(b.body)[2] - 0.02) < 1e-3);
    block_free(&b);
}

/* Two worlds that take turns do what each does alone. */
static void test_worlds_are_independent(void **state)
{
    (void)state;
    pinch_material m = block_material(), n = m;
    n.stiffness[0] = 1e3;
    block alone, a, b;
    block_make(&alone, &m, 0);
    block_steps(&alone, 300);
    block_make(&a, &m, 0);
    block_make(&b, &n, 1e-3);
    for (int step = 0; step < 300; step++) {
        block_step(&a, 1e-3);
        block_step(&b, 2e-3);
    }
    assert_same_state(alone.body, a.body);
    block_free(&alone);
    block_free(&a);
    block_free(&b);
}

/* The length of a step may change: what rests goes on resting. */
static void test_changing_steps(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 0);
    block_steps(&b, 3000);
    double z = dBodyGetPosition(b.body)[2];
    static const double steps[] = {1e-3, 3e-4, 2e-3, 5e-3, 1e-4};
    for (int i = 0; i < 500; i++) block_step(&b, steps[i % 5]);
    assert_close(dBodyGetPosition(b.body)[2], z, 1e-10);
    assert_close(dBodyGetLinearVel(b.body)[2], 0, 1e-9);
    block_free(&b);
}

/* As in ODE, a body that sleeps on something static sleeps on, whatever presses it. */
static void test_sleepers_sleep_on(void **state)
{
    (void)state;
    pinch_material m = block_material();
    block b;
    block_make(&b, &m, 5e-4);
    dBodyDisable(b.body);
    double z = dBodyGetPosition(b.body)[2];
    block_steps(&b, 5);
    assert_false(dBodyIsEnabled(b.body));
    assert_true(dBodyGetPosition(b.body)[2] == z);
    dBodyEnable(b.body);
    block_steps(&b, 5);
    assert_true(dBodyGetLinearVel(b.body)[2] > 0); /* 10 N against 1 N push it out */
    block_free(&b);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rests_at_its_weight_over_stiffness),
        cmocka_unit_test(test_order_of_geoms_does_not_matter),
        cmocka_unit_test(test_what_is_not_handed_over_does_not_act),
        cmocka_unit_test(test_forgotten_geoms_may_be_destroyed),
        cmocka_unit_test(test_forgetting_measures_again),
        cmocka_unit_test(test_contacts_of_neither_tip_are_odes),
        cmocka_unit_test(test_worlds_are_independent),
        cmocka_unit_test(test_changing_steps),
        cmocka_unit_test(test_sleepers_sleep_on),
    };
    int failed = cmocka_run_group_tests_name("contacts in ODE worlds", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
