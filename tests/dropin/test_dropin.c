/* Uses the drop-in layer at source level. As things come and go, the right contact joints must be handed to Pinch. */

#include "support/cmocka_all.h"

#include "dropin/registry.h"

#include <pinch/ode_dropin.h>

#include <stdlib.h>
#include <string.h>

static const double H = 0.01;

typedef struct scene {
    dWorldID world;
    dSpaceID space;
    dGeomID ground, ball;
    dBodyID body;
} scene;

static scene make(void)
{
    scene s;
    s.world = dWorldCreate();
    s.space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(s.world, 0, 0, -9.81);
    s.ground = dCreatePlane(s.space, 0, 0, 1, 0);
    s.ball = dCreateSphere(s.space, 0.5);
    s.body = dBodyCreate(s.world);
    dGeomSetBody(s.ball, s.body);
    dBodySetPosition(s.body, 0, 0, 0.499);
    return s;
}

static void unmake(scene *s)
{
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static dContact touch(const scene *s)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.surface.mode = dContactApprox1;
    contact.surface.mu = 0.5;
    contact.geom.normal[2] = 1;
    contact.geom.depth = 0.001;
    contact.geom.g1 = s->ball;
    contact.geom.g2 = s->ground;
    return contact;
}

static dJointID add(const scene *s, dJointGroupID group)
{
    dContact contact = touch(s);
    dJointID joint = dJointCreateContact(s->world, group, &contact);
    assert_int_equal(dJointGetType(joint), dJointTypeContact);
    return joint;
}

static dJointID attach(const scene *s, dJointGroupID group)
{
    dJointID joint = add(s, group);
    dJointAttach(joint, s->body, NULL);
    return joint;
}

/* How many contact joints a step hands over, and how many it finds idle. */
static void expect(const scene *s, long offered, long idle)
{
    pinch_dropin_stats before = pinch_dropin_statistics();
    assert_int_equal(dWorldQuickStep(s->world, H), 1);
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.contacts_offered - before.contacts_offered, offered);
    assert_int_equal(after.contacts_idle - before.contacts_idle, idle);
    assert_int_equal(after.steps - before.steps, 1);
    assert_int_equal(after.steps_refused, before.steps_refused);
    assert_true(isfinite(dBodyGetPosition(s->body)[2]));
}

static void groups_and_joints_end(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID first = dJointGroupCreate(0), second = dJointGroupCreate(0);
    for (int i = 0; i < 5; i++) attach(&s, i % 2 ? first : second);
    dJointID single = attach(&s, NULL);
    expect(&s, 6, 0);
    expect(&s, 6, 0); /* joints that are kept count again */
    dJointGroupEmpty(first);
    expect(&s, 4, 0);
    dJointGroupEmpty(first);
    attach(&s, first);
    expect(&s, 5, 0);
    dJointDestroy(single);
    expect(&s, 4, 0);
    dJointGroupDestroy(second);
    expect(&s, 1, 0);
    dJointGroupDestroy(first);
    expect(&s, 0, 0);
    unmake(&s);
}

static void a_joint_of_a_group_outlives_its_destruction(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    dJointID joint = attach(&s, group);
    dJointDestroy(joint); /* which ODE ignores */
    expect(&s, 1, 0);
    dJointGroupDestroy(group);
    expect(&s, 0, 0);
    unmake(&s);
}

static void what_does_not_act_is_idle(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    add(&s, group); /* never attached */
    dJointID joint = attach(&s, group);
    expect(&s, 1, 1);
    dJointDisable(joint);
    expect(&s, 0, 2);
    assert_false(dJointIsEnabled(joint));
    dJointEnable(joint);
    dJointAttach(joint, NULL, s.body);
    expect(&s, 1, 1);
    assert_true(dJointIsEnabled(joint));
    dBodySetKinematic(s.body);
    expect(&s, 0, 2);
    dBodySetDynamic(s.body);
    expect(&s, 1, 1);
    dJointAttach(joint, NULL, NULL);
    expect(&s, 0, 2);
    dJointGroupDestroy(group);
    unmake(&s);
}

