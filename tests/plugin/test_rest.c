/*
 * A held object at rest stays where it is to the bit, its velocity is exactly zero, and its forces are those of a
 * verified solve. Any change ends the rest in the same step. A world beside it solves every step anew, and nothing else
 * may tell the two apart.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <math.h>
#include <string.h>

enum { FINGERS = 4, SETTLING = 600, AFTERWARDS = 40 };
static const double SIDE = 0.05, TIP = 0.01, STEP = 1e-3;

/* A cube between two static fingertips and two of a kinematic body; a fifth may come from below. */
typedef struct grip {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID cube, hand;
    dGeomID box, tip[FINGERS], fifth;
    bool fifth_comes, first_goes;
    double step;
    dJointID hinge; /* of the hand, where it has one */
    dJointFeedback feedback;
} grip;

static void set_mass(grip *g, double mass)
{
    dMass m;
    dMassSetBoxTotal(&m, mass, SIDE, SIDE, SIDE);
    dBodySetMass(g->cube, &m);
}

static void give_material(grip *g, dGeomID tip, double friction, double stiffness)
{
    pinch_material material = pinch_default_material();
    material.model = PINCH_CONTACT_SOFT;
    material.friction = material.friction_kinetic = friction;
    material.stiffness[0] = stiffness;
    assert_int_equal(pinch_ode_set_material(g->plugin, tip, &material), PINCH_OK);
}

static void make(grip *g, bool solve_at_rest, int threads)
{
    const double reach = 0.5 * SIDE + TIP - 5e-4;
    memset(g, 0, sizeof *g);
    g->step = STEP;
    g->world = dWorldCreate();
    dWorldSetGravity(g->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.solve_at_rest = solve_at_rest;
    settings.threads = threads;
    assert_int_equal(pinch_ode_create(g->world, &settings, &g->plugin), PINCH_OK);
    g->cube = dBodyCreate(g->world);
    set_mass(g, 0.2);
    dBodySetPosition(g->cube, 0.3, -0.1, 0.7);
    g->box = dCreateBox(NULL, SIDE, SIDE, SIDE);
    dGeomSetBody(g->box, g->cube);
    g->hand = dBodyCreate(g->world);
    dBodySetKinematic(g->hand);
    dBodySetPosition(g->hand, 0.3 + reach, -0.1, 0.7);
    for (int k = 0; k < FINGERS; k++) {
        g->tip[k] = dCreateSphere(NULL, TIP);
        give_material(g, g->tip[k], 0.5, 2e4);
        double aside = k % 2 ? 0.011 : -0.013;
        if (k < 2) {
            dGeomSetPosition(g->tip[k], 0.3 - reach, -0.1 + aside, 0.7);
        } else {
            dGeomSetBody(g->tip[k], g->hand);
            dGeomSetOffsetPosition(g->tip[k], 0, aside, 0.004);
        }
    }
    g->fifth = dCreateSphere(NULL, TIP);
    give_material(g, g->fifth, 0.5, 2e4);
    dGeomSetPosition(g->fifth, 0.3, -0.1, 0.7 - reach);
}

/* The hand on a hinge below it, which a motor turns against the cube. */
static void make_jointed(grip *g, bool solve_at_rest)
{
    make(g, solve_at_rest, 1);
    dMass m;
    dMassSetSphereTotal(&m, 0.1, 0.02);
    dBodySetDynamic(g->hand);
    dBodySetMass(g->hand, &m);
    const double *x = dBodyGetPosition(g->hand);
    g->hinge = dJointCreateHinge(g->world, NULL);
    dJointAttach(g->hinge, g->hand, NULL);
    dJointSetHingeAnchor(g->hinge, x[0], x[1], x[2] - 0.05);
    dJointSetHingeAxis(g->hinge, 0, -1, 0);
    dJointSetHingeParam(g->hinge, dParamVel, 0.5);
    dJointSetHingeParam(g->hinge, dParamFMax, 0.5);
    dJointSetFeedback(g->hinge, &g->feedback);
}

static void release(grip *g)
{
    pinch_ode_destroy(g->plugin);
    dGeomDestroy(g->box);
    dGeomDestroy(g->fifth);
    for (int k = 0; k < FINGERS; k++) dGeomDestroy(g->tip[k]);
    dWorldDestroy(g->world);
}

static void touch(grip *g, dGeomID tip)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    if (dCollide(g->box, tip, 1, &contact.geom, sizeof contact.geom) == 0) return;
    assert_int_equal(pinch_ode_add_contact(g->plugin, &contact, dGeomGetBody(g->box), dGeomGetBody(tip)), PINCH_OK);
}

