/*
 * A gripper whose two fingers are parallelograms: two parallel links each, four hinges in a loop of a plane. In space
 * such a loop has three rows more than it needs. Driven by two servos, or by a motor against a servo, it closes on a
 * box, holds it without creep, keeps its loops closed, and presses with what the drive's torque comes to on the pads.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <pinch/ode.h>
#include <string.h>

enum { FINGERS = 2, LINKS = 2, HINGES = 2 * LINKS };
static const double STEP = 2e-3, GRAVITY = 9.81;
static const double LENGTH = 0.05, SPAN = 0.02, LINK_MASS = 0.02, PAD_MASS = 0.03; /* m, between the links, kg */
static const double TORQUE = 0.25;

typedef struct finger {
    dBodyID link[LINKS], pad;
    dJointID hinge[HINGES]; /* world to link, link to pad, link by link */
    dGeomID tip[2];
} finger;

typedef struct gripper {
    dWorldID world;
    pinch_ode *plugin;
    finger finger[FINGERS];
    dBodyID box;
    dGeomID box_geom;
    bool servo;
} gripper;

static dJointID add_hinge(gripper *g, dBodyID a, dBodyID b, double x, double z)
{
    dJointID j = dJointCreateHinge(g->world, NULL);
    dJointAttach(j, a, b);
    dJointSetHingeAnchor(j, x, 0, z);
    dJointSetHingeAxis(j, 0, 1, 0);
    return j;
}

/* The links hang from the palm at z = 0, the pad from both of them. side: -1 and 1. */
static void add_finger(gripper *g, finger *f, double side)
{
    dMass mass;
    double middle = 0.045 * side;
    f->pad = dBodyCreate(g->world);
    dMassSetBoxTotal(&mass, PAD_MASS, 0.03, 0.03, 0.02);
    dBodySetMass(f->pad, &mass);
    dBodySetPosition(f->pad, middle, 0, -LENGTH);
    for (int l = 0; l < LINKS; l++) {
        double x = middle + SPAN * (l - 0.5);
        f->link[l] = dBodyCreate(g->world);
        dMassSetCapsuleTotal(&mass, LINK_MASS, 3, 0.004, LENGTH);
        dBodySetMass(f->link[l], &mass);
        dBodySetPosition(f->link[l], x, 0, -0.5 * LENGTH);
        f->hinge[2 * l] = add_hinge(g, f->link[l], NULL, x, 0);
        f->hinge[2 * l + 1] = add_hinge(g, f->pad, f->link[l], x, -LENGTH);
    }
    pinch_material material = pinch_default_material();
    for (int t = 0; t < 2; t++) {
        f->tip[t] = dCreateSphere(NULL, 0.008);
        dGeomSetBody(f->tip[t], f->pad);
        dGeomSetOffsetPosition(f->tip[t], -0.012 * side, 0.012 * (2 * t - 1), -0.005);
        assert_int_equal(pinch_ode_set_material(g->plugin, f->tip[t], &material), PINCH_OK);
    }
    if (g->servo || side > 0) { /* two motors at their limits would leave the box free to swing with both fingers */
        pinch_servo servo = {.target = 0.5 * side, .kp = 0.8, .kd = 0.02, .max_force = 5};
        assert_int_equal(pinch_ode_set_servo(g->plugin, f->hinge[0], 0, &servo), PINCH_OK);
        return;
    }
    dJointSetHingeParam(f->hinge[0], dParamFMax, TORQUE);
    dJointSetHingeParam(f->hinge[0], dParamVel, side);
}

static void gripper_make(gripper *g, pinch_ode_stepper stepper, bool servo)
{
    dMass mass;
    memset(g, 0, sizeof *g);
    g->servo = servo;
    g->world = dWorldCreate();
    dWorldSetGravity(g->world, 0, 0, -GRAVITY);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    assert_int_equal(pinch_ode_create(g->world, &settings, &g->plugin), PINCH_OK);
    for (int f = 0; f < FINGERS; f++) add_finger(g, &g->finger[f], 2 * f - 1);
    g->box = dBodyCreate(g->world);
    dMassSetBoxTotal(&mass, 0.1, 0.04, 0.05, 0.04);
    dBodySetMass(g->box, &mass);
    dBodySetPosition(g->box, 0, 0, -LENGTH - 0.005);
    g->box_geom = dCreateBox(NULL, 0.04, 0.05, 0.04);
    dGeomSetBody(g->box_geom, g->box);
}

