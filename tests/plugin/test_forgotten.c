/*
 * What is forgotten before it is destroyed: nothing of it is used any more. That what comes at its address is new is in
 * test_addresses.c.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <math.h>
#include <string.h>

typedef struct scene {
    dWorldID world;
    dSpaceID space;
    dGeomID ground;
    pinch_ode *plugin;
} scene;

static void start(scene *s)
{
    *s = (scene){.world = dWorldCreate(), .space = dHashSpaceCreate(NULL)};
    dWorldSetGravity(s->world, 0, 0, -9.81);
    s->ground = dCreatePlane(s->space, 0, 0, 1, 0);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    assert_int_equal(pinch_ode_create(s->world, &settings, &s->plugin), PINCH_OK);
}

static void end(scene *s)
{
    pinch_ode_destroy(s->plugin);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

/* Makes a body of 1 kg for a geom. */
static dBodyID make_body(const scene *s, dGeomID geom, double x, double y, double z)
{
    dMass mass;
    dBodyID body = dBodyCreate(s->world);
    dMassSetBoxTotal(&mass, 1, 0.2, 0.2, 0.2);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, x, y, z);
    return body;
}

static void destroy_geom(const scene *s, dGeomID geom)
{
    assert_int_equal(pinch_ode_forget_geom(s->plugin, geom), PINCH_OK);
    dGeomDestroy(geom);
}

static void destroy_body(const scene *s, dBodyID body)
{
    assert_int_equal(pinch_ode_forget_body(s->plugin, body), PINCH_OK);
    dBodyDestroy(body);
}

static int meet(void *context, dGeomID a, dGeomID b, int room, dContact *contacts)
{
    (void)context;
    int count = dCollide(a, b, room, &contacts->geom, sizeof *contacts);
    for (int i = 0; i < count; i++) contacts[i].surface = (dSurfaceParameters){.mode = dContactApprox1, .mu = 0.5};
    return count;
}

static void step(const scene *s)
{
    assert_int_equal(pinch_ode_collide(s->plugin, s->space, 8, meet, NULL), PINCH_OK);
    assert_int_equal(pinch_ode_step(s->plugin, 0.005), PINCH_OK);
}

/* ---- what it costs ---- */

enum { SIDE = 90, BODIES = SIDE * SIDE };

typedef struct field {
    dGeomID geom[BODIES];
    dBodyID body[BODIES];
    dJointID joint[BODIES]; /* between a body and the one before it; NULL: none */
} field;

static dJointID join(const scene *s, dBodyID body, dBodyID before)
{
    const dReal *x = dBodyGetPosition(body);
    dJointID joint = dJointCreateHinge(s->world, NULL);
    pinch_servo servo = pinch_default_servo();
    servo.kp = 1, servo.kd = 0.1;
    dJointAttach(joint, body, before);
    dJointSetHingeAnchor(joint, x[0] - 0.15, x[1], x[2]);
    dJointSetHingeAxis(joint, 0, 1, 0);
    assert_int_equal(pinch_ode_note_joint(s->plugin, joint), PINCH_OK);
    assert_int_equal(pinch_ode_set_servo(s->plugin, joint, 0, &servo), PINCH_OK);
    return joint;
}

/* Every other pair of neighbours is joined. */
static void make_field(const scene *s, field *f)
{
    memset(f, 0, sizeof *f);
    for (int k = 0; k < BODIES; k++) {
        f->geom[k] = dCreateSphere(s->space, 0.1);
        f->body[k] = make_body(s, f->geom[k], 0.3 * (k % SIDE), 0.3 * (k / SIDE), 0.099);
        dBodySetAutoDisableFlag(f->body[k], k % 4 == 0);
        if (k % 2) f->joint[k] = join(s, f->body[k], f->body[k - 1]);
    }
}

/* All bodies of a world go one by one, out of their order, and what comes in their places of memory is new. */
static void test_all_bodies_go(void **state)
{
    (void)state;
    static field f;
    scene s;
    start(&s);
    for (int round = 0; round < 2; round++) {
        make_field(&s, &f);
        for (int i = 0; i < 3; i++) step(&s);
        assert_true(pinch_ode_statistics(s.plugin).contacts_solved > 0);
        for (int k = 0; k < BODIES; k++) {
            int i = 7 * k % BODIES; /* BODIES has no factor 7 */
            if (f.joint[i]) {
                assert_int_equal(pinch_ode_forget_joint(s.plugin, f.joint[i]), PINCH_OK);
                dJointDestroy(f.joint[i]);
            }
            destroy_geom(&s, f.geom[i]);
            destroy_body(&s, f.body[i]);
        }
        const pinch_ode_contact *list;
        int count;
        step(&s);
        assert_int_equal(pinch_ode_contacts(s.plugin, &list, &count), PINCH_OK);
        assert_int_equal(count, 0);
    }
    end(&s);
}