static void step(grip *g)
{
    for (int k = g->first_goes; k < FINGERS; k++) touch(g, g->tip[k]);
    if (g->fifth_comes) touch(g, g->fifth);
    assert_int_equal(pinch_ode_step(g->plugin, g->step), PINCH_OK);
}

static void steps(grip *g, int count)
{
    for (int i = 0; i < count; i++) step(g);
}

/* Steps since the last call in which the island was as it had been. */
static long at_rest(grip *g)
{
    long count = pinch_ode_statistics(g->plugin).islands_at_rest;
    pinch_ode_reset_statistics(g->plugin);
    return count;
}

static void comes_to_rest(grip *g)
{
    steps(g, SETTLING);
    (void)at_rest(g);
    steps(g, 10);
    assert_int_equal(at_rest(g), 10);
}

static void test_poses_keep_their_bits(void **state)
{
    (void)state;
    grip g;
    make(&g, false, 1);
    steps(&g, SETTLING);
    double position[3], quaternion[4], force[3] = {0, 0, 0};
    memcpy(position, dBodyGetPosition(g.cube), sizeof position);
    memcpy(quaternion, dBodyGetQuaternion(g.cube), sizeof quaternion);
    for (int i = 0; i < 5000; i++) {
        step(&g);
        assert_memory_equal(dBodyGetPosition(g.cube), position, sizeof position);
        assert_memory_equal(dBodyGetQuaternion(g.cube), quaternion, sizeof quaternion);
        for (int k = 0; k < 3; k++)
            assert_true(dBodyGetLinearVel(g.cube)[k] == 0 && dBodyGetAngularVel(g.cube)[k] == 0);
    }
    assert_true(at_rest(&g) > 5000 - 10);
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(g.plugin, &list, &count), PINCH_OK);
    assert_int_equal(count, FINGERS);
    for (int k = 0; k < count; k++)
        for (int i = 0; i < 3; i++) force[i] += list[k].body1 == g.cube ? list[k].force[i] : -list[k].force[i];
    for (int i = 0; i < 3; i++) assert_true(fabs(force[i] - (i == 2 ? 0.2 * 9.81 : 0)) < 1e-10);
    release(&g);
}

static void push(grip *g)
{
    dBodyAddForce(g->cube, 0, 0, -1e-6);
}

static void turn(grip *g)
{
    dBodyAddTorque(g->cube, 1e-8, 0, 0);
}

static void kick(grip *g)
{
    dBodySetLinearVel(g->cube, 0, 0, 1e-9);
}

static void shift(grip *g)
{
    const double *x = dBodyGetPosition(g->cube);
    dBodySetPosition(g->cube, x[0], x[1], x[2] + 1e-12);
}

static void load(grip *g)
{
    set_mass(g, 0.21);
}

static void tilt_gravity(grip *g)
{
    dWorldSetGravity(g->world, 0.1, 0, -9.81);
}

static void end_weight(grip *g)
{
    dBodySetGravityMode(g->cube, 0);
}

static void oil(grip *g)
{
    for (int k = 0; k < FINGERS; k++) give_material(g, g->tip[k], 0.02, 2e4);
}

static void harden(grip *g)
{
    give_material(g, g->tip[0], 0.5, 3e4);
}

