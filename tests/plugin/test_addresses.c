/*
 * What is made after something was destroyed lies where that was, or elsewhere. Two worlds in which the same things
 * happen, one of which holds the memory that others leave, have to agree to the bit.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <stdlib.h>
#include <string.h>

enum { MOST = 24, STEPS = 600, MOST_HELD = 1 << 17, WALLS = 5 };

/* When bodies come and go. */
typedef enum moment_kind { BETWEEN_STEPS, AMONG_CONTACTS, BEFORE_THE_STEP } moment_kind;

typedef struct crowd {
    dWorldID world;
    dSpaceID space;
    dGeomID walls[WALLS];
    pinch_ode *plugin;
    moment_kind moment;
    dBodyID bodies[MOST];
    dJointID joints[MOST]; /* between a body and the one before it; NULL: none */
    int count;
    unsigned long state;
    void **held; /* NULL: nothing is held */
    int held_count;
    int places_taken_again;
    void *left; /* where the last body that was destroyed was */
} crowd;

static double draw(crowd *c, double low, double high)
{
    c->state = c->state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(c->state >> 11) * 0x1p-53;
}

/* Takes blocks of all sizes that what was destroyed may have had. */
static void hold(crowd *c)
{
    for (size_t size = 16; size <= 2048 && c->held && c->held_count < MOST_HELD; size += 16) {
        c->held[c->held_count] = malloc(size);
        assert_non_null(c->held[c->held_count++]);
    }
}

static void forget_geoms(crowd *c, dBodyID body)
{
    for (dGeomID geom = dBodyGetFirstGeom(body); geom; geom = dBodyGetFirstGeom(body)) {
        assert_int_equal(pinch_ode_forget_geom(c->plugin, geom), PINCH_OK);
        dGeomDestroy(geom);
    }
}

static void destroy_joint(crowd *c, int k)
{
    if (!c->joints[k]) return;
    assert_int_equal(pinch_ode_forget_joint(c->plugin, c->joints[k]), PINCH_OK);
    dJointDestroy(c->joints[k]);
    c->joints[k] = NULL;
}

static void join(crowd *c, int k)
{
    const dReal *x = dBodyGetPosition(c->bodies[k]);
    dJointID joint = dJointCreateHinge(c->world, NULL);
    dJointAttach(joint, c->bodies[k], c->bodies[k - 1]);
    dJointSetHingeAnchor(joint, x[0], x[1], x[2] + 0.1);
    dJointSetHingeAxis(joint, 0, draw(c, -1, 1), 1);
    dJointSetHingeParam(joint, dParamFMax, draw(c, 0, 0.1));
    if (draw(c, 0, 1) < 0.5) assert_int_equal(pinch_ode_note_joint(c->plugin, joint), PINCH_OK);
    c->joints[k] = joint;
}

static void make_body(crowd *c)
{
    dMass mass;
    double size = draw(c, 0.1, 0.2);
    dBodyID body = dBodyCreate(c->world);
    c->places_taken_again += body == c->left;
    dGeomID geom = draw(c, 0, 1) < 0.5 ? dCreateSphere(c->space, 0.5 * size) : dCreateBox(c->space, size, size, size);
    dMassSetBoxTotal(&mass, draw(c, 0.5, 2), size, size, size);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    double x = draw(c, -0.4, 0.4), y = draw(c, -0.4, 0.4);
    dBodySetPosition(body, x, y, draw(c, 0.2, 0.8));
    dBodySetAutoDisableFlag(body, c->count % 4 == 0);
    c->bodies[c->count] = body;
    c->joints[c->count++] = NULL;
    if (c->count > 1 && draw(c, 0, 1) < 0.3) join(c, c->count - 1);
}

static void destroy_body(crowd *c, int k)
{
    dBodyID body = c->bodies[k];
    destroy_joint(c, k);
    if (k + 1 < c->count) destroy_joint(c, k + 1);
    forget_geoms(c, body);
    assert_int_equal(pinch_ode_forget_body(c->plugin, body), PINCH_OK);
    c->left = body;
    dBodyDestroy(body);
    c->count--;
    for (; k < c->count; k++) c->bodies[k] = c->bodies[k + 1], c->joints[k] = c->joints[k + 1];
    hold(c);
}

static int meet(void *context, dGeomID a, dGeomID b, int room, dContact *contacts)
{
    (void)context;
    int count = dCollide(a, b, room, &contacts->geom, sizeof *contacts);
    for (int i = 0; i < count; i++) contacts[i].surface = (dSurfaceParameters){.mode = dContactApprox1, .mu = 0.6};
    return count;
}

static void come_and_go(crowd *c, double likely)
{
    bool goes = c->count == MOST || draw(c, 0, 1) < 0.5;
    if (draw(c, 0, 1) < likely && goes && c->count > 2) destroy_body(c, (int)draw(c, 0, c->count));
    if (draw(c, 0, 1) < likely && c->count < MOST) make_body(c);
}

