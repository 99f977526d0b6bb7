/*
 * Programs destroy bodies, geoms and joints at any time: between steps, while contacts are being made, and between
 * these and the step. ODE makes what comes next where that was, or elsewhere. Two worlds in which the same things
 * happen, one of which holds the memory that others leave, have to agree to the bit, and what is gone may be in no
 * contact.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <ode/ode.h>

#include <pinch/ode_dropin.h>
#include <string.h>

enum { COUNT = 14, STEPS = 400, MOST_HELD = 1 << 19, MOST_GROUPS = 4096 };

/* When things are replaced. */
typedef enum moment_kind { BETWEEN_STEPS, AMONG_CONTACTS, BEFORE_THE_STEP } moment_kind;

/* Body k has geom k and maybe a joint to the body before it. The last geom is the ground. They are in no space, so that
 * they may go while pairs are looked at. */
typedef struct crowd {
    dWorldID world;
    dJointGroupID contacts;
    dGeomID geoms[COUNT + 1];
    dBodyID bodies[COUNT];
    dJointID joints[COUNT];      /* NULL: none */
    dJointGroupID groups[COUNT]; /* that the joints are alone in; NULL: in none */
    dJointGroupID emptied[MOST_GROUPS];
    int emptied_count, held_count;
    pinch_random random;
    moment_kind moment;
    void **held;   /* NULL: nothing is held */
    void *left[3]; /* where the geom, the body and the joint were that went last */
    int again[3];  /* how often the next one came there */
} crowd;

/* Takes blocks of all sizes that what was destroyed may have had. */
static void hold(crowd *c)
{
    for (size_t size = 16; size <= 2048 && c->held; size += 16) {
        assert_true(c->held_count < MOST_HELD);
        c->held[c->held_count] = malloc(size);
        assert_non_null(c->held[c->held_count++]);
    }
}

/* ---- what comes and goes ---- */

static void destroy_joint(crowd *c, int k)
{
    if (!c->joints[k]) return;
    c->left[2] = c->joints[k];
    if (c->groups[k]) {
        assert_true(c->emptied_count < MOST_GROUPS);
        dJointGroupEmpty(c->groups[k]);
        c->emptied[c->emptied_count++] = c->groups[k];
    } else {
        dJointDestroy(c->joints[k]);
    }
    c->joints[k] = NULL;
    hold(c);
}

/* A group has its joints in the same place again, and so is not used again where memory is held. */
static dJointGroupID take_group(crowd *c)
{
    if (c->emptied_count > 0 && !c->held) return c->emptied[--c->emptied_count];
    return dJointGroupCreate(0);
}

static void make_joint(crowd *c, int k, int kind)
{
    const dReal *x = dBodyGetPosition(c->bodies[k]);
    c->groups[k] = draw_chance(&c->random, 0.5) ? take_group(c) : NULL;
    dJointID joint = kind == 0   ? dJointCreateHinge(c->world, c->groups[k])
                     : kind == 1 ? dJointCreateSlider(c->world, c->groups[k])
                                 : dJointCreateFixed(c->world, c->groups[k]);
    c->joints[k] = joint;
    c->again[2] += joint == c->left[2];
    dJointAttach(joint, c->bodies[k], c->bodies[k - 1]);
    double force = draw_uniform(&c->random, 0, 2), along = draw_uniform(&c->random, -1, 1);
    if (kind == 0) {
        dJointSetHingeAnchor(joint, x[0], x[1], x[2] + 0.1);
        dJointSetHingeAxis(joint, 0, along, 1);
        dJointSetHingeParam(joint, dParamFMax, 0.1 * force);
        dJointSetHingeParam(joint, dParamLoStop, -0.3);
        dJointSetHingeParam(joint, dParamHiStop, 0.3);
    } else if (kind == 1) {
        dJointSetSliderAxis(joint, along, 0, 1);
        dJointSetSliderParam(joint, dParamFMax, force);
        dJointSetSliderParam(joint, dParamLoStop, -0.05);
        dJointSetSliderParam(joint, dParamHiStop, 0.05);
    } else {
        dJointSetFixed(joint);
    }
}