static void press(grip *g)
{
    const double *x = dGeomGetPosition(g->tip[0]);
    dGeomSetPosition(g->tip[0], x[0] + 1e-9, x[1], x[2]);
}

static void lift(grip *g)
{
    dBodySetLinearVel(g->hand, 0, 0, 1e-7);
}

static void drive(grip *g)
{
    const double axis[3] = {-1, 0, 0};
    assert_int_equal(pinch_ode_set_drive(g->plugin, g->hand, axis, 25), PINCH_OK);
}

static void slow_down(grip *g)
{
    g->step = 5e-4;
}

static void turn_on_a_hinge(grip *g)
{
    const double *x = dBodyGetPosition(g->cube);
    dJointID hinge = dJointCreateHinge(g->world, NULL);
    dJointAttach(hinge, g->cube, NULL);
    dJointSetHingeAnchor(hinge, x[0], x[1], x[2]);
    dJointSetHingeAxis(hinge, 1, 0, 0);
    dJointSetHingeParam(hinge, dParamVel, 1);
    dJointSetHingeParam(hinge, dParamFMax, 0.01);
}

static void bring_a_fifth(grip *g)
{
    g->fifth_comes = true;
}

static void take_one_away(grip *g)
{
    g->first_goes = true;
}

static void forget(grip *g)
{
    assert_int_equal(pinch_ode_forget_geom(g->plugin, g->tip[1]), PINCH_OK);
}

static void let_the_hand_go(grip *g)
{
    dBodySetDynamic(g->hand);
}

typedef struct cause {
    const char *name;
    void (*act)(grip *g);
} cause;

static const cause CAUSES[] = {
    {"a force", push},
    {"a torque", turn},
    {"a velocity", kick},
    {"a pose", shift},
    {"a mass", load},
    {"gravity", tilt_gravity},
    {"no gravity", end_weight},
    {"friction", oil},
    {"stiffness", harden},
    {"a static geom moves", press},
    {"a kinematic body moves", lift},
    {"force control", drive},
    {"another step", slow_down},
    {"a joint with a motor", turn_on_a_hinge},
    {"a new contact", bring_a_fifth},
    {"a contact less", take_one_away},
    {"a history that ends", forget},
    {"a kinematic body that becomes dynamic", let_the_hand_go},
};
enum { CAUSE_COUNT = sizeof CAUSES / sizeof CAUSES[0] };

static void weaken(grip *g)
{
    dJointSetHingeParam(g->hinge, dParamFMax, 0.499);
}

static void reverse(grip *g)
{
    dJointSetHingeParam(g->hinge, dParamVel, -0.5);
}

static void stop(grip *g)
{
    dJointSetHingeParam(g->hinge, dParamLoStop, dJointGetHingeAngle(g->hinge) + 1e-6);
}

static void add_torque(grip *g)
{
    dJointAddHingeTorque(g->hinge, 1e-7);
}

static void unhinge(grip *g)
{
    dJointDisable(g->hinge);
}

static void attach_to_the_cube(grip *g)
{
    dJointAttach(g->hinge, g->hand, g->cube);
}

static const cause JOINT_CAUSES[] = {
    {"a motor's force", weaken},
    {"a motor's speed", reverse},
    {"a stop", stop},
    {"a torque at the joint", add_torque},
    {"a joint disabled", unhinge},
    {"a joint between others", attach_to_the_cube},
};
enum { JOINT_CAUSE_COUNT = sizeof JOINT_CAUSES / sizeof JOINT_CAUSES[0] };

static const cause STOPPED_CAUSES[] = {{"a stopped motor's force", weaken}, {"a stopped motor's speed", reverse}};
enum { STOPPED_CAUSE_COUNT = sizeof STOPPED_CAUSES / sizeof STOPPED_CAUSES[0] };

static double largest_difference(const double *a, const double *b, int count)
{
    double largest = 0;
    for (int i = 0; i < count; i++) largest = fmax(largest, fabs(a[i] - b[i]));
    return largest;
}