static void hand_over(crowd *c, dGeomID a, dGeomID b)
{
    dContact contacts[8];
    memset(contacts, 0, sizeof contacts);
    int count = meet(NULL, a, b, 8, contacts);
    for (int i = 0; i < count; i++)
        assert_int_equal(pinch_ode_add_contact(c->plugin, &contacts[i], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
}

/* Hands over the contacts of each body in its turn. Bodies come and go meanwhile. */
static void hand_over_one_by_one(crowd *c)
{
    for (int i = 0; i < c->count; i++) {
        dGeomID geom = dBodyGetFirstGeom(c->bodies[i]);
        for (int k = 0; k < WALLS; k++) hand_over(c, geom, c->walls[k]);
        for (int k = 0; k < i; k++) hand_over(c, geom, dBodyGetFirstGeom(c->bodies[k]));
        come_and_go(c, 0.03);
    }
}

/* Nothing that is gone may have been in a contact. */
static void look_for_the_gone(const crowd *c)
{
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(c->plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++) {
        bool alive[2] = {!list[i].body1, !list[i].body2};
        for (int k = 0; k < c->count; k++) {
            alive[0] = alive[0] || c->bodies[k] == list[i].body1;
            alive[1] = alive[1] || c->bodies[k] == list[i].body2;
        }
        assert_true(alive[0] && alive[1]);
    }
}

static void step(crowd *c)
{
    if (c->moment == BETWEEN_STEPS) come_and_go(c, 0.3);
    if (c->moment == AMONG_CONTACTS)
        hand_over_one_by_one(c);
    else
        assert_int_equal(pinch_ode_collide(c->plugin, c->space, 8, meet, NULL), PINCH_OK);
    for (int k = 0; k < c->count; k++) assert_int_equal(pinch_ode_add_body(c->plugin, c->bodies[k]), PINCH_OK);
    if (c->moment == BEFORE_THE_STEP) come_and_go(c, 0.3);
    assert_int_equal(pinch_ode_step(c->plugin, 0.004), PINCH_OK);
    look_for_the_gone(c);
}

static void start(crowd *c, moment_kind moment, bool holds)
{
    *c = (crowd){.world = dWorldCreate(), .space = dHashSpaceCreate(NULL), .state = 5, .moment = moment};
    dRandSetSeed(1); /* quickstep draws */
    dWorldSetGravity(c->world, 0, 0, -9.81);
    c->walls[4] = dCreatePlane(c->space, 0, 0, 1, 0);
    for (int i = 0; i < 4; i++) c->walls[i] = dCreatePlane(c->space, (i == 0) - (i == 1), (i == 2) - (i == 3), 0, -0.5);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    assert_int_equal(pinch_ode_create(c->world, &settings, &c->plugin), PINCH_OK);
    c->held = holds ? calloc(MOST_HELD, sizeof *c->held) : NULL;
    for (int k = 0; k < 12; k++) make_body(c);
}

static void end(crowd *c)
{
    pinch_ode_destroy(c->plugin);
    dSpaceDestroy(c->space);
    dWorldDestroy(c->world);
    for (int i = 0; i < c->held_count; i++) free(c->held[i]);
    free(c->held);
}

/* The bodies of a step. */
typedef struct seen {
    int count;
    double body[MOST][13];
} seen;

static void look_at(const crowd *c, seen *s)
{
    s->count = c->count;
    for (int k = 0; k < c->count; k++) {
        memcpy(s->body[k], dBodyGetPosition(c->bodies[k]), 3 * sizeof(double));
        memcpy(s->body[k] + 3, dBodyGetQuaternion(c->bodies[k]), 4 * sizeof(double));
        memcpy(s->body[k] + 7, dBodyGetLinearVel(c->bodies[k]), 3 * sizeof(double));
        memcpy(s->body[k] + 10, dBodyGetAngularVel(c->bodies[k]), 3 * sizeof(double));
    }
}

/* Returns how many bodies were made where the one was that was destroyed before. */
static int run(moment_kind moment, bool holds, seen *s)
{
    crowd c;
    start(&c, moment, holds);
    for (int i = 0; i < STEPS; i++) {
        step(&c);
        look_at(&c, &s[i]);
    }
    end(&c);
    return c.places_taken_again;
}

static void check_bits(moment_kind moment)
{
    seen *one = calloc(STEPS, sizeof *one), *other = calloc(STEPS, sizeof *other);
    assert_non_null(one);
    assert_non_null(other);
    int again = run(moment, false, one), elsewhere = run(moment, true, other);
    print_message("made in the place of the last one: %d and %d\n", again, elsewhere);
    for (int i = 0; i < STEPS; i++) assert_memory_equal(&one[i], &other[i], sizeof *one);
    free(one);
    free(other);
}

static void test_bits_do_not_depend_on_addresses(void **state)
{
    (void)state;
    check_bits(BETWEEN_STEPS);
}

/* Contacts with what goes have been handed over for the same step. */
static void test_what_goes_among_contacts(void **state)
{
    (void)state;
    check_bits(AMONG_CONTACTS);
}

static void test_what_goes_before_the_step(void **state)
{
    (void)state;
    check_bits(BEFORE_THE_STEP);
}

static void test_wrong_calls_are_refused(void **state)
{
    (void)state;
    crowd c;
    start(&c, BETWEEN_STEPS, false);
    dJointID joint = dJointCreateBall(c.world, NULL);
    assert_int_equal(pinch_ode_forget_body(NULL, c.bodies[0]), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_forget_body(c.plugin, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_forget_joint(NULL, joint), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_forget_joint(c.plugin, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_solve(c.plugin, 0.004), PINCH_OK);
    assert_int_equal(pinch_ode_forget_body(c.plugin, c.bodies[0]), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_forget_joint(c.plugin, joint), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(c.plugin, 0.004), PINCH_OK);
    assert_int_equal(pinch_ode_forget_joint(c.plugin, joint), PINCH_OK);
    end(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bits_do_not_depend_on_addresses),
        cmocka_unit_test(test_what_goes_among_contacts),
        cmocka_unit_test(test_what_goes_before_the_step),
        cmocka_unit_test(test_wrong_calls_are_refused),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