static void bodies_end(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    dBodyID other = dBodyCreate(s.world);
    dBodySetPosition(other, 0, 0, 2);
    dContact contact = touch(&s);
    contact.geom.g2 = NULL;
    dJointAttach(dJointCreateContact(s.world, group, &contact), s.body, other);
    attach(&s, group);
    expect(&s, 2, 0);
    dBodyDestroy(other);
    expect(&s, 1, 1);
    dJointGroupDestroy(group);
    unmake(&s);
}

static void geoms_end_with_their_contacts_alive(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    pinch_material soft = pinch_default_material();
    assert_int_equal(pinch_dropin_set_material(s.world, s.ball, &soft), PINCH_OK);
    for (int round = 0; round < 20; round++) {
        attach(&s, group);
        expect(&s, round + 1, 0);
        dGeomDestroy(s.ball);
        if (round % 3 == 0) expect(&s, round + 1, 0);
        s.ball = dCreateSphere(s.space, 0.5); /* often where the last one was */
        dGeomSetBody(s.ball, s.body);
        dBodySetPosition(s.body, 0, 0, 0.499);
        dBodySetLinearVel(s.body, 0, 0, 0);
    }
    expect(&s, 20, 0);
    dSpaceDestroy(s.space);
    expect(&s, 20, 0);
    dJointGroupDestroy(group);
    dWorldDestroy(s.world);
}

/* Of a geom that takes the place of one with a material: nothing is left of it. */
static void a_material_ends_with_its_geom(void **state)
{
    (void)state;
    pinch_ode_settings kept = pinch_dropin_settings(), only = kept;
    only.scope = PINCH_ODE_MATERIAL_CONTACTS;
    assert_int_equal(pinch_dropin_set_settings(&only), PINCH_OK);
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    pinch_material soft = pinch_default_material();
    assert_int_equal(pinch_dropin_set_material(s.world, s.ball, &soft), PINCH_OK);
    dGeomID first = s.ball, others[100];
    dGeomDestroy(s.ball);
    int count = 0;
    do /* a sanitizer keeps places back for a while, others do not */
        others[count++] = dCreateSphere(NULL, 0.5);
    while (others[count - 1] != first && count < 100);
    s.ball = others[count - 1];
    dGeomSetBody(s.ball, s.body);
    attach(&s, group);
    long solved = pinch_dropin_statistics().ode.contacts_solved;
    expect(&s, 0, 0); /* no geom has a material any more */
    assert_int_equal(pinch_dropin_statistics().ode.contacts_solved, solved);
    assert_int_equal(pinch_dropin_set_material(s.world, s.ground, &soft), PINCH_OK);
    attach(&s, group);
    expect(&s, 1, 0);
    for (int i = 0; i < count; i++) dGeomDestroy(others[i]);
    dJointGroupDestroy(group);
    unmake(&s);
    assert_int_equal(pinch_dropin_set_settings(&kept), PINCH_OK);
}

static void spaces_in_spaces_end(void **state)
{
    (void)state;
    scene s = make();
    dSpaceID inner = dHashSpaceCreate(s.space);
    dGeomID ball = dCreateSphere(inner, 0.5);
    dContact contact = touch(&s);
    contact.geom.g1 = ball;
    pinch_material soft = pinch_default_material();
    assert_int_equal(pinch_dropin_set_material(s.world, ball, &soft), PINCH_OK);
    dJointID joint = dJointCreateContact(s.world, NULL, &contact);
    dJointAttach(joint, s.body, NULL);
    expect(&s, 1, 0);
    dSpaceClean(inner);
    expect(&s, 1, 0);
    dCreateSphere(inner, 0.25);
    dSpaceDestroy(s.space);
    expect(&s, 1, 0);
    dJointDestroy(joint);
    dWorldDestroy(s.world);
}

