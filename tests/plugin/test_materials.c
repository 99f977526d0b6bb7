/* Checks what a material does to a block on a table, and what a change of the material does. */
#include "support/cmocka_all.h"

#include "support/block.h"

static const double WEIGHT = 1; /* N, of the block */

static void test_materials_change_in_mid_run(void **state)
{
    (void)state;
    pinch_material m = block_material();
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

/*
 * Static friction 0.6, kinetic 0.3, weight 1 N: holds 0.55 N, gives way to 0.65 N, then slides with (0.65 - 0.3) N on
 * 0.1 kg; at 0.2 N it slows down, stops, and holds.
 */
static void test_kinetic_friction(void **state)
{
    (void)state;
    pinch_material m = block_material();
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

/* With infinite friction a tip holds without slip, and what has lifted off has a limit of 0, which is a number. */
static void test_infinite_friction(void **state)
{
    (void)state;
    pinch_material m = block_material();
    m.friction = INFINITY;
    block b;
    block_make(&b, &m, WEIGHT / m.stiffness[0]);
    for (int step = 0; step < 100; step++) {
        dBodyAddForceAtRelPos(b.body, 0.9, 0, 0, 0, 0, -0.02);
        block_step(&b, 1e-3);
    }
    int count;
    const pinch_ode_contact *contacts;
    assert_int_equal(pinch_ode_contacts(b.plugin, &contacts, &count), PINCH_OK);
    assert_true(count > 0);
    for (int k = 0; k < count; k++) assert_true(isinf(contacts[k].friction_limit) || contacts[k].normal_force == 0);
    for (int k = 0; k < count; k++) assert_true(contacts[k].state != PINCH_CONTACT_SLIP);
    dBodySetLinearVel(b.body, 0, 0, 1);
    block_step(&b, 1e-4);
    assert_int_equal(pinch_ode_contacts(b.plugin, &contacts, &count), PINCH_OK);
    assert_true(count > 0);
    for (int k = 0; k < count; k++) assert_true(contacts[k].normal_force == 0 && contacts[k].friction_limit == 0);
    block_free(&b);
}

/* Two tips that touch: compliances in series, the smaller friction. */
static void test_two_tips_in_series(void **state)
{
    (void)state;
    pinch_material soft = block_material(), firm = block_material();
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

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_materials_change_in_mid_run),
        cmocka_unit_test(test_kinetic_friction),
        cmocka_unit_test(test_infinite_friction),
        cmocka_unit_test(test_two_tips_in_series),
    };
    int failed = cmocka_run_group_tests_name("materials", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