/* ---- what is left of it ---- */

static int count_contacts(const scene *s, dGeomID geom)
{
    const pinch_ode_contact *list;
    int count, found = 0;
    assert_int_equal(pinch_ode_contacts(s->plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++) found += list[i].geom1 == geom || list[i].geom2 == geom;
    return found;
}

/*
 * A program leaves one of four corners out from some step on, and that one is gone. Before it handed over a contact
 * between others in the same place, one of which it has destroyed since: that contact says nothing about the corner.
 */
static void test_contacts_with_the_gone_count_no_more(void **state)
{
    enum { STEPS = 20 };
    (void)state;
    scene s;
    start(&s);
    dGeomID box = dCreateBox(s.space, 0.2, 0.2, 0.2), other = dCreateSphere(s.space, 0.01);
    dBodyID body = make_body(&s, box, 0, 0, 0.0999), others = make_body(&s, other, 0.1, 0.1, 0.0099);
    for (int i = 0; i < STEPS; i++) {
        bool last = i == STEPS - 1;
        dContact contact[8];
        memset(contact, 0, sizeof contact);
        int count = meet(NULL, box, s.ground, 8, contact);
        assert_int_equal(count, 4);
        dContact beside = contact[0];
        beside.geom.g1 = other;
        assert_int_equal(pinch_ode_add_contact(s.plugin, &beside, others, NULL), PINCH_OK);
        for (int k = last; k < count; k++)
            assert_int_equal(pinch_ode_add_contact(s.plugin, &contact[k], body, NULL), PINCH_OK);
        if (last) {
            destroy_geom(&s, other);
            destroy_body(&s, others);
        }
        assert_int_equal(pinch_ode_step(s.plugin, 0.005), PINCH_OK);
        assert_int_equal(count_contacts(&s, box), last ? 3 : 4);
        assert_int_equal(count_contacts(&s, other), last ? 0 : 1);
    }
    end(&s);
}

/* Between the two halves of a step, a geom may be forgotten: the others go on with their own histories. */
static void run_with_friction(bool forgets, double friction[3])
{
    scene s;
    dGeomID geom[3];
    pinch_material material = pinch_default_material();
    start(&s);
    dWorldSetGravity(s.world, 1, 0, -9.81);
    for (int k = 0; k < 3; k++) {
        geom[k] = dCreateBox(s.space, 0.2, 0.2, 0.2);
        (void)make_body(&s, geom[k], k, 0, 0.0999 - 0.0001 * k);
        material.stiffness[0] = 2e4 * (k + 1);
        assert_int_equal(pinch_ode_set_material(s.plugin, geom[k], &material), PINCH_OK);
    }
    for (int i = 0; i < 10; i++) {
        assert_int_equal(pinch_ode_collide(s.plugin, s.space, 8, meet, NULL), PINCH_OK);
        assert_int_equal(pinch_ode_solve(s.plugin, 0.005), PINCH_OK);
        if (forgets && i == 8) assert_int_equal(pinch_ode_forget_geom(s.plugin, geom[0]), PINCH_OK);
        assert_int_equal(pinch_ode_advance(s.plugin, 0.005), PINCH_OK);
    }
    pinch_ode_load load;
    assert_int_equal(pinch_ode_geom_load(s.plugin, geom[2], NULL, &load), PINCH_OK);
    assert_true(load.points == 4 && fabs(load.tangential[0]) > 0.1);
    memcpy(friction, load.tangential, 3 * sizeof *friction);
    end(&s);
}

static void test_forgotten_in_the_middle_of_a_step(void **state)
{
    (void)state;
    double with[3], without[3];
    run_with_friction(true, with);
    run_with_friction(false, without);
    assert_memory_equal(with, without, sizeof with);
}

/* The load of a geom that is forgotten is nobody's. */
static void test_load_of_the_gone(void **state)
{
    (void)state;
    scene s;
    pinch_ode_load load;
    start(&s);
    dGeomID low = dCreateBox(s.space, 0.2, 0.2, 0.2), high = dCreateBox(s.space, 0.2, 0.2, 0.2);
    (void)make_body(&s, low, 0, 0, 0.0999);
    dBodyID body = make_body(&s, high, 0, 0, 0.2998);
    for (int i = 0; i < 3; i++) step(&s);
    assert_int_equal(pinch_ode_geom_load(s.plugin, low, NULL, &load), PINCH_OK);
    assert_int_equal(load.points, 8);
    assert_int_equal(pinch_ode_forget_body(s.plugin, body), PINCH_OK);
    assert_int_equal(pinch_ode_geom_load(s.plugin, high, NULL, &load), PINCH_OK);
    assert_int_equal(load.points, 0);
    assert_int_equal(pinch_ode_geom_load(s.plugin, low, NULL, &load), PINCH_OK);
    assert_int_equal(load.points, 4);
    assert_int_equal(pinch_ode_forget_geom(s.plugin, low), PINCH_OK);
    assert_int_equal(pinch_ode_geom_load(s.plugin, s.ground, NULL, &load), PINCH_OK);
    assert_int_equal(load.points, 0);
    step(&s);
    assert_int_equal(pinch_ode_geom_load(s.plugin, low, NULL, &load), PINCH_OK);
    assert_int_equal(load.points, 8);
    end(&s);
}

/* A snapshot holds nothing of what is gone: it needs not be among the parts. */
static void test_saved_before_the_next_step(void **state)
{
    (void)state;
    scene s;
    unsigned char data[1 << 16];
    size_t size = sizeof data;
    double went_on[3];
    start(&s);
    dGeomID box = dCreateBox(s.space, 0.2, 0.2, 0.2), other = dCreateBox(s.space, 0.2, 0.2, 0.2);
    dBodyID body = make_body(&s, box, 0, 0, 0.0999), others = make_body(&s, other, 0, 0, 0.2998);
    dBodySetLinearVel(body, 0.1, 0, 0);
    for (int i = 0; i < 3; i++) step(&s);
    destroy_geom(&s, other);
    destroy_body(&s, others);
    const dGeomID geoms[2] = {box, s.ground};
    const pinch_ode_parts parts = {.bodies = &body, .geoms = geoms, .body_count = 1, .geom_count = 2};
    assert_int_equal(pinch_ode_save(s.plugin, &parts, data, &size), PINCH_OK);
    step(&s);
    memcpy(went_on, dBodyGetPosition(body), sizeof went_on);
    assert_int_equal(pinch_ode_restore(s.plugin, &parts, data, size), PINCH_OK);
    step(&s);
    assert_memory_equal(went_on, dBodyGetPosition(body), sizeof went_on);
    assert_int_equal(count_contacts(&s, box), 4);
    end(&s);
}

/* Energy is read from the last step. A geom that has been forgotten may be gone, and is not asked for its curvature:
 * here it has another one. */
static void test_energy_of_the_gone(void **state)
{
    (void)state;
    scene s = {.world = dWorldCreate(), .space = dHashSpaceCreate(NULL)};
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_material tip = pinch_default_material();
    pinch_ode_energy energy[2];
    dWorldSetGravity(s.world, 0, 0, -9.81);
    s.ground = dCreatePlane(s.space, 0, 0, 1, 0);
    settings.keep_islands = true;
    assert_int_equal(pinch_ode_create(s.world, &settings, &s.plugin), PINCH_OK);
    tip.hertz_modulus = 1e6;
    assert_int_equal(pinch_ode_set_material(s.plugin, s.ground, &tip), PINCH_OK);
    dGeomID ball = dCreateSphere(s.space, 0.1);
    (void)make_body(&s, ball, 0, 0, 0.0999);
    tip.hertz_modulus = 0;
    assert_int_equal(pinch_ode_set_material(s.plugin, ball, &tip), PINCH_OK);
    for (int i = 0; i < 3; i++) step(&s);
    assert_int_equal(pinch_ode_forget_geom(s.plugin, ball), PINCH_OK);
    assert_int_equal(pinch_ode_contact_energy(s.plugin, &energy[0]), PINCH_OK);
    dGeomSphereSetRadius(ball, 100);
    assert_int_equal(pinch_ode_contact_energy(s.plugin, &energy[1]), PINCH_OK);
    assert_true(energy[0].elastic_end > 0);
    assert_memory_equal(&energy[0], &energy[1], sizeof energy[0]);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_bodies_go),
        cmocka_unit_test(test_contacts_with_the_gone_count_no_more),
        cmocka_unit_test(test_forgotten_in_the_middle_of_a_step),
        cmocka_unit_test(test_load_of_the_gone),
        cmocka_unit_test(test_saved_before_the_next_step),
        cmocka_unit_test(test_energy_of_the_gone),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