static void gripper_free(gripper *g)
{
    pinch_ode_destroy(g->plugin);
    dGeomDestroy(g->box_geom);
    for (int f = 0; f < FINGERS; f++)
        for (int t = 0; t < 2; t++) dGeomDestroy(g->finger[f].tip[t]);
    dWorldDestroy(g->world);
}

static void gripper_step(gripper *g)
{
    for (int f = 0; f < FINGERS; f++)
        for (int t = 0; t < 2; t++) {
            dContact contact;
            memset(&contact, 0, sizeof contact);
            if (dCollide(g->box_geom, g->finger[f].tip[t], 1, &contact.geom, sizeof contact.geom) == 1)
                assert_int_equal(pinch_ode_add_contact(g->plugin, &contact, g->box, g->finger[f].pad), PINCH_OK);
        }
    assert_int_equal(pinch_ode_step(g->plugin, STEP), PINCH_OK);
}

/* The largest distance of two anchors that should be one point, m. */
static double loops_open(const gripper *g)
{
    double most = 0;
    for (int f = 0; f < FINGERS; f++)
        for (int j = 0; j < HINGES; j++) {
            dVector3 a, b;
            dJointGetHingeAnchor(g->finger[f].hinge[j], a);
            dJointGetHingeAnchor2(g->finger[f].hinge[j], b);
            for (int i = 0; i < 3; i++) most = fmax(most, fabs(a[i] - b[i]));
        }
    return most;
}

/* What is left of a finger's balance in its one freedom, the swing of the parallelogram: torque, weights and the box's
 * forces on the pad, N m. */
static double swing_balance(const gripper *g, int index)
{
    const pinch_ode_contact *list;
    int count;
    const finger *f = &g->finger[index];
    double torque = TORQUE * (2 * index - 1), position, force[3] = {0};
    if (g->servo || index == 1)
        assert_int_equal(pinch_ode_servo_state(g->plugin, f->hinge[0], 0, &position, &torque), PINCH_OK);
    assert_int_equal(pinch_ode_contacts(g->plugin, &list, &count), PINCH_OK);
    assert_int_equal(count, 4);
    for (int c = 0; c < count; c++)
        for (int i = 0; i < 3; i++)
            force[i] += list[c].body1 == f->pad ? list[c].force[i] : list[c].body2 == f->pad ? -list[c].force[i] : 0;
    double q = dJointGetHingeAngle(f->hinge[0]), weight = (LINK_MASS * LINKS / 2 + PAD_MASS) * GRAVITY;
    return torque - LENGTH * cos(q) * force[0] + LENGTH * sin(q) * (force[2] - weight);
}

static void test_gripper_holds_a_box(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (int servo = 0; servo < 2; servo++) {
            gripper g;
            gripper_make(&g, stepper, servo);
            /* the box floats until it is held */
            dBodySetGravityMode(g.box, 0);
            for (int step = 0; step < (int)(2 / STEP); step++) gripper_step(&g);
            dBodySetGravityMode(g.box, 1);
            for (int step = 0; step < (int)(2 / STEP); step++) gripper_step(&g);
            double before[3], creep = 0;
            memcpy(before, dBodyGetPosition(g.box), sizeof before);
            for (int step = 0; step < (int)(10 / STEP); step++) gripper_step(&g);
            for (int i = 0; i < 3; i++) creep = fmax(creep, fabs(dBodyGetPosition(g.box)[i] - before[i]) / 10);
            pinch_ode_stats stats = pinch_ode_statistics(g.plugin);
            double open = loops_open(&g), off = fmax(fabs(swing_balance(&g, 0)), fabs(swing_balance(&g, 1)));
            bool good = creep <= 1e-12 && open <= 1e-10 && off <= 1e-9 && stats.fallback_islands == 0 &&
                        stats.unconverged_steps == 0 && stats.joints_left == 0 && fabs(before[2] + LENGTH) < 0.02;
            if (!good)
                print_error("stepper %d, servo %d: creep %g m/s, loops open %g m, balance %g N m, %ld fallbacks, %ld "
                            "unconverged, %ld joints left, height %g, at rest %ld of %ld\n",
                            stepper, servo, creep, open, off, stats.fallback_islands, stats.unconverged_steps,
                            stats.joints_left, before[2], stats.islands_at_rest, stats.steps);
            assert_true(good);
            gripper_free(&g);
        }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_gripper_holds_a_box)};
    int failed = cmocka_run_group_tests_name("four-bar gripper", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
