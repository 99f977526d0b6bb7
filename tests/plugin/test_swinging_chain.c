/*
 * A jointed chain whips about a ball. Its joints must drift no more by Pinch's solve than by ODE's. Chains with heavy
 * bodies are torn in large steps, by ODE as well: they must come back, with no more energy than they began with.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

/* A chain that hangs from the world or a body, on hinges, universal and ball joints in turn. */
enum { LINKS = 6 };
static const double LENGTH = 0.1; /* m */

typedef struct chain {
    dBodyID link[LINKS];
    dJointID joint[LINKS];
    double axis[LINKS][2][3]; /* of the hinges, in the frames of the two bodies */
} chain;

static void to_frame(dBodyID body, const double axis[3], double out[3])
{
    dVector3 v;
    dBodyVectorFromWorld(body, axis[0], axis[1], axis[2], v);
    for (int i = 0; i < 3; i++) out[i] = body ? v[i] : axis[i];
}

/* Stretched out along x from (x, 0, z) on. */
static void chain_make(chain *c, dWorldID world, dBodyID from, double x, double z)
{
    memset(c, 0, sizeof *c);
    for (int k = 0; k < LINKS; k++) {
        dMass mass;
        dMassSetBoxTotal(&mass, 0.1, LENGTH, 0.02, 0.03);
        c->link[k] = dBodyCreate(world);
        dBodySetMass(c->link[k], &mass);
        dBodySetPosition(c->link[k], x + (k + 0.5) * LENGTH, 0, z);
        dBodyID above = k > 0 ? c->link[k - 1] : from;
        double at = x + k * LENGTH;
        const double axis[3] = {0, 0.8, k == 4 ? 0.6 : -0.6};
        switch (k % 4) {
        case 0:
        case 1:
            c->joint[k] = dJointCreateHinge(world, NULL);
            dJointAttach(c->joint[k], c->link[k], above);
            dJointSetHingeAnchor(c->joint[k], at, 0, z);
            dJointSetHingeAxis(c->joint[k], axis[0], axis[1], axis[2]);
            to_frame(c->link[k], axis, c->axis[k][0]);
            memcpy(c->axis[k][1], axis, sizeof axis); /* the links are made unturned */
            break;
        case 2:
            c->joint[k] = dJointCreateUniversal(world, NULL);
            dJointAttach(c->joint[k], above, c->link[k]);
            dJointSetUniversalAnchor(c->joint[k], at, 0, z);
            dJointSetUniversalAxis1(c->joint[k], 0, 0, 1);
            dJointSetUniversalAxis2(c->joint[k], 0, 1, 0);
            break;
        default:
            c->joint[k] = dJointCreateBall(world, NULL);
            dJointAttach(c->joint[k], c->link[k], above);
            dJointSetBallAnchor(c->joint[k], at, 0, z);
        }
    }
}

/* How far apart the links' ends are, m, and the hinges' axes, rad; the largest. */
static void chain_errors(const chain *c, dBodyID from, double x, double z, double *gap, double *tilt)
{
    for (int k = 0; k < LINKS; k++) {
        dVector3 mine, its = {x, 0, z};
        dBodyID above = k > 0 ? c->link[k - 1] : from;
        dBodyGetRelPointPos(c->link[k], -0.5 * LENGTH, 0, 0, mine);
        if (k > 0)
            dBodyGetRelPointPos(above, 0.5 * LENGTH, 0, 0, its);
        else if (from)
            dBodyGetRelPointPos(from, 0, 0, 0, its);
        *gap = fmax(*gap, dCalcPointsDistance3(mine, its));
        if (k % 4 > 1) continue;
        dVector3 a, b, across;
        const double *one = c->axis[k][0], *two = c->axis[k][1];
        dBodyVectorToWorld(c->link[k], one[0], one[1], one[2], a);
        memcpy(b, two, 3 * sizeof *two);
        if (above) dBodyVectorToWorld(above, two[0], two[1], two[2], b);
        dCalcVectorCross3(across, a, b);
        *tilt = fmax(*tilt, dCalcVectorLength3(across));
    }
}