static void destroy_geom(crowd *c, int k)
{
    c->left[0] = c->geoms[k];
    dGeomDestroy(c->geoms[k]);
    hold(c);
}

static void make_geom(crowd *c, int k)
{
    double size = draw_uniform(&c->random, 0.1, 0.2);
    bool round = draw_chance(&c->random, 0.5);
    c->geoms[k] = round ? dCreateSphere(NULL, 0.5 * size) : dCreateBox(NULL, size, size, size);
    c->again[0] += c->geoms[k] == c->left[0];
    dGeomSetBody(c->geoms[k], c->bodies[k]);
}

static void destroy_body(crowd *c, int k)
{
    c->left[1] = c->bodies[k];
    dBodyDestroy(c->bodies[k]);
    hold(c);
}

static void make_body(crowd *c, int k)
{
    dMass mass;
    c->bodies[k] = dBodyCreate(c->world);
    c->again[1] += c->bodies[k] == c->left[1];
    dMassSetBoxTotal(&mass, draw_uniform(&c->random, 0.5, 2), 0.15, 0.15, 0.15);
    dBodySetMass(c->bodies[k], &mass);
    double x = draw_uniform(&c->random, -0.3, 0.3), y = draw_uniform(&c->random, -0.3, 0.3);
    dBodySetPosition(c->bodies[k], x, y, draw_uniform(&c->random, 0.1, 0.5));
    dBodySetAutoDisableFlag(c->bodies[k], k % 4 == 0);
}

/* A joint whose body goes is destroyed before, or ties the next body as it tied the one before, with what ODE has kept
 * of it. */
static void replace_body(crowd *c, int k)
{
    bool stays[2] = {draw_chance(&c->random, 0.5), draw_chance(&c->random, 0.5)};
    bool with_geom = draw_chance(&c->random, 0.7);
    for (int i = 0; i < 2 && k + i < COUNT; i++)
        if (!stays[i]) destroy_joint(c, k + i);
    if (with_geom) destroy_geom(c, k);
    destroy_body(c, k);
    make_body(c, k);
    if (with_geom)
        make_geom(c, k);
    else
        dGeomSetBody(c->geoms[k], c->bodies[k]);
    for (int i = 0; i < 2 && k + i < COUNT; i++)
        if (c->joints[k + i]) dJointAttach(c->joints[k + i], c->bodies[k + i], c->bodies[k + i - 1]);
}

/* Mostly by one of its kind, which is as large. */
static void replace_joint(crowd *c, int k)
{
    static const int kinds[3] = {dJointTypeHinge, dJointTypeSlider, dJointTypeFixed};
    int kind = draw_index(&c->random, 3);
    for (int i = 0; i < 3 && c->joints[k] && draw_chance(&c->random, 0.9); i++)
        if ((int)dJointGetType(c->joints[k]) == kinds[i]) kind = i;
    destroy_joint(c, k);
    if (k > 0 && draw_chance(&c->random, 0.8)) make_joint(c, k, kind);
}

static void replace_geom(crowd *c, int k)
{
    destroy_geom(c, k);
    make_geom(c, k);
}

static void replace_something(crowd *c, int k)
{
    int which = draw_index(&c->random, 4);
    if (which == 0)
        replace_body(c, k);
    else if (which == 1)
        replace_geom(c, k);
    else
        replace_joint(c, k);
}

/* ---- steps ---- */

static void near_callback(void *context, dGeomID a, dGeomID b)
{
    crowd *c = context;
    dContact contact[4];
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, 4, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface = (dSurfaceParameters){.mode = dContactApprox1, .mu = 0.6};
        dJointAttach(dJointCreateContact(c->world, c->contacts, &contact[i]), dGeomGetBody(a), dGeomGetBody(b));
    }
}

