/* Contacts in real ODE worlds: what the program hands over, changes, takes away and gets wrong. */
#include "support/cmocka_all.h"

#include "support/block.h"

#include <string.h>

static const double WEIGHT = 1; /* N, of the block */

/* A material whose block settles within a few tenths of a second. */
static pinch_material table_material(void)
{
    pinch_material m = pinch_default_material();
    m.damping[0] = 60;
    m.damping[1] = 40;
    return m;
}

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
    pinch_material m = table_material();
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
    pinch_material m = table_material();
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
    pinch_material m = table_material();
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
    pinch_material m = table_material();
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
    pinch_material m = table_material();
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

static void test_materials_change_in_mid_run(void **state)
{
    (void)state;
    pinch_material m = table_material();
    block b;
    block_make(&b, &m, 0);
    block_steps(&b, 2000);
    m.stiffness[0] *= 2;
    assert_int_equal(pinch_ode_set_material(b.plugin, b.table, &m), PINCH_OK);
    block_steps(&b, 2000);
    assert_close(0.02 - dBodyGetPosition(b.body)[2], WEIGHT / m.stiffness[0], 1e-6 * WEIGHT / m.stiffness[0]);
    /* no friction from one step to the next: it slides as on ice */
    for (int step = 0; step < 300; step++) {
        dBodyAddForce(b.body, 0.3, 0, 0);
        block_step(&b, 1e-3);
    }
    assert_close(dBodyGetLinearVel(b.body)[0], 0, 1e-6);
    m.friction = m.friction_kinetic = 0;
    assert_int_equal(pinch_ode_set_material(b.plugin, b.table, &m), PINCH_OK);
    double start = dBodyGetLinearVel(b.body)[0];
    for (int step = 0; step < 100; step++) {
        dBodyAddForce(b.body, 0.3, 0, 0);
        block_step(&b, 1e-3);
    }
    assert_close(dBodyGetLinearVel(b.body)[0] - start, 0.3 / 0.1 * 0.1, 1e-9); /* F/m t, to rounding */
    block_free(&b);
}

static void test_malformed_contacts_are_skipped_and_counted(void **state)
{
    (void)state;
    pinch_material m = table_material();
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
    for (int kind = 0; kind < 11; kind++) {
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
            c.geom.g1 = NULL;
            break;
        case 8:
            c.geom.g2 = c.geom.g1;
            break;
        case 9:
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
    pinch_material m = table_material();
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

/*
 * Static friction 0.6, kinetic 0.3, weight 1 N: holds 0.55 N, gives way to 0.65 N, then slides with (0.65 - 0.3) N on
 * 0.1 kg; at 0.2 N it slows down, stops, and holds.
 */
static void test_kinetic_friction(void **state)
{
    (void)state;
    pinch_material m = table_material();
    m.friction = 0.6;
    m.friction_kinetic = 0.3;
    block b;
    block_make(&b, &m, WEIGHT / m.stiffness[0]);
    /* pushed at the height of the table, so that the push does not tip it */
    double grip = -0.02;
    for (int step = 0; step < 2000; step++) { /* slowly up to 0.55 N */
        dBodyAddForceAtRelPos(b.body, 0.55 * fmin(1, step / 1000.0), 0, 0, 0, 0, grip);
        block_step(&b, 1e-3);
    }
    assert_close(dBodyGetLinearVel(b.body)[0], 0, 1e-6);
    for (int step = 0; step < 200; step++) {
        dBodyAddForceAtRelPos(b.body, 0.65, 0, 0, 0, 0, grip);
        block_step(&b, 1e-3);
    }
    double before = dBodyGetLinearVel(b.body)[0];
    for (int step = 0; step < 100; step++) {
        dBodyAddForceAtRelPos(b.body, 0.65, 0, 0, 0, 0, grip);
        block_step(&b, 1e-3);
    }
    double gained = dBodyGetLinearVel(b.body)[0] - before;
    assert_true(before > 0.1);
    /* 0.35 N on 0.1 kg over 0.1 s; the rocking that the break-away left changes the weight by less than a percent */
    assert_close(gained, 0.35, 0.0035);
    int until = 0;
    while (dBodyGetLinearVel(b.body)[0] > 1e-4 && until++ < 3000) {
        dBodyAddForceAtRelPos(b.body, 0.2, 0, 0, 0, 0, grip);
        block_step(&b, 1e-3);
    }
    assert_true(until < 3000);
    double speed = 0;
    for (int step = 0; step < 1000; step++) { /* sticks again: 0.4 N, more than kinetic friction, does not move it */
        dBodyAddForceAtRelPos(b.body, 0.2 + 0.2 * fmin(1, step / 500.0), 0, 0, 0, 0, grip);
        block_step(&b, 1e-3);
        if (step > 900) speed = fmax(speed, fabs(dBodyGetLinearVel(b.body)[0]));
    }
    assert_true(speed < 1e-6);
    block_free(&b);
}

/* Two tips that touch: compliances in series, the smaller friction. */
static void test_two_tips_in_series(void **state)
{
    (void)state;
    pinch_material soft = table_material(), firm = table_material();
    soft.friction = soft.friction_kinetic = 0.3;
    firm.stiffness[0] = 6e4;
    firm.stiffness[1] = 3e4;
    firm.friction = firm.friction_kinetic = 0.9;
    block b;
    block_make(&b, &soft, 0);
    assert_int_equal(pinch_ode_set_material(b.plugin, b.cube, &firm), PINCH_OK);
    block_steps(&b, 3000);
    double sink = WEIGHT * (1 / soft.stiffness[0] + 1 / firm.stiffness[0]);
    assert_close(0.02 - dBodyGetPosition(b.body)[2], sink, 1e-6 * sink);
    double x = dBodyGetPosition(b.body)[0];
    for (int step = 0; step < 3000; step++) {
        dBodyAddForceAtRelPos(b.body, 0.25 * fmin(1, step / 1000.0), 0, 0, 0, 0, -0.02);
        block_step(&b, 1e-3);
    }
    double give = 0.25 * (1 / soft.stiffness[1] + 1 / firm.stiffness[1]);
    double tilt = 2 * dBodyGetQuaternion(b.body)[2]; /* about y: moves the centre against the points */
    assert_close(dBodyGetPosition(b.body)[0] - x - 0.02 * tilt, give, 1e-4 * give);
    for (int step = 0; step < 500; step++) {
        dBodyAddForceAtRelPos(b.body, 0.35, 0, 0, 0, 0, -0.02);
        block_step(&b, 1e-3);
    }
    assert_close(dBodyGetLinearVel(b.body)[0], 0.05 / 0.1 * 0.5, 0.01); /* slides at the smaller friction */
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
    pinch_material m = table_material(), n = m;
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
    pinch_material m = table_material();
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
    pinch_material m = table_material();
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
        cmocka_unit_test(test_materials_change_in_mid_run),
        cmocka_unit_test(test_malformed_contacts_are_skipped_and_counted),
        cmocka_unit_test(test_illegal_calls_are_refused),
        cmocka_unit_test(test_kinetic_friction),
        cmocka_unit_test(test_two_tips_in_series),
        cmocka_unit_test(test_contacts_of_neither_tip_are_odes),
        cmocka_unit_test(test_worlds_are_independent),
        cmocka_unit_test(test_changing_steps),
        cmocka_unit_test(test_sleepers_sleep_on),
    };
    int failed = cmocka_run_group_tests_name("contacts in ODE worlds", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
