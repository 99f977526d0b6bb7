/* What a geom's contacts exert together, against sums over the list of contacts and against closed forms. */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

static const double STEP = 0.001, MASS = 2, G = 9.81;

typedef struct slab {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dBodyID body;
    dGeomID box, floor, wall;
} slab;

static void touch(void *data, dGeomID a, dGeomID b)
{
    slab *s = data;
    dContact contact[8];
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, 8, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++)
        assert_int_equal(pinch_ode_add_contact(s->plugin, &contact[i], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
}

/* A box of 2 kg on a floor, with the material of its underside. */
static void lay(slab *s, pinch_contact_model model, double friction)
{
    dMass mass;
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_material material = pinch_default_material();
    memset(s, 0, sizeof *s);
    s->world = dWorldCreate();
    s->space = dHashSpaceCreate(NULL);
    dWorldSetGravity(s->world, 0, 0, -G);
    assert_int_equal(pinch_ode_create(s->world, &settings, &s->plugin), PINCH_OK);
    s->floor = dCreatePlane(s->space, 0, 0, 1, 0);
    s->box = dCreateBox(s->space, 0.2, 0.2, 0.1);
    s->body = dBodyCreate(s->world);
    dMassSetBoxTotal(&mass, MASS, 0.2, 0.2, 0.1);
    dBodySetMass(s->body, &mass);
    dBodySetPosition(s->body, 0, 0, 0.05);
    dGeomSetBody(s->box, s->body);
    material.model = model;
    material.friction = material.friction_kinetic = friction;
    material.torsional_friction = 0.01;
    assert_int_equal(pinch_ode_set_material(s->plugin, s->box, &material), PINCH_OK);
}

static void go(slab *s, int steps, double push, double turn)
{
    for (int i = 0; i < steps; i++) {
        dBodyAddForce(s->body, push, 0, 0);
        dBodyAddTorque(s->body, 0, 0, turn);
        dSpaceCollide(s->space, s, touch);
        assert_int_equal(pinch_ode_step(s->plugin, STEP), PINCH_OK);
    }
}

static void clear(slab *s)
{
    pinch_ode_destroy(s->plugin);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static void test_at_rest(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load, pair, floor;
    static const double ORIGIN[3] = {0, 0, 0};
    lay(&s, PINCH_CONTACT_SOFT, 0.5);
    go(&s, 500, 0, 0);
    go(&s, 8000, 4, 0);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK);
    assert_int_equal(pinch_ode_pair_load(s.plugin, s.box, s.floor, NULL, &pair), PINCH_OK);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.floor, ORIGIN, &floor), PINCH_OK);
    assert_memory_equal(&load, &pair, sizeof load);
    assert_int_equal(load.points, 4);
    assert_int_equal(load.state, PINCH_CONTACT_STICK);
    assert_close(load.force[0], -4, 1e-9);
    assert_close(load.force[2], MASS * G, 1e-9);
    assert_close(load.normal_force, MASS * G, 1e-9);
    assert_close(load.tangential[0], -4, 1e-9);
    assert_close(load.normal[2], MASS * G, 1e-9);
    assert_close(load.slip_margin, 1 - 4 / (0.5 * MASS * G), 1e-9);
    assert_true(load.least_margin <= load.slip_margin + 1e-9 && load.least_margin > 0);
    assert_true(load.slip_total == 0);
    for (int i = 0; i < 3; i++) assert_close(load.moment[i], 0, 1e-9); /* the box does not tip over */
    for (int i = 0; i < 3; i++) assert_close(floor.force[i], -load.force[i], 1e-12);
    const double *p = dBodyGetPosition(s.body);
    assert_close(floor.moment[1], -(p[2] * -4 - p[0] * MASS * G), 1e-9); /* minus the box's, about the origin */
    clear(&s);
}