static void make_contacts(crowd *c)
{
    for (int i = 0; i < COUNT; i++)
        for (int k = i + 1; k <= COUNT; k++) {
            dSpaceCollide2(c->geoms[i], c->geoms[k], c, near_callback);
            if (c->moment != AMONG_CONTACTS || !draw_chance(&c->random, 0.003)) continue;
            replace_something(c, draw_chance(&c->random, 0.5) ? i : k < COUNT ? k : 0);
        }
}

static bool is_alive(const crowd *c, dGeomID geom, dBodyID body)
{
    bool has_geom = !geom, has_body = !body;
    for (int k = 0; k <= COUNT; k++) has_geom = has_geom || c->geoms[k] == geom;
    for (int k = 0; k < COUNT; k++) has_body = has_body || c->bodies[k] == body;
    return has_geom && has_body;
}

static void step(crowd *c)
{
    const pinch_ode_contact *list;
    int count;
    bool replaces = c->moment != AMONG_CONTACTS && draw_chance(&c->random, 0.3);
    if (c->moment == BETWEEN_STEPS && replaces) replace_something(c, draw_index(&c->random, COUNT));
    make_contacts(c);
    if (c->moment == BEFORE_THE_STEP && replaces) replace_something(c, draw_index(&c->random, COUNT));
    assert_int_equal(dWorldQuickStep(c->world, 0.004), 1);
    dJointGroupEmpty(c->contacts);
    assert_int_equal(pinch_dropin_contacts(c->world, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++)
        assert_true(is_alive(c, list[i].geom1, list[i].body1) && is_alive(c, list[i].geom2, list[i].body2));
}

static void start(crowd *c, moment_kind moment, bool holds)
{
    *c = (crowd){.world = dWorldCreate(), .contacts = dJointGroupCreate(0), .moment = moment};
    pinch_random_seed(&c->random, 7 + (uint64_t)moment);
    dRandSetSeed(1);
    dWorldSetGravity(c->world, 0, 0, -9.81);
    c->geoms[COUNT] = dCreatePlane(NULL, 0, 0, 1, 0);
    c->held = holds ? calloc(MOST_HELD, sizeof *c->held) : NULL;
    for (int k = 0; k < COUNT; k++) {
        make_body(c, k);
        make_geom(c, k);
        if (k > 0 && k % 3 != 0) make_joint(c, k, k % 3 - 1);
    }
    memset(c->again, 0, sizeof c->again);
}

static void end(crowd *c)
{
    for (int k = 0; k < COUNT; k++) {
        destroy_joint(c, k);
        destroy_geom(c, k);
    }
    dGeomDestroy(c->geoms[COUNT]);
    for (int i = 0; i < c->emptied_count; i++) dJointGroupDestroy(c->emptied[i]);
    dJointGroupDestroy(c->contacts);
    dWorldDestroy(c->world);
    for (int i = 0; i < c->held_count; i++) free(c->held[i]);
    free(c->held);
}

typedef struct seen {
    double body[COUNT][13];
} seen;

static void run(moment_kind moment, bool holds, seen *s)
{
    static crowd c;
    start(&c, moment, holds);
    for (int i = 0; i < STEPS; i++) {
        step(&c);
        for (int k = 0; k < COUNT; k++) {
            memcpy(s[i].body[k], dBodyGetPosition(c.bodies[k]), 3 * sizeof(double));
            memcpy(s[i].body[k] + 3, dBodyGetQuaternion(c.bodies[k]), 4 * sizeof(double));
            memcpy(s[i].body[k] + 7, dBodyGetLinearVel(c.bodies[k]), 3 * sizeof(double));
            memcpy(s[i].body[k] + 10, dBodyGetAngularVel(c.bodies[k]), 3 * sizeof(double));
        }
    }
    print_message("made in the place of the last one: %d geoms, %d bodies, %d joints\n", c.again[0], c.again[1],
                  c.again[2]);
    end(&c);
}

static void check_bits(moment_kind moment)
{
    seen *one = calloc(STEPS, sizeof *one), *other = calloc(STEPS, sizeof *other);
    assert_non_null(one);
    assert_non_null(other);
    run(moment, false, one);
    run(moment, true, other);
    for (int i = 0; i < STEPS; i++) assert_memory_equal(&one[i], &other[i], sizeof *one);
    free(one);
    free(other);
}

static void test_between_steps(void **state)
{
    (void)state;
    check_bits(BETWEEN_STEPS);
}

static void test_among_contacts(void **state)
{
    (void)state;
    check_bits(AMONG_CONTACTS);
}

static void test_before_the_step(void **state)
{
    (void)state;
    check_bits(BEFORE_THE_STEP);
}

static void make_contacts_with_ground(void *context, dGeomID a, dGeomID b)
{
    if (dGeomIsSpace(a) || dGeomIsSpace(b))
        dSpaceCollide2(a, b, context, make_contacts_with_ground);
    else
        near_callback(context, a, b);
}

/* A space takes its geoms with it after contacts with them were made: also one that does not tell which these are. What
 * comes in their place is not in these contacts, which go on pressing as in ODE. */
static void check_space_that_goes(dSpaceID space, dSpaceID outer)
{
    enum { TILES = 9 };
    crowd c = {.world = dWorldCreate(), .contacts = dJointGroupCreate(0)};
    dGeomID tiles[TILES], others[TILES], balls[TILES];
    dBodyID body = NULL;
    const pinch_ode_contact *list;
    int count;
    dWorldSetGravity(c.world, 0, 0, -9.81);
    for (int k = 0; k < TILES; k++) {
        tiles[k] = dCreateBox(space, 1, 1, 0.2);
        dGeomSetPosition(tiles[k], k % 3 - 1, k / 3 - 1, -0.1);
        balls[k] = dCreateSphere(NULL, 0.1);
        body = dBodyCreate(c.world);
        dGeomSetBody(balls[k], body);
        dBodySetPosition(body, k % 3 - 1, k / 3 - 1, 0.0999);
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < TILES; k++)
            dSpaceCollide2(balls[k], (dGeomID)(outer ? outer : space), &c, make_contacts_with_ground);
        for (int k = 0; k < TILES && i == 2; k++) {
            if (k == 0) dSpaceDestroy(outer ? outer : space);
            others[k] = dCreatePlane(NULL, 0, 0, 1, -1);
        }
        assert_int_equal(dWorldQuickStep(c.world, 0.004), 1);
        dJointGroupEmpty(c.contacts);
        assert_int_equal(pinch_dropin_contacts(c.world, &list, &count), PINCH_OK);
        assert_true(count >= TILES);
        for (int j = 0; j < count; j++)
            for (int k = 0; k < TILES; k++) {
                assert_true(i < 2 || (list[j].geom1 != tiles[k] && list[j].geom2 != tiles[k]));
                assert_true(i < 2 || (list[j].geom1 != others[k] && list[j].geom2 != others[k]));
            }
        assert_true(fabs(dBodyGetLinearVel(body)[2]) < 0.02);
    }
    for (int k = 0; k < TILES; k++) {
        dGeomDestroy(balls[k]);
        dGeomDestroy(others[k]);
    }
    dJointGroupDestroy(c.contacts);
    dWorldDestroy(c.world);
}

static void test_spaces_that_go_before_the_step(void **state)
{
    static const dVector3 centre = {0, 0, 0}, extents = {10, 10, 10};
    (void)state;
    check_space_that_goes(dHashSpaceCreate(NULL), NULL);
    check_space_that_goes(dQuadTreeSpaceCreate(NULL, centre, extents, 4), NULL);
    dSpaceID outer = dSimpleSpaceCreate(NULL);
    check_space_that_goes(dQuadTreeSpaceCreate(outer, centre, extents, 4), outer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_between_steps),
        cmocka_unit_test(test_among_contacts),
        cmocka_unit_test(test_before_the_step),
        cmocka_unit_test(test_spaces_that_go_before_the_step),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