/* The motor runs into a stop just before where it stands: further than what it may move by until it rests again, since
 * ODE's motors act otherwise at a stop. */
static void stop_the_motor(grip *g)
{
    dJointSetHingeParam(g->hinge, dParamHiStop, dJointGetHingeAngle(g->hinge) - 1e-9);
}

static void check_cause(const cause *c, bool jointed, bool at_stop)
{
    grip g, anew;
    print_message("%s\n", c->name);
    if (jointed) {
        make_jointed(&g, false);
        make_jointed(&anew, true);
    } else {
        make(&g, false, 1);
        make(&anew, true, 1);
    }
    comes_to_rest(&g);
    steps(&anew, SETTLING + 10);
    if (at_stop) {
        stop_the_motor(&g);
        stop_the_motor(&anew);
        comes_to_rest(&g);
        steps(&anew, SETTLING + 10);
    }
    assert_int_equal(at_rest(&anew), 0);
    c->act(&g);
    c->act(&anew);
    step(&g);
    step(&anew);
    assert_int_equal(at_rest(&g), 0);
    for (int i = 0; i < AFTERWARDS; i++) {
        step(&g);
        step(&anew);
        assert_true(largest_difference(dBodyGetPosition(g.cube), dBodyGetPosition(anew.cube), 3) < 5e-13);
        assert_true(largest_difference(dBodyGetQuaternion(g.cube), dBodyGetQuaternion(anew.cube), 4) < 1e-12);
        assert_true(largest_difference(dBodyGetLinearVel(g.cube), dBodyGetLinearVel(anew.cube), 3) < 1e-11);
    }
    release(&g);
    release(&anew);
}

static void test_whatever_changes_ends_it(void **state)
{
    (void)state;
    for (int k = 0; k < CAUSE_COUNT; k++) check_cause(&CAUSES[k], false, false);
}

static void test_joints_that_change_end_it(void **state)
{
    (void)state;
    for (int k = 0; k < JOINT_CAUSE_COUNT; k++) check_cause(&JOINT_CAUSES[k], true, false);
    /* there it has no row: ODE adds its force */
    for (int k = 0; k < STOPPED_CAUSE_COUNT; k++) check_cause(&STOPPED_CAUSES[k], true, true);
}

/* Joints at rest are found as the program left them, with their forces. */
static void test_joints_at_rest(void **state)
{
    (void)state;
    grip g;
    make_jointed(&g, false);
    comes_to_rest(&g);
    dJointFeedback before = g.feedback;
    assert_true(fabs(before.f1[0]) > 1);
    memset(&g.feedback, 0, sizeof g.feedback);
    step(&g);
    assert_int_equal(at_rest(&g), 1);
    for (int i = 0; i < 3; i++) assert_true(g.feedback.f1[i] == before.f1[i] && g.feedback.t1[i] == before.t1[i]);
    assert_true(dJointIsEnabled(g.hinge));
    release(&g);
}

/* A push and its end: rest, at the same place but for what slipped. */
static void test_rest_comes_back(void **state)
{
    (void)state;
    grip g;
    make(&g, false, 1);
    comes_to_rest(&g);
    double before[3];
    memcpy(before, dBodyGetPosition(g.cube), sizeof before);
    for (int i = 0; i < 100; i++) {
        dBodyAddForce(g.cube, 0.5, 0.2, -0.5);
        step(&g);
    }
    assert_true(largest_difference(dBodyGetPosition(g.cube), before, 3) > 1e-6);
    comes_to_rest(&g);
    assert_true(largest_difference(dBodyGetPosition(g.cube), before, 3) <
                1e-9); /* rolled to and fro: second order in 20 um */
    release(&g);
}