static void worlds_are_apart(void **state)
{
    (void)state;
    scene a = make(), b = make();
    dJointGroupID shared = dJointGroupCreate(0);
    for (int i = 0; i < 3; i++) attach(&a, shared);
    for (int i = 0; i < 2; i++) attach(&b, shared);
    dJointID single = attach(&a, NULL);
    expect(&a, 4, 0);
    expect(&b, 2, 0);
    long steps = pinch_dropin_statistics().steps, worlds = pinch_dropin_statistics().worlds;
    unmake(&a); /* with joints alive: `single` goes with it, those of the group stay in the group */
    (void)single;
    assert_int_equal(pinch_dropin_statistics().steps, steps);
    assert_int_equal(pinch_dropin_statistics().worlds, worlds);
    scene c = make(); /* often where the destroyed one was */
    expect(&c, 0, 0);
    expect(&b, 2, 0);
    attach(&c, shared);
    expect(&c, 1, 0);
    dJointGroupEmpty(shared);
    expect(&b, 0, 0);
    expect(&c, 0, 0);
    dJointGroupDestroy(shared);
    unmake(&b);
    unmake(&c);
}

/* ------------------------------------------------------------------------------------------------------ callbacks */

static scene outer, other;
static int calls;

/* What a program may do while its world is being stepped. */
static void moved(dBodyID body)
{
    (void)body;
    if (calls++) return;
    dGeomDestroy(outer.ball);
    expect(&other, 1, 0);
}

static void a_callback_of_a_step(void **state)
{
    (void)state;
    outer = make();
    other = make();
    calls = 0;
    dJointGroupID group = dJointGroupCreate(0);
    attach(&outer, group);
    attach(&other, group);
    pinch_material soft = pinch_default_material();
    assert_int_equal(pinch_dropin_set_material(outer.world, outer.ball, &soft), PINCH_OK);
    dBodySetMovedCallback(outer.body, moved);
    pinch_dropin_stats before = pinch_dropin_statistics();
    assert_int_equal(dWorldStep(outer.world, H), 1);
    assert_int_equal(calls, 1);
    assert_int_equal(pinch_dropin_statistics().steps - before.steps, 2);
    expect(&outer, 1, 0);
    dJointGroupDestroy(group);
    unmake(&outer);
    unmake(&other);
}

static void count_call(dBodyID body)
{
    (void)body;
    calls++;
}

/* Pinch moves bodies itself as long as no callback is to be told. */
static void moved_callbacks_are_called(void **state)
{
    (void)state;
    enum { WITHOUT = 3, WITH = 4 };
    scene s = make();
    calls = 0;
    dJointGroupID group = dJointGroupCreate(0);
    for (int step = 0; step < WITHOUT + WITH; step++) {
        if (step == WITHOUT) dBodySetMovedCallback(s.body, count_call);
        attach(&s, group);
        expect(&s, 1, 0);
        dJointGroupEmpty(group);
    }
    assert_int_equal(calls, WITH);
    dJointGroupDestroy(group);
    unmake(&s);
}

/* ------------------------------------------------------------------------------------------------ refused, settings */

static bool no_memory;

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);

void *__wrap_calloc(size_t count, size_t size)
{
    return no_memory ? NULL : __real_calloc(count, size);
}

/* Pinch has no memory to begin with: ODE goes on, and so does Pinch once there is some. */
static void a_refused_step_is_odes(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    attach(&s, group);
    pinch_dropin_stats before = pinch_dropin_statistics();
    dBodySetLinearVel(s.body, 1, 0, 0);
    no_memory = true;
    int stepped = dWorldStep(s.world, H);
    no_memory = false;
    assert_int_equal(stepped, 1);
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.steps - before.steps, 1);
    assert_int_equal(after.steps_refused - before.steps_refused, 1);
    assert_int_equal(after.contacts_offered - before.contacts_offered, 1);
    assert_int_equal(after.contacts_refused - before.contacts_refused, 1);
    assert_int_equal(after.ode.steps, before.ode.steps);
    assert_true(dBodyGetPosition(s.body)[0] > 0);
    expect(&s, 1, 0);
    assert_int_equal(pinch_dropin_statistics().ode.steps - before.ode.steps, 1);
    dJointGroupDestroy(group);
    unmake(&s);
}

