/*
 * The account of what hard contacts put in as they push bodies out of each other: a lift whose load begins in it
 * carries that load, a platform that hardly moves is ground, and a debt ends with the overlaps that it was for.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

typedef struct scene {
    pinch_ode *plugin;
    dWorldID world;
    dSpaceID space;
    double bounce, erp, cfm;
    bool soft;
    dGeomID softened; /* NULL, or what alone has soft contacts */
} scene;

static scene make_scene(void)
{
    scene s = {.world = dWorldCreate(), .space = dSimpleSpaceCreate(NULL)};
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(s.world, &settings, &s.plugin), PINCH_OK);
    dWorldSetGravity(s.world, 0, 0, -9.81);
    dWorldSetERP(s.world, 0.2);
    dWorldSetCFM(s.world, 0);
    return s;
}

static void destroy(scene *s)
{
    pinch_ode_destroy(s->plugin);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static dBodyID add_body(scene *s, dGeomID geom, double mass, double z)
{
    dMass m;
    dBodyID body = dBodyCreate(s->world);
    dMassSetSphereTotal(&m, mass, 0.1);
    dBodySetMass(body, &m);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, 0, 0, z);
    return body;
}

enum { MOST = 8 };

static void touch(void *context, dGeomID a, dGeomID b)
{
    scene *s = context;
    dContact contact[MOST];
    bool soft = s->soft || (s->softened && (a == s->softened || b == s->softened));
    int count = dCollide(a, b, MOST, &contact[0].geom, sizeof contact[0]);
    for (int k = 0; k < count; k++) {
        memset(&contact[k].surface, 0, sizeof contact[k].surface);
        contact[k].surface.mode = dContactApprox1 | dContactBounce | (soft ? dContactSoftERP | dContactSoftCFM : 0);
        contact[k].surface.mu = 0.5;
        contact[k].surface.bounce = s->bounce;
        contact[k].surface.soft_erp = s->erp;
        contact[k].surface.soft_cfm = s->cfm;
        assert_int_equal(pinch_ode_add_contact(s->plugin, &contact[k], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
    }
}

static void step(scene *s, double h)
{
    dSpaceCollide(s->space, s, touch);
    assert_int_equal(pinch_ode_step(s->plugin, h), PINCH_OK);
}

enum { BOXES = 3 };
static const double SIDE = 0.2;

/* A lift that rises with a stack of boxes, each `overlap` (m) deep in what it lies on: after a second they lie on each
 * other. */
static void carry_a_stack(double speed, double overlap, double h)
{
    scene s = make_scene();
    dGeomID floor = dCreateBox(s.space, 4, 4, 1);
    dBodyID lift = add_body(&s, floor, 1, -0.5), box[BOXES];
    dBodySetKinematic(lift);
    dBodySetLinearVel(lift, 0, 0, speed);
    for (int k = 0; k < BOXES; k++) {
        double side = SIDE - 0.02 * k;
        dGeomID geom = dCreateBox(s.space, side, side, SIDE);
        box[k] = add_body(&s, geom, 1 + k, 0.5 * SIDE + SIDE * k - overlap * (k + 1));
        dBodySetLinearVel(box[k], 0, 0, speed);
    }
    double fastest = 0;
    for (int i = 0; i < (int)(1 / h); i++) {
        step(&s, h);
        for (int k = 0; k < BOXES; k++) fastest = fmax(fastest, fabs(dBodyGetLinearVel(box[k])[2] - speed));
    }
    double top = dBodyGetPosition(lift)[2] + 0.5;
    for (int k = 0; k < BOXES; k++) assert_close(dBodyGetPosition(box[k])[2] - top, 0.5 * SIDE + SIDE * k, 1e-3 * SIDE);
    assert_true(fastest < 1.5); /* m/s: nothing is thrown, as by the 3 m/s of an ERP of 0.2 and 2 ms */
    assert_int_equal(pinch_ode_statistics(s.plugin).unconverged_steps, 0);
    destroy(&s);
}

static void test_a_lift_carries_what_begins_in_it(void **state)
{
    (void)state;
    static const double slow[] = {0, 1e-9, 0.05}, fast[] = {0.2, 0.5, 1.5}, overlaps[] = {0.01, 0.03};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++) {
            carry_a_stack(slow[i], overlaps[k], 1e-3);
            carry_a_stack(slow[i], overlaps[k], 5e-3);
            carry_a_stack(fast[i], overlaps[k], 2e-3);
            carry_a_stack(fast[i], overlaps[k], 5e-3);
        }
}

/* A platform that hardly turns is ground: boxes that begin deep in it come up on it and do not topple. */
static void test_a_platform_that_turns_slowly(void **state)
{
    (void)state;
    enum { MANY = 5 };
    static const double LARGE = 0.4;
    scene s = make_scene();
    dBodyID platform = add_body(&s, dCreateBox(s.space, 6, 6, 1), 1, -0.5), box[MANY];
    dBodySetKinematic(platform);
    dBodySetAngularVel(platform, 0, 1e-3, 0);
    for (int k = 0; k < MANY; k++)
        box[k] = add_body(&s, dCreateBox(s.space, LARGE, LARGE, LARGE), 1, 0.5 * LARGE + 0.8 * LARGE * k - 0.2 * LARGE);
    for (int i = 0; i < 200; i++) step(&s, 0.01);
    for (int k = 0; k < MANY; k++) {
        const double *x = dBodyGetPosition(box[k]);
        assert_close(x[2], LARGE * (0.5 + k), 0.02 * LARGE);
        assert_true(hypot(x[0], x[1]) < 0.2 * LARGE);
    }
    destroy(&s);
}

/* Returns how fast (m/s) a ball leaves the ground that it falls onto from 50 mm, after it was pushed out of a depth (m)
 * at which it began. */
static double leaves_at(double depth, bool soft)
{
    static const double RADIUS = 0.1, STEP = 1e-3;
    scene s = make_scene();
    s.bounce = soft ? 0 : 0.8;
    s.soft = soft;
    s.erp = 0.97;
    s.cfm = 0.03;
    (void)dCreatePlane(s.space, 0, 0, 1, 0);
    dBodyID ball = add_body(&s, dCreateSphere(s.space, RADIUS), 1, RADIUS - depth);
    if (depth > 0)
        for (int i = 0; i < 400 && dBodyGetPosition(ball)[2] < RADIUS; i++) step(&s, STEP);
    dBodySetPosition(ball, 0, 0, RADIUS + 0.05);
    dBodySetLinearVel(ball, 0, 0, 0);
    double fastest = 0;
    for (int i = 0; i < 250; i++) {
        step(&s, STEP);
        fastest = fmax(fastest, dBodyGetLinearVel(ball)[2]);
    }
    destroy(&s);
    return fastest;
}

static void test_a_debt_ends_with_its_overlap(void **state)
{
    (void)state;
    for (int soft = 0; soft < 2; soft++) {
        double fresh = leaves_at(0, soft), after = leaves_at(0.03, soft);
        assert_true(fresh > 0.1);
        assert_close(after, fresh, 1e-6 * fresh);
    }
}

/* Under a load, soft contacts are as deep as their stiffness says, however many lie on each other: nothing that lies
 * still comes up. */
static void test_a_soft_stack_is_as_deep_as_it_should_be(void **state)
{
    (void)state;
    enum { MANY = 6, CONTACTS = 4 };
    static const double STEP = 1e-3, ERP = 0.2, CFM = 0.01;
    scene s = make_scene();
    s.soft = true;
    s.erp = ERP;
    s.cfm = CFM;
    (void)dCreatePlane(s.space, 0, 0, 1, 0);
    dBodyID box[MANY];
    for (int k = 0; k < MANY; k++) box[k] = add_body(&s, dCreateBox(s.space, SIDE, SIDE, SIDE), 1, SIDE * (0.5 + k));
    for (int i = 0; i < 4000; i++) step(&s, STEP);
    double stiffness = CONTACTS * ERP / (STEP * CFM), below = 0;
    for (int k = 0; k < MANY; k++) {
        double height = dBodyGetPosition(box[k])[2] - 0.5 * SIDE;
        assert_close((below - height) / ((MANY - k) * 9.81 / stiffness), 1, 1e-3);
        below = height + SIDE;
    }
    destroy(&s);
}

/* Boxes come out of each other on one that lies on springs: these bear what their law says all the while. */
static void test_springs_keep_their_law_below_what_comes_up(void **state)
{
    (void)state;
    static const double STEP = 1e-3, ERP = 0.2, CFM = 0.01, OVERLAP = 0.004;
    scene s = make_scene();
    s.erp = ERP;
    s.cfm = CFM;
    dGeomID ground = dCreatePlane(s.space, 0, 0, 1, 0);
    dBodyID box[BOXES];
    for (int k = 0; k < BOXES; k++)
        box[k] = add_body(&s, dCreateBox(s.space, SIDE, SIDE, SIDE), 1, SIDE * (0.5 + k) - OVERLAP * k - 5e-4);
    for (int i = 0; i < 60; i++) {
        const pinch_ode_contact *list;
        int count;
        double depth = 0.5 * SIDE - dBodyGetPosition(box[0])[2];
        s.softened = ground;
        step(&s, STEP);
        assert_int_equal(pinch_ode_contacts(s.plugin, &list, &count), PINCH_OK);
        double force = 0, bears = 4 * (ERP * depth / STEP - dBodyGetLinearVel(box[0])[2]) / CFM;
        for (int k = 0; k < count; k++)
            if (list[k].geom1 == ground || list[k].geom2 == ground) force += list[k].normal_force;
        assert_close(force, fmax(bears, 0), 1e-6 * (1 + fabs(bears)));
    }
    destroy(&s);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_lift_carries_what_begins_in_it),
        cmocka_unit_test(test_a_platform_that_turns_slowly),
        cmocka_unit_test(test_a_debt_ends_with_its_overlap),
        cmocka_unit_test(test_a_soft_stack_is_as_deep_as_it_should_be),
        cmocka_unit_test(test_springs_keep_their_law_below_what_comes_up),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