/* A force that is there in every step is part of the rest. */
static void test_rest_under_a_force(void **state)
{
    (void)state;
    grip g;
    make(&g, false, 1);
    for (int i = 0; i < SETTLING + 10; i++) {
        if (i == SETTLING) (void)at_rest(&g);
        dBodyAddForce(g.cube, 0.3, 0, -0.4);
        step(&g);
    }
    assert_int_equal(at_rest(&g), 10);
    step(&g);
    assert_int_equal(at_rest(&g), 0);
    release(&g);
}

static int moves;

static void count_move(dBodyID body)
{
    (void)body;
    moves++;
}

/* ODE's step leaves out what rests, and the program does not see it: its bodies are enabled, without forces left over.
 * A joint that comes to a resting body ends that. */
static void test_ode_leaves_out_what_rests(void **state)
{
    (void)state;
    for (int jointed = 0; jointed < 2; jointed++) {
        grip g;
        if (jointed)
            make_jointed(&g, false);
        else
            make(&g, false, 1);
        dBodySetMovedCallback(g.cube, count_move);
        comes_to_rest(&g);
        moves = 0;
        for (int i = 0; i < 10; i++) {
            step(&g);
            assert_true(dBodyIsEnabled(g.cube) && dBodyIsEnabled(g.hand));
            for (int k = 0; k < 3; k++) assert_true(dBodyGetForce(g.cube)[k] == 0 && dBodyGetTorque(g.cube)[k] == 0);
        }
        assert_int_equal(moves, 0);
        dBodyID weight = dBodyCreate(g.world); /* hangs from the cube */
        dBodySetPosition(weight, 0.3, -0.1, 0.5);
        dJointID rod = dJointCreateDBall(g.world, NULL);
        dJointAttach(rod, g.cube, weight);
        double z = dBodyGetPosition(g.cube)[2];
        steps(&g, 20);
        assert_true(dBodyGetPosition(g.cube)[2] < z);
        assert_int_equal(moves, 0); /* Pinch knows the joint, and moves the cube itself */
        release(&g);
    }
}

/* The oscillation that a slow force makes is seen from the first femtometres on. */
static void test_creeping_forces_are_followed(void **state)
{
    (void)state;
    grip g, anew;
    make(&g, false, 1);
    make(&anew, true, 1);
    comes_to_rest(&g);
    steps(&anew, SETTLING + 10);
    double z = dBodyGetPosition(g.cube)[2];
    for (int i = 0; i < 2000; i++) {
        dBodyAddForce(g.cube, 0, 0, -1e-10 * i); /* 1e-7 N/s */
        dBodyAddForce(anew.cube, 0, 0, -1e-10 * i);
        step(&g);
        step(&anew);
    }
    double moved = z - dBodyGetPosition(g.cube)[2], expected = 2e-7 / (4 * pinch_default_material().stiffness[1]);
    assert_true(fabs(moved - expected) < 0.02 * expected);
    assert_true(largest_difference(dBodyGetPosition(g.cube), dBodyGetPosition(anew.cube), 3) < 1e-15);
    release(&g);
    release(&anew);
}

static dBodyID add_block(const grip *g)
{
    dBodyID block = dBodyCreate(g->world);
    dMass m;
    dMassSetBoxTotal(&m, 1, SIDE, SIDE, SIDE);
    dBodySetMass(block, &m);
    return block;
}

/* Hands over a contact of a block's corner with the ground, without geoms and with a first friction direction of its
 * own. */