static void settings_are_checked(void **state)
{
    (void)state;
    pinch_ode_settings kept = pinch_dropin_settings(), s = kept;
    assert_int_equal(pinch_dropin_set_settings(NULL), PINCH_INVALID_ARGUMENT);
    s.tangential_ratio = 0;
    assert_int_equal(pinch_dropin_set_settings(&s), PINCH_INVALID_ARGUMENT);
    s = kept;
    s.solver.tolerance = NAN;
    assert_int_equal(pinch_dropin_set_settings(&s), PINCH_INVALID_ARGUMENT);
    s = kept;
    s.solver.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_dropin_set_settings(&s), PINCH_UNSUPPORTED);
    s.faces = 8;
    assert_int_equal(pinch_dropin_set_settings(&s), PINCH_OK);
    assert_int_equal(pinch_dropin_settings().solver.solver, PINCH_SOLVER_LEMKE);
    assert_int_equal(pinch_dropin_set_settings(&kept), PINCH_OK);

    /* what the layer takes is what pinch_ode_create takes */
    scene w = make();
    pinch_ode *plugin;
    s.stepper = PINCH_ODE_QUICKSTEP;
    assert_int_equal(pinch_ode_create(w.world, &s, &plugin), PINCH_OK);
    pinch_ode_destroy(plugin);
    unmake(&w);
}

/* Outside of the scope everything is left to ODE, to the bit. */
static void outside_of_the_scope_all_is_odes(void **state)
{
    (void)state;
    pinch_ode_settings kept = pinch_dropin_settings(), s = kept;
    s.scope = PINCH_ODE_MATERIAL_CONTACTS;
    assert_int_equal(pinch_dropin_set_settings(&s), PINCH_OK);
    scene with = make(), without = make();
    dJointGroupID group = dJointGroupCreate(0);
    dBodySetLinearVel(with.body, 1, 0, 0);
    dBodySetLinearVel(without.body, 1, 0, 0);
    pinch_dropin_stats before = pinch_dropin_statistics();
    for (int i = 0; i < 50; i++) { /* quickstep draws the order it goes in: the same for both */
        dRandSetSeed((unsigned long)i);
        attach(&with, group);
        expect(&with, 0, 0);
        dJointGroupEmpty(group);
#undef dJointCreateContact
#undef dWorldQuickStep
#undef dJointGroupEmpty
        dRandSetSeed((unsigned long)i);
        dContact contact = touch(&without);
        dJointAttach(dJointCreateContact(without.world, group, &contact), without.body, NULL);
        (void)dWorldQuickStep(without.world, H);
        dJointGroupEmpty(group);
#define dJointCreateContact pinch_dropin_joint_create_contact
#define dWorldQuickStep     pinch_dropin_world_quick_step
#define dJointGroupEmpty    pinch_dropin_joint_group_empty
    }
    assert_memory_equal(dBodyGetPosition(with.body), dBodyGetPosition(without.body), 3 * sizeof(dReal));
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.ode.contacts_solved, before.ode.contacts_solved);
    assert_int_equal(after.contacts_out_of_scope - before.contacts_out_of_scope, 50);
    dJointGroupDestroy(group);
    unmake(&with);
    unmake(&without);
    assert_int_equal(pinch_dropin_set_settings(&kept), PINCH_OK);
}