static void test_slip_so_far(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load;
    lay(&s, PINCH_CONTACT_HARD, 0.5);
    go(&s, 500, 0, 0);
    double start = dBodyGetPosition(s.body)[0];
    const pinch_ode_contact *list;
    int count;
    go(&s, 500, 20, 0); /* twice the limit */
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK);
    assert_int_equal(pinch_ode_contacts(s.plugin, &list, &count), PINCH_OK);
    assert_int_equal(count, 4);
    double sheared = (list[0].geom1 == s.box ? 1 : -1) * list[0].elastic[0];
    assert_int_equal(load.state, PINCH_CONTACT_SLIP);
    assert_close(load.slip_margin, 0, 1e-9);
    assert_close(load.slip_total, dBodyGetPosition(s.body)[0] - start - sheared, 1e-4);
    dBodySetPosition(s.body, 0, 0, 1);
    go(&s, 1, 0, 0);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK);
    assert_true(load.points == 0 && load.slip_total == 0 && isnan(load.slip_margin) && isnan(load.least_margin));
    assert_int_equal(load.state, PINCH_CONTACT_OPEN);
    clear(&s);
}

static void test_torsion(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load;
    lay(&s, PINCH_CONTACT_SOFT, 0.5);
    go(&s, 2000, 0, 0.05);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK);
    assert_close(load.moment[2], -0.05, 1e-9); /* by torsion, and by friction with a lever */
    assert_true(fabs(load.torsion) > 0 && fabs(load.torsion) < 0.05);
    clear(&s);
}

/* Nothing holds a box without friction: all its motion is slip, and there is no margin. */
static void test_without_friction(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load;
    lay(&s, PINCH_CONTACT_FRICTIONLESS, 0);
    go(&s, 500, 0, 0);
    double start = dBodyGetPosition(s.body)[0];
    go(&s, 500, 1, 0);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK);
    assert_int_equal(load.state, PINCH_CONTACT_SLIP);
    assert_close(load.slip_total, dBodyGetPosition(s.body)[0] - start, 1e-5); /* it also pitches a little */
    assert_true(isnan(load.slip_margin));
    clear(&s);
}

/* ODE's friction is a force of its own unless a contact asks for a coefficient: it holds a box that does not press, and
 * what the box feels of it belongs to the load. */
static void test_friction_without_pressure(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load;
    lay(&s, PINCH_CONTACT_HARD, 0.5);
    dWorldSetGravity(s.world, 0, 0, 0);
    dGeomID bare = dCreateBox(s.space, 0.2, 0.2, 0.1); /* without a material: the contact's own parameters count */
    dGeomSetBody(bare, s.body);
    for (int i = 0; i < 200; i++) {
        dBodyAddForce(s.body, 2, 0, 0);
        for (int k = 0; k < 4; k++) {
            dContact c;
            memset(&c, 0, sizeof c);
            c.surface.mu = 1;
            c.geom.g1 = bare;
            c.geom.g2 = s.floor;
            c.geom.normal[2] = 1;
            c.geom.pos[0] = dBodyGetPosition(s.body)[0] + (k % 2 ? 0.1 : -0.1);
            c.geom.pos[1] = k / 2 ? 0.1 : -0.1;
            c.geom.pos[2] = dBodyGetPosition(s.body)[2]; /* level with the centre: friction does not turn the box */
            assert_int_equal(pinch_ode_add_contact(s.plugin, &c, s.body, NULL), PINCH_OK);
        }
        assert_int_equal(pinch_ode_step(s.plugin, STEP), PINCH_OK);
    }
    assert_int_equal(pinch_ode_geom_load(s.plugin, bare, NULL, &load), PINCH_OK);
    assert_close(load.normal_force, 0, 1e-9);
    assert_close(load.force[0], -2, 1e-6);
    assert_close(load.tangential[0], -2, 1e-6);
    assert_true(load.slip_margin > 0 && load.slip_margin < 1);
    for (int i = 0; i < 3; i++) assert_true(isfinite(load.position[i]));
    clear(&s);
}

static void test_wrong_calls(void **state)
{
    (void)state;
    slab s;
    pinch_ode_load load;
    static const double NOWHERE[3] = {0, INFINITY, 0};
    lay(&s, PINCH_CONTACT_HARD, 0.5);
    assert_int_equal(pinch_ode_geom_load(NULL, s.box, NULL, &load), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_geom_load(s.plugin, NULL, NULL, &load), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NOWHERE, &load), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_pair_load(s.plugin, s.box, NULL, NULL, &load), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.box, NULL, &load), PINCH_OK); /* before the first step */
    assert_int_equal(load.points, 0);
    clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_at_rest),
        cmocka_unit_test(test_slip_so_far),
        cmocka_unit_test(test_torsion),
        cmocka_unit_test(test_without_friction),
        cmocka_unit_test(test_friction_without_pressure),
        cmocka_unit_test(test_wrong_calls),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