static void support(grip *g, dBodyID block, int corner)
{
    const double side[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    dContact contact;
    dVector3 place;
    memset(&contact, 0, sizeof contact);
    dBodyGetRelPointPos(block, 0.5 * SIDE * side[corner][0], 0.5 * SIDE * side[corner][1], -0.5 * SIDE, place);
    if (place[2] > 0) return;
    memcpy(contact.geom.pos, place, 3 * sizeof place[0]);
    contact.geom.depth = -place[2];
    contact.geom.normal[2] = 1;
    contact.surface.mode = dContactFDir1;
    contact.surface.mu = 0.5;
    contact.fdir1[0] = 1, contact.fdir1[1] = 0.1 * corner;
    assert_int_equal(pinch_ode_add_contact(g->plugin, &contact, block, NULL), PINCH_OK);
}

/* Spaces put the geoms of bodies that move first, and so the contacts of others come in another order. Those of one
 * pair keep theirs. */
static void test_any_order_of_contacts_is_the_same_rest(void **state)
{
    enum { ORDERS = 3, CORNER = FINGERS, STEPS = 60 };
    static const int orders[ORDERS][2 * FINGERS] = {
        {0, 4, 1, 5, 2, 6, 3, 7}, {2, 3, 0, 1, 4, 5, 6, 7}, {4, 5, 1, 0, 6, 3, 7, 2}};
    (void)state;
    grip g;
    make(&g, false, 1);
    dBodyID block = add_block(&g);
    dBodySetPosition(block, 1, 1, 0.5 * SIDE);
    for (int i = 0; i < SETTLING + STEPS; i++) {
        if (i == SETTLING) (void)at_rest(&g);
        for (int k = 0; k < 2 * FINGERS; k++) {
            int which = orders[i < SETTLING ? 0 : i % ORDERS][k];
            if (which < CORNER)
                touch(&g, g.tip[which]);
            else
                support(&g, block, which - CORNER);
        }
        assert_int_equal(pinch_ode_step(g.plugin, g.step), PINCH_OK);
    }
    assert_int_equal(at_rest(&g), 2 * STEPS);
    release(&g);
}

/* A block is put down on one to four corners and lifted again, so that its pair comes, changes and goes, and with it
 * its island. What is gripped rests in every step, and its contacts are reported as they were. */
static void test_rest_while_others_come_and_go(void **state)
{
    enum { STEPS = 120, CORNERS = 4 };
    (void)state;
    grip g;
    make(&g, false, 1);
    dBodyID block = add_block(&g);
    double before[FINGERS] = {0};
    for (int i = 0; i < SETTLING + STEPS; i++) {
        int corners = i < SETTLING ? 1 : (i - SETTLING + 2) % (CORNERS + 1); /* its pair is the first until it goes */
        if (i == SETTLING) (void)at_rest(&g);
        for (int k = 0; k < corners; k++) support(&g, block, k);
        for (int k = 0; k < FINGERS; k++) touch(&g, g.tip[k]);
        dBodySetPosition(block, 1, 1, 0.5 * SIDE - 1e-4 * (i % 7));
        dBodySetLinearVel(block, 0, 0, 0);
        dBodySetAngularVel(block, 0, 0, 0);
        assert_int_equal(pinch_ode_step(g.plugin, g.step), PINCH_OK);
        int seen = 0, count;
        const pinch_ode_contact *c;
        assert_int_equal(pinch_ode_contacts(g.plugin, &c, &count), PINCH_OK);
        for (int k = 0; k < count; k++, c++) {
            for (int finger = 0; finger < FINGERS; finger++) {
                if (c->geom1 != g.tip[finger] && c->geom2 != g.tip[finger]) continue;
                if (i >= SETTLING) assert_true(c->normal_force == before[finger] && c->normal_force > 0);
                before[finger] = c->normal_force;
                seen++;
            }
        }
        assert_int_equal(seen, FINGERS);
    }
    assert_true(at_rest(&g) >= STEPS);
    release(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_poses_keep_their_bits),
        cmocka_unit_test(test_whatever_changes_ends_it),
        cmocka_unit_test(test_joints_that_change_end_it),
        cmocka_unit_test(test_joints_at_rest),
        cmocka_unit_test(test_rest_comes_back),
        cmocka_unit_test(test_rest_under_a_force),
        cmocka_unit_test(test_ode_leaves_out_what_rests),
        cmocka_unit_test(test_creeping_forces_are_followed),
        cmocka_unit_test(test_any_order_of_contacts_is_the_same_rest),
        cmocka_unit_test(test_rest_while_others_come_and_go),
    };
    dInitODE();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