static void materials_reach_the_contacts(void **state)
{
    (void)state;
    scene s = make();
    dJointGroupID group = dJointGroupCreate(0);
    pinch_material soft = pinch_default_material(), wrong = soft;
    wrong.friction = -1;
    assert_int_equal(pinch_dropin_set_material(s.world, s.ball, &wrong), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_dropin_set_material(NULL, s.ball, &soft), PINCH_INVALID_ARGUMENT);
    const pinch_ode_contact *list;
    int count = -1;
    assert_int_equal(pinch_dropin_contacts(s.world, &list, &count), PINCH_OK);
    assert_int_equal(count, 0);
    pinch_dropin_reset_statistics();
    assert_int_equal(pinch_dropin_statistics().steps, 0);
    expect(&s, 0, 0);
    assert_int_equal(pinch_dropin_statistics().worlds, 1);
    dJointGroupDestroy(group);
    unmake(&s);
    assert_int_equal(pinch_dropin_statistics().worlds, 1);
}

/* ----------------------------------------------------------------------------------------- the registry by itself */

/* A contact must not name a geom that is gone, whatever stands in its place. */
static void no_name_outlives_its_geom(void **state)
{
    (void)state;
    static char places[8];
    dWorldID id = (dWorldID)(void *)&places[0];
    dJointGroupID group = (dJointGroupID)(void *)&places[1];
    dGeomID a = (dGeomID)(void *)&places[2], b = (dGeomID)(void *)&places[3];
    static pinch_registry r;
    pinch_live_world *world = pinch_registry_world(&r, id);
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.geom.g1 = a;
    contact.geom.g2 = b;
    assert_true(pinch_registry_add_joint(&r, world, group, (dJointID)(void *)&places[4], &contact));
    pinch_registry_forget_geom(world, a);
    assert_true(pinch_registry_add_joint(&r, world, NULL, (dJointID)(void *)&places[5], &contact)); /* a new a */
    assert_null(world->contacts.first->contact.geom.g1);
    assert_ptr_equal(world->contacts.first->contact.geom.g2, b);
    assert_ptr_equal(world->contacts.last->contact.geom.g1, a);
    pinch_registry_forget_geom(world, b);
    pinch_registry_drop_names(world);
    assert_null(world->contacts.first->contact.geom.g2);
    assert_null(world->contacts.last->contact.geom.g2);
    assert_ptr_equal(world->contacts.last->contact.geom.g1, a);
    pinch_registry_empty_group(&r, group);
    assert_int_equal(world->contacts.count, 1);
    pinch_registry_drop_joint(&r, (dJointID)(void *)&places[5]);
    assert_int_equal(world->contacts.count, 0);
    pinch_registry_drop_group(&r, group);
    pinch_registry_take_world(&r, world);
    pinch_registry_free_world(world);
    assert_null(pinch_registry_find_world(&r, id));
}

static int start(void **state)
{
    (void)state;
    dInitODE();
    return 0;
}

static int end(void **state)
{
    (void)state;
    dCloseODE();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_and_joints_end),
        cmocka_unit_test(a_joint_of_a_group_outlives_its_destruction),
        cmocka_unit_test(what_does_not_act_is_idle),
        cmocka_unit_test(bodies_end),
        cmocka_unit_test(geoms_end_with_their_contacts_alive),
        cmocka_unit_test(a_material_ends_with_its_geom),
        cmocka_unit_test(spaces_in_spaces_end),
        cmocka_unit_test(worlds_are_apart),
        cmocka_unit_test(a_callback_of_a_step),
        cmocka_unit_test(moved_callbacks_are_called),
        cmocka_unit_test(a_refused_step_is_odes),
        cmocka_unit_test(settings_are_checked),
        cmocka_unit_test(outside_of_the_scope_all_is_odes),
        cmocka_unit_test(materials_reach_the_contacts),
        cmocka_unit_test(no_name_outlives_its_geom),
    };
    return cmocka_run_group_tests(tests, start, end);
}