static double kinetic_and_height(dBodyID body)
{
    dMass mass;
    dVector3 w, L;
    dBodyGetMass(body, &mass);
    const double *v = dBodyGetLinearVel(body), *turn = dBodyGetAngularVel(body);
    dBodyVectorFromWorld(body, turn[0], turn[1], turn[2], w);
    dMultiply0_331(L, mass.I, w);
    return 0.5 * mass.mass * dCalcVectorDot3(v, v) + 0.5 * dCalcVectorDot3(w, L) +
           9.81 * mass.mass * dBodyGetPosition(body)[2];
}

typedef struct swing {
    double gap, tilt;  /* m, rad: the largest */
    double start, top; /* J: energy, and the most of it */
    long solved, left; /* joints */
} swing;

/* A ball on the ground, heavy against the chain that swings from its centre, through everything, for five seconds. */
static swing swing_chain(pinch_ode_stepper stepper, bool by_ode)
{
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -9.81);
    dGeomID ground = dCreatePlane(NULL, 0, 0, 1, 0), geom = dCreateSphere(NULL, 0.1);
    dBodyID ball = dBodyCreate(world);
    dMass mass;
    dMassSetSphereTotal(&mass, 3, 0.1);
    dBodySetMass(ball, &mass);
    dBodySetPosition(ball, 0, 0, 0.1);
    dGeomSetBody(geom, ball);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    settings.joints_by_ode = by_ode;
    pinch_ode *plugin;
    assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_OK);
    pinch_material material = pinch_default_material();
    assert_int_equal(pinch_ode_set_material(plugin, ground, &material), PINCH_OK);
    chain c;
    chain_make(&c, world, ball, 0, 0.1);
    swing s = {0, 0, 0, -INFINITY, 0, 0};
    for (int step = 0; step < 5000; step++) {
        dContact contact[4];
        memset(contact, 0, sizeof contact);
        int count = dCollide(ground, geom, 4, &contact[0].geom, sizeof contact[0]);
        for (int k = 0; k < count; k++)
            assert_int_equal(pinch_ode_add_contact(plugin, &contact[k], NULL, ball), PINCH_OK);
        double energy = kinetic_and_height(ball);
        for (int k = 0; k < LINKS; k++) energy += kinetic_and_height(c.link[k]);
        if (step == 0) s.start = energy;
        s.top = fmax(s.top, energy);
        assert_int_equal(pinch_ode_step(plugin, STEP), PINCH_OK);
        chain_errors(&c, ball, 0, 0, &s.gap, &s.tilt);
    }
    pinch_ode_stats stats = pinch_ode_statistics(plugin);
    assert_int_equal(stats.fallback_islands, 0);
    s.solved = stats.joints_solved;
    s.left = stats.joints_left;
    pinch_ode_destroy(plugin);
    dGeomDestroy(geom);
    dGeomDestroy(ground);
    dWorldDestroy(world);
    return s;
}

/* The chain whips about, so that runs of other bits part: compared is what they have in common. The largest tilt of
 * such a run is a matter of its bits, too; ODE's alone has been 0.0101 and 0.0120 rad. */
static void test_swinging_chain(void **state)
{
    (void)state;
    swing theirs = swing_chain(PINCH_ODE_WORLDSTEP, true);
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        swing ours = swing_chain(stepper, false);
        assert_true(ours.solved > 4500 * LINKS && ours.left == 0);
        assert_true(ours.gap < 1.5 * theirs.gap && ours.tilt < 1.5 * theirs.tilt);
        assert_true(ours.top <= ours.start && theirs.top <= theirs.start);
    }
}

/* ---- heavy chains ---- */

enum { MOST_LINKS = 12 };
static const double LINK = 0.3; /* m */

/* Links of 1 kg that ball joints hang from the world, one of them a heavy ball. */
typedef struct heavy_chain {
    dWorldID world;
    dBodyID body[MOST_LINKS];
    dJointID joint[MOST_LINKS + 1];
    int bodies, joints;
    double at[3]; /* where its end is, while it is made */
} heavy_chain;

static void tie(heavy_chain *c, dBodyID next)
{
    dJointID joint = dJointCreateBall(c->world, NULL);
    dJointAttach(joint, next, c->bodies > 0 ? c->body[c->bodies - 1] : NULL);
    dJointSetBallAnchor(joint, c->at[0], c->at[1], c->at[2]);
    c->joint[c->joints++] = joint;
}

/* Adds a link that rises by an angle (rad) in the plane of x and z. mass: of a ball in its place, 0 for none. */
static void add_link(heavy_chain *c, double length, double angle, double mass)
{
    double along[3] = {length * cos(angle), 0, length * sin(angle)};
    dBodyID body = dBodyCreate(c->world);
    dMass m;
    dQuaternion turn;
    if (mass > 0)
        dMassSetSphereTotal(&m, mass, 0.3);
    else
        dMassSetCapsuleTotal(&m, 1, 3, 0.04, 0.2);
    dBodySetMass(body, &m);
    dQFromAxisAndAngle(turn, 0, 1, 0, 0.5 * M_PI - angle);
    dBodySetQuaternion(body, turn);
    dBodySetPosition(body, c->at[0] + 0.5 * along[0], 0, c->at[2] + 0.5 * along[2]);
    tie(c, body);
    c->body[c->bodies++] = body;
    for (int i = 0; i < 3; i++) c->at[i] += along[i];
}

static double heavy_energy(const heavy_chain *c)
{
    double energy = 0;
    for (int k = 0; k < c->bodies; k++) energy += kinetic_and_height(c->body[k]);
    return energy;
}

static double heavy_gap(const heavy_chain *c)
{
    double gap = 0;
    for (int k = 0; k < c->joints; k++) {
        dVector3 one, two;
        dJointGetBallAnchor(c->joint[k], one);
        dJointGetBallAnchor2(c->joint[k], two);
        gap = fmax(gap, dCalcPointsDistance3(one, two));
    }
    return gap;
}

/* Lets a chain go for 20 s at 10 ms. Returns the largest gap of the last 10 s. */
static double let_go(heavy_chain *c, pinch_ode_stepper stepper)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    pinch_ode *plugin;
    assert_int_equal(pinch_ode_create(c->world, &settings, &plugin), PINCH_OK);
    double gap = 0, start = heavy_energy(c);
    for (int step = 0; step < 2000; step++) {
        for (int k = 0; k < c->bodies; k++) assert_int_equal(pinch_ode_add_body(plugin, c->body[k]), PINCH_OK);
        assert_int_equal(pinch_ode_step(plugin, 0.01), PINCH_OK);
        assert_true(heavy_energy(c) <= start);
        if (step >= 1000) gap = fmax(gap, heavy_gap(c));
    }
    assert_true(pinch_ode_statistics(plugin).joints_solved > 1000 * c->joints);
    pinch_ode_destroy(plugin);
    dWorldDestroy(c->world);
    return gap;
}

static heavy_chain heavy_chain_begin(void)
{
    heavy_chain c = {.world = dWorldCreate()};
    dWorldSetGravity(c.world, 0, 0, -9.81);
    return c;
}

/* 100 kg at the end of five links, let go horizontally. Its joints came apart by 5.5 and 6.4 m, more in each second;
 * by ODE it is 0.5 and 0.8 m. */
static void test_heavy_end(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        heavy_chain c = heavy_chain_begin();
        for (int k = 0; k < 5; k++) add_link(&c, LINK, 0, 0);
        add_link(&c, 0.6, 0, 100);
        double gap = let_go(&c, stepper);
        if (!(gap < 1.5)) fail_msg("a gap of %g m", gap);
    }
}

/* 300 kg in the middle of eleven links that hang from both ends, and are slack at first: a loop by the world. Its
 * joints came apart by 120 m; by ODE it is 4 m. */
static void test_heavy_middle(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        heavy_chain c = heavy_chain_begin();
        for (int k = 0; k < 11; k++) add_link(&c, LINK, k % 2 ? -1 : 1, k == 5 ? 300 : 0);
        dBodySetLinearVel(c.body[5], 0, 3, 0);
        tie(&c, NULL);
        double gap = let_go(&c, stepper);
        if (!(gap < 6)) fail_msg("a gap of %g m", gap);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_swinging_chain),
        cmocka_unit_test(test_heavy_end),
        cmocka_unit_test(test_heavy_middle),
    };
    int failed = cmocka_run_group_tests_name("a swinging chain", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
