/*
 * Contacts get their laws from ODE's surface parameters, in real worlds. Closed forms say what rests, slides and
 * bounces, and what the joints' feedback must be.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode.h>

#include <math.h>
#include <stddef.h>
#include <string.h>

enum { MAX_POINTS = 8, MAX_BODIES = 12 };
static const double G = 9.81;

typedef struct arena {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    pinch_ode *plugin;
    dGeomID ground;
    dBodyID body[MAX_BODIES];
    int count;
    dSurfaceParameters surface, odd_surface;
    dBodyID odd_one; /* NULL: all have the first surface */
    dVector3 fdir1;
    dJointFeedback feedback[64];
    int joints;
    double step, depth; /* the largest of the last step */
    double margin;      /* m: contacts are handed over with minus this for their depth; 0: as found */
} arena;

static void arena_make(arena *a, double step)
{
    memset(a, 0, sizeof *a);
    a->step = step;
    a->world = dWorldCreate();
    a->space = dSimpleSpaceCreate(NULL);
    a->contacts = dJointGroupCreate(0);
    a->ground = dCreatePlane(a->space, 0, 0, 1, 0);
    dWorldSetGravity(a->world, 0, 0, -G);
    a->surface.mode = dContactApprox1;
    a->surface.mu = 0.5;
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(a->world, &settings, &a->plugin), PINCH_OK);
}

static void arena_free(arena *a)
{
    pinch_ode_stats stats = pinch_ode_statistics(a->plugin);
    assert_int_equal(stats.contacts_left, 0);
    assert_int_equal(stats.fallback_islands, 0);
    assert_int_equal(stats.joints_unmodelled, 0);
    pinch_ode_destroy(a->plugin);
    dJointGroupDestroy(a->contacts);
    dSpaceDestroy(a->space);
    dWorldDestroy(a->world);
}

static dBodyID add_body(arena *a, dGeomID geom, const dMass *mass, double x, double y, double z)
{
    dBodyID body = dBodyCreate(a->world);
    dBodySetMass(body, mass);
    dBodySetPosition(body, x, y, z);
    dGeomSetBody(geom, body);
    a->body[a->count++] = body;
    return body;
}

static dBodyID add_box(arena *a, double size, double mass, double x, double z)
{
    dMass m;
    dMassSetBoxTotal(&m, mass, size, size, size);
    return add_body(a, dCreateBox(a->space, size, size, size), &m, x, 0, z);
}

static dBodyID add_sphere(arena *a, double radius, double mass, double z)
{
    dMass m;
    dMassSetSphereTotal(&m, mass, radius);
    return add_body(a, dCreateSphere(a->space, radius), &m, 0, 0, z);
}

/* As a program does that makes contact joints. */
static void near_callback(void *data, dGeomID g1, dGeomID g2)
{
    arena *a = data;
    dContact contact[MAX_POINTS];
    dBodyID b1 = dGeomGetBody(g1), b2 = dGeomGetBody(g2);
    if (!b1 && !b2) return;
    memset(contact, 0, sizeof contact);
    int count = dCollide(g1, g2, MAX_POINTS, &contact[0].geom, sizeof *contact);
    for (int i = 0; i < count; i++) {
        contact[i].surface = a->odd_one && (b1 == a->odd_one || b2 == a->odd_one) ? a->odd_surface : a->surface;
        memcpy(contact[i].fdir1, a->fdir1, sizeof contact[i].fdir1);
        a->depth = fmax(a->depth, contact[i].geom.depth);
        if (a->margin > 0) contact[i].geom.depth = -a->margin;
        dJointID joint = dJointCreateContact(a->world, a->contacts, &contact[i]);
        dJointAttach(joint, b1, b2);
        dJointSetFeedback(joint, &a->feedback[a->joints++]);
        assert_int_equal(pinch_ode_add_joint(a->plugin, joint, &contact[i]), PINCH_OK);
    }
}

static void arena_run(arena *a, double time)
{
    long steps = lround(time / a->step);
    for (long i = 0; i < steps; i++) {
        a->joints = 0;
        a->depth = 0;
        dSpaceCollide(a->space, a, near_callback);
        assert_int_equal(pinch_ode_step(a->plugin, a->step), PINCH_OK);
        dJointGroupEmpty(a->contacts);
    }
}

static double speed_of(dBodyID body)
{
    const double *v = dBodyGetLinearVel(body);
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double kinetic_energy(const arena *a)
{
    double sum = 0;
    for (int i = 0; i < a->count; i++) {
        dMass m;
        const double *w = dBodyGetAngularVel(a->body[i]);
        dBodyGetMass(a->body[i], &m);
        sum += 0.5 * m.mass * speed_of(a->body[i]) * speed_of(a->body[i]) +
               0.5 * m.I[0] * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]); /* cubes and balls */
    }
    return sum;
}

static void test_stack_stands_still(void **state)
{
    (void)state;
    const double steps[2] = {0.01, 0.001};
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, steps[k]);
        for (int i = 0; i < 10; i++) add_box(&a, 1, 1, 0, 0.5 + i);
        arena_run(&a, 3);
        double before[3];
        memcpy(before, dBodyGetPosition(a.body[9]), sizeof before);
        arena_run(&a, 4);
        for (int i = 0; i < 3; i++) assert_true(fabs(dBodyGetPosition(a.body[9])[i] - before[i]) <= 1e-9);
        assert_true(kinetic_energy(&a) <= 1e-12);
        arena_free(&a);
    }
}

static void test_heavy_on_light(void **state)
{
    (void)state;
    const double steps[2] = {0.01, 0.001};
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, steps[k]);
        add_box(&a, 1, 1, 0, 0.5);
        add_box(&a, 1, 1000, 0, 1.5);
        arena_run(&a, 5);
        assert_true(dBodyGetPosition(a.body[1])[2] > 1.5 - 2e-3); /* each contact may give 1e-3 of the size */
        assert_true(kinetic_energy(&a) <= 1e-12);
        arena_free(&a);
    }
}

static void test_feedback_sums_to_the_weight(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.005);
    add_box(&a, 0.4, 3, 0, 0.2);
    arena_run(&a, 2);
    double force[3] = {0}, torque[3] = {0};
    assert_true(a.joints >= 3);
    for (int j = 0; j < a.joints; j++)
        for (int i = 0; i < 3; i++) {
            force[i] += a.feedback[j].f1[i];
            torque[i] += a.feedback[j].t1[i];
            assert_true(a.feedback[j].f2[i] == 0 && a.feedback[j].t2[i] == 0);
        }
    assert_true(fabs(fabs(force[2]) - 3 * G) <= 1e-9);
    assert_true(hypot(force[0], force[1]) <= 1e-9 && fabs(torque[0]) + fabs(torque[1]) + fabs(torque[2]) <= 1e-9);
    arena_free(&a);
}

/* The plane tilted by turning gravity over 5 s, along a direction of the plane that is no axis of anything. */
static void tilt(arena *a, double degrees, double direction)
{
    const double angle = degrees * M_PI / 180;
    const int parts = 500;
    arena_run(a, 1);
    for (int i = 1; i <= parts; i++) {
        double s = sin(angle * i / parts);
        dWorldSetGravity(a->world, G * s * cos(direction), G * s * sin(direction), -G * cos(angle * i / parts));
        arena_run(a, 5.0 / parts);
    }
}

static void test_slope(void **state)
{
    (void)state;
    const double mu = 0.5, limit = atan(mu) * 180 / M_PI, directions[2] = {0.6, M_PI / 4};
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, 0.01);
        a.surface.mu = mu;
        dBodyID box = add_box(&a, 0.5, 2, 0, 0.25);
        tilt(&a, limit - 0.01, directions[k]);
        arena_run(&a, 10);
        assert_true(speed_of(box) < 1e-9);
        arena_free(&a);

        arena_make(&a, 0.01);
        a.surface.mu = mu;
        box = add_box(&a, 0.5, 2, 0, 0.25);
        tilt(&a, limit + 0.01, directions[k]);
        double x = dBodyGetPosition(box)[0], y = dBodyGetPosition(box)[1];
        arena_run(&a, 2);
        assert_true(hypot(dBodyGetPosition(box)[0] - x, dBodyGetPosition(box)[1] - y) > 1e-3);
        arena_free(&a);
    }
}

static void test_sliding_acceleration(void **state)
{
    (void)state;
    const double mu = 0.3, angle = atan(mu) + 5 * M_PI / 180;
    arena a;
    arena_make(&a, 0.001);
    a.surface.mu = mu;
    dBodyID box = add_box(&a, 0.5, 2, 0, 0.25);
    arena_run(&a, 1);
    dWorldSetGravity(a.world, G * sin(angle) * cos(0.7), G * sin(angle) * sin(0.7), -G * cos(angle));
    arena_run(&a, 0.5);
    double v = speed_of(box);
    arena_run(&a, 1);
    double expected = G * (sin(angle) - mu * cos(angle));
    assert_true(fabs(speed_of(box) - v - expected) <= 1e-3 * expected);
    assert_true(fabs(atan2(dBodyGetLinearVel(box)[1], dBodyGetLinearVel(box)[0]) - 0.7) < 1e-6);
    arena_free(&a);
}

/* Without Approx1 mu is a force for each contact: four of them resist four times as much. */
static void test_friction_as_a_force(void **state)
{
    (void)state;
    const double push[2] = {1.98, 2.02};
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, 0.005);
        a.surface.mode = 0;
        a.surface.mu = 0.5;
        dBodyID box = add_box(&a, 0.4, 3, 0, 0.2);
        arena_run(&a, 1);
        assert_int_equal(a.joints, 4);
        double x = dBodyGetPosition(box)[0];
        for (int i = 0; i < 200; i++) {
            dBodyAddForce(box, push[k], 0, 0);
            arena_run(&a, 0.005);
        }
        double moved = dBodyGetPosition(box)[0] - x;
        assert_true(k == 0 ? moved < 1e-3 : moved > 2e-3);
        arena_free(&a);
    }
}

static void test_unlimited_friction_holds(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.005);
    a.surface.mode = 0;
    a.surface.mu = dInfinity;
    dBodyID box = add_box(&a, 0.4, 1, 0, 0.2);
    arena_run(&a, 1);
    dWorldSetGravity(a.world, 0.8 * G, 0, -G); /* just short of tipping over its edge */
    arena_run(&a, 5);
    assert_true(speed_of(box) < 1e-9);
    assert_true(fabs(dBodyGetPosition(box)[0]) < 1e-3);
    arena_free(&a);
}

static void test_conveyor(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.005);
    a.surface.mode |= dContactMotion1 | dContactFDir1;
    a.surface.motion1 = 0.7;
    a.fdir1[1] = 1;
    dBodyID box = add_box(&a, 0.4, 1, 0, 0.2);
    arena_run(&a, 3);
    /* of the two geoms either may be the first: the box is carried one way or the other */
    assert_true(fabs(fabs(dBodyGetLinearVel(box)[1]) - 0.7) < 1e-6);
    assert_true(fabs(dBodyGetLinearVel(box)[0]) < 1e-9);
    arena_free(&a);
}

static void test_bounce(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.0005);
    a.surface.mode |= dContactBounce;
    a.surface.bounce = 0.6;
    a.surface.bounce_vel = 0.1;
    dBodyID ball = add_sphere(&a, 0.1, 1, 1.1); /* falls 1 m */
    double highest = 0, before = -1;
    arena_run(&a, sqrt(2 / G) + 0.01);
    for (int i = 0; i < 2000 && dBodyGetPosition(ball)[2] > before; i++) {
        before = dBodyGetPosition(ball)[2];
        arena_run(&a, 0.0005);
        highest = fmax(highest, dBodyGetPosition(ball)[2] - 0.1);
    }
    assert_true(fabs(highest - 0.36) < 0.005); /* 0.6^2 of the fall */
    arena_run(&a, 4);
    assert_true(speed_of(ball) < 1e-9);
    arena_free(&a);
}

/* A bounce of more than 1, which ODE's manual does not have, is an elastic one. */
static void test_no_bounce_is_more_than_elastic(void **state)
{
    (void)state;
    static const double BOUNCES[] = {1, 1.001, 1.5};
    double speeds[3];
    for (int i = 0; i < 3; i++) {
        arena a;
        arena_make(&a, 0.001);
        dWorldSetGravity(a.world, 0, 0, 0);
        a.surface.mode |= dContactBounce;
        a.surface.bounce = BOUNCES[i];
        dBodyID ball = add_sphere(&a, 0.1, 1, 0.15);
        dBodySetLinearVel(ball, 0, 0, -1);
        arena_run(&a, 0.1);
        speeds[i] = dBodyGetLinearVel(ball)[2];
        arena_free(&a);
    }
    assert_true(fabs(speeds[0] - 1) < 1e-6);
    assert_true(speeds[1] == speeds[0] && speeds[2] == speeds[0]);
}

/* What contacts give way by takes nothing of a bounce, neither of a box that lands on four corners, nor of a chain of
 * balls, each half as heavy as the one before it, in which v_last = v ((1 + e)/1.5)^n. */
static void test_bounces_are_exact(void **state)
{
    (void)state;
    enum { BALLS = 5 };
    for (int k = 0; k < 12; k++) {
        double e = (double[]){1, 0.8, 0.3}[k % 3], scale = k < 6 ? 1 : 1e-3;
        bool chain = k / 3 % 2;
        arena a;
        arena_make(&a, 0.001);
        dWorldSetGravity(a.world, 0, 0, 0);
        a.surface.mode |= dContactBounce;
        a.surface.bounce = e;
        dBodyID body = chain ? NULL : add_box(&a, 0.4, 3 * scale, 0, 0.2055);
        for (int i = 0; i < BALLS && chain; i++) body = add_sphere(&a, 0.1, scale * pow(0.5, i), 1 + 0.21 * i);
        dBodySetLinearVel(a.body[0], 0, 0, chain ? 2 : -2);
        arena_run(&a, 0.1);
        double expected = 2 * (chain ? pow((1 + e) / 1.5, BALLS - 1) : e);
        assert_true(fabs(dBodyGetLinearVel(body)[2] / expected - 1) < 1e-6);
        arena_free(&a);
    }
}

/* A surface that moves along its normal is a bat: v+ = e (v + u) + u. */
static void test_bats_are_exact(void **state)
{
    (void)state;
    for (int k = 0; k < 9; k++) {
        double e = (double[]){1, 0.7, 0.3}[k % 3], u = (double[]){0.1, 0.5, 3}[k / 3], expected = e * (2 + u) + u;
        arena a;
        arena_make(&a, 0.002);
        dWorldSetGravity(a.world, 0, 0, 0);
        a.surface.mode |= dContactBounce | dContactMotionN;
        a.surface.bounce = e;
        a.surface.motionN = u;
        dBodyID ball = add_sphere(&a, 0.05, 1, 0.15);
        dBodySetLinearVel(ball, 0, 0, -2);
        while (dBodyGetLinearVel(ball)[2] < 0) arena_run(&a, 0.002);
        assert_true(fabs(dBodyGetLinearVel(ball)[2] / expected - 1) < 1e-6);
        arena_free(&a);
    }
}

/* What bounces at any speed comes to rest all the same, and exactly. */
static void test_what_bounces_comes_to_rest(void **state)
{
    (void)state;
    for (int k = 0; k < 6; k++) {
        arena a;
        arena_make(&a, k % 2 ? 0.005 : 0.001);
        a.surface.mode |= dContactBounce;
        a.surface.bounce = (double[]){0.3, 0.5, 0.8}[k / 2];
        (void)add_sphere(&a, 0.05, 1, 0.3);
        (void)add_box(&a, 0.2, 1, 1, 0.3);
        (void)add_box(&a, 0.2, 1, 1.02, 0.55);
        arena_run(&a, 8);
        for (int i = 0; i < a.count; i++) assert_true(speed_of(a.body[i]) == 0);
        arena_free(&a);
    }
}

/* A cube with contacts at random points, some of which contradict each other, turning and bouncing. */
static void add_random_contacts(arena *a, pinch_random *random)
{
    int count = 2 + draw_index(random, 5);
    a->surface.mu = draw_chance(random, 0.2) ? dInfinity : draw_uniform(random, 0, 1.5);
    for (int k = 0; k < count; k++) {
        dContact contact = {.surface = a->surface};
        double inward[3];
        draw_direction(random, inward);
        for (int i = 0; i < 3; i++) contact.geom.pos[i] = -0.1 * inward[i];
        draw_tangent(random, inward, contact.geom.normal);
        double slope = draw_uniform(random, 0, 1.5);
        for (int i = 0; i < 3; i++) contact.geom.normal[i] = inward[i] + slope * contact.geom.normal[i];
        double size = length(contact.geom.normal);
        for (int i = 0; i < 3; i++) contact.geom.normal[i] /= size;
        contact.geom.depth = 1e-6;
        contact.surface.bounce = draw_uniform(random, 0, 0.95);
        assert_int_equal(pinch_ode_add_contact(a->plugin, &contact, a->body[0], NULL), PINCH_OK);
    }
}

/*
 * A bounce gives back a part of what it takes. Newton's law of impact asks for more where contacts jam a body, or where
 * there is friction: of 2,000 such impacts, 28 gave energy, at most 3 times what there was.
 */
static void test_bounces_give_no_energy(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 17);
    int bounced = 0, draws = draw_count(20000);
    for (int k = 0; k < draws; k++) {
        arena a;
        arena_make(&a, 0.005);
        dWorldSetGravity(a.world, 0, 0, 0);
        a.surface.mode |= dContactBounce;
        a.surface.bounce_vel = 0.01;
        dBodyID cube = add_box(&a, 0.2, 1, 0, 0);
        double v[3], w[3];
        draw_direction(&random, v);
        draw_direction(&random, w);
        dBodySetLinearVel(cube, v[0], v[1], v[2]);
        dBodySetAngularVel(cube, 15 * w[0], 15 * w[1], 15 * w[2]);
        double before = kinetic_energy(&a);
        add_random_contacts(&a, &random);
        assert_int_equal(pinch_ode_step(a.plugin, a.step), PINCH_OK);
        double after = kinetic_energy(&a);
        if (!(after <= 1.0001 * before)) print_error("draw %d: %g J, %g before\n", k, after, before);
        assert_true(after <= 1.0001 * before);
        bounced += after > 0.1 * before;
        arena_free(&a);
    }
    assert_true(bounced > draws / 4);
}

/* Force-dependent slip: a steady force drifts at slip times the force of each contact. */
/* Lets a box that spins fall onto the ground at a slant, with others beside it that do the same, and their contacts
 * between its own. Writes where it comes to. */
static void drop_beside(const dSurfaceParameters *all, const dSurfaceParameters *own, int others, double *end)
{
    arena a;
    arena_make(&a, 0.002);
    a.surface = *all;
    a.odd_surface = *own;
    for (int k = 0; k <= others; k++) {
        dBodyID body = add_box(&a, 0.1, 1, k - others / 2, 0.06);
        dBodySetLinearVel(body, 0.6, 0.4, -0.5);
        dBodySetAngularVel(body, 2, -3, 4);
        if (k == others / 2) a.odd_one = body;
    }
    arena_run(&a, 0.2);
    memcpy(end, dBodyGetPosition(a.odd_one), 3 * sizeof *end);
    memcpy(end + 3, dBodyGetQuaternion(a.odd_one), 4 * sizeof *end);
    memcpy(end + 7, dBodyGetLinearVel(a.odd_one), 3 * sizeof *end);
    memcpy(end + 10, dBodyGetAngularVel(a.odd_one), 3 * sizeof *end);
    arena_free(&a);
}

/* Contacts whose surfaces differ by one parameter come one after the other, and each has its own. */
static void test_each_contact_has_its_own_surface(void **state)
{
    (void)state;
    enum { NUMBERS = 13 };
    const dSurfaceParameters all = {.mode = dContactApprox1 | dContactMu2 | dContactBounce | dContactSoftERP |
                                            dContactSoftCFM | dContactMotion1 | dContactMotion2 | dContactMotionN |
                                            dContactSlip1 | dContactSlip2 | dContactRolling,
                                    .mu = 0.5,
                                    .mu2 = 0.5,
                                    .rho = 0.01,
                                    .rho2 = 0.01,
                                    .rhoN = 0.01,
                                    .bounce = 0.3,
                                    .bounce_vel = 0.01,
                                    .soft_erp = 0.3,
                                    .soft_cfm = 1e-4,
                                    .slip1 = 1e-3,
                                    .slip2 = 1e-3};
    const struct {
        size_t at;
        dReal value;
    } other[] = {{offsetof(dSurfaceParameters, mu), 0.2},        {offsetof(dSurfaceParameters, mu2), 0.2},
                 {offsetof(dSurfaceParameters, rho), 0.05},      {offsetof(dSurfaceParameters, rho2), 0.05},
                 {offsetof(dSurfaceParameters, rhoN), 0.05},     {offsetof(dSurfaceParameters, bounce), 0.6},
                 {offsetof(dSurfaceParameters, bounce_vel), 1},  {offsetof(dSurfaceParameters, soft_erp), 0.6},
                 {offsetof(dSurfaceParameters, soft_cfm), 2e-4}, {offsetof(dSurfaceParameters, motion1), 0.1},
                 {offsetof(dSurfaceParameters, motion2), 0.1},   {offsetof(dSurfaceParameters, motionN), 0.1},
                 {offsetof(dSurfaceParameters, slip1), 2e-3},    {offsetof(dSurfaceParameters, slip2), 2e-3}};
    double usual[NUMBERS], alone[NUMBERS], beside[NUMBERS];
    drop_beside(&all, &all, 0, usual);
    for (size_t k = 0; k < sizeof other / sizeof *other; k++) {
        dSurfaceParameters own = all;
        memcpy((char *)&own + other[k].at, &other[k].value, sizeof other[k].value);
        drop_beside(&all, &own, 0, alone);
        drop_beside(&all, &own, 4, beside);
        assert_memory_equal(alone, beside, sizeof alone);
        assert_memory_not_equal(alone, usual, sizeof alone);
    }
}

static void test_slip(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.005);
    a.surface.mode |= dContactSlip1 | dContactSlip2;
    a.surface.slip1 = a.surface.slip2 = 0.2;
    dBodyID box = add_box(&a, 0.4, 2, 0, 0.2);
    for (int i = 0; i < 1000; i++) {
        dBodyAddForce(box, 3, 0, 0);
        arena_run(&a, 0.005);
    }
    assert_true(fabs(dBodyGetLinearVel(box)[0] - 0.2 * 3 / 4) < 1e-6);
    arena_free(&a);
}

/* Rolling friction: its moment stays within an ellipse with the semi-axes rho, about fdir1, and rho2, about the other
 * tangent, times the normal force. A ball stays on slopes below that, whichever way they fall, and rolls down above:
 * where rho and rho2 are alike straight, and by (7/5) a = g (slope - rho/r). */
static void test_rolling_friction(void **state)
{
    (void)state;
    const double radius = 0.2, degrees[] = {0, 20, 45, 70, 90, 200}, rho[2][2] = {{0.01, 0.01}, {0.01, 0.02}};
    for (int k = 0; k < 24; k++) {
        const double *r = rho[k % 2], angle = degrees[k / 4] * M_PI / 180, c = cos(angle), s = sin(angle);
        double limit = 1 / (radius * hypot(s / r[0], c / r[1])), slope = (k % 4 < 2 ? 0.95 : 1.05) * limit;
        arena a;
        arena_make(&a, 0.005);
        a.surface.mode |= dContactRolling | dContactFDir1 | dContactAxisDep;
        a.surface.mu2 = a.surface.mu;
        a.surface.rho = r[0];
        a.surface.rho2 = r[1];
        a.fdir1[0] = 1;
        dBodyID ball = add_sphere(&a, radius, 1, radius);
        arena_run(&a, 1);
        dWorldSetGravity(a.world, G * slope * c, G * slope * s, -G);
        arena_run(&a, 4);
        const double *v = dBodyGetLinearVel(ball);
        double along = (v[0] * c + v[1] * s) / 4, expected = G * (slope - limit) / 1.4;
        if (slope < limit)
            assert_true(speed_of(ball) < 1e-9);
        else
            assert_true(along > 0.5 * expected);
        if (slope > limit && r[0] == r[1]) {
            assert_true(fabs(along - expected) < 1e-3 * G * limit);
            assert_true(fabs(v[1] * c - v[0] * s) < 1e-9 * along);
        }
        arena_free(&a);
    }
}

/* ERP 1 and 0, CFM 0: limits, not numbers to divide by. */
static void test_extreme_parameters(void **state)
{
    (void)state;
    const double erp[4] = {1, 0, 0.2, 1}, cfm[4] = {0, 0, 0, 1e-3};
    for (int k = 0; k < 4; k++) {
        arena a;
        arena_make(&a, 0.005);
        a.surface.mode |= dContactSoftERP | dContactSoftCFM;
        a.surface.soft_erp = erp[k];
        a.surface.soft_cfm = cfm[k];
        dBodyID box = add_box(&a, 0.4, 1, 0, 0.1999);
        arena_run(&a, 2);
        assert_true(speed_of(box) < (erp[k] == 0 ? 1e-2 : 1e-9)); /* without a spring what is left is a slow damper */
        if (erp[k] > 0) assert_true(dBodyGetPosition(box)[2] > 0.19);
        arena_free(&a);
    }
}

static void test_sleeping_and_waking(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.01);
    dWorldSetAutoDisableFlag(a.world, 1);
    dBodyID low = add_box(&a, 0.4, 1, 0, 0.2), high = add_box(&a, 0.4, 1, 0, 0.6);
    arena_run(&a, 3);
    assert_false(dBodyIsEnabled(low));
    assert_false(dBodyIsEnabled(high));
    for (int i = 0; i < 3; i++) assert_true(dBodyGetForce(low)[i] == 0 && dBodyGetForce(high)[i] == 0);
    double z = dBodyGetPosition(high)[2];
    arena_run(&a, 1);
    assert_true(dBodyGetPosition(high)[2] == z);
    assert_true(pinch_ode_statistics(a.plugin).contacts_asleep > 0);
    dBodyID ball = add_sphere(&a, 0.1, 0.5, 1.5);
    dBodySetPosition(ball, 0.05, 0, 1.5);
    arena_run(&a, 0.5);
    assert_true(dBodyIsEnabled(low) && dBodyIsEnabled(high));
    arena_free(&a);
}

/*
 * Colliders of a program's own may have a safety margin, and give a gap for the depth that ODE takes for none. What
 * holds then takes nothing back, and gives way by the compliance floor: 1e-4 of g h, times the boxes above and some for
 * the points' shares, 1e-4 m in 3 s. By the gap, it would be 0.2 * 1 mm in each step, 60 mm.
 */
static void test_a_gap_holds(void **state)
{
    (void)state;
    arena a;
    arena_make(&a, 0.01);
    a.margin = 1e-3;
    dBodyID low = add_box(&a, 0.2, 1, 0, 0.1), high = add_box(&a, 0.2, 1, 0, 0.3);
    arena_run(&a, 3);
    assert_true(fabs(dBodyGetPosition(low)[2] - 0.1) < 2e-4);
    assert_true(fabs(dBodyGetPosition(high)[2] - 0.3) < 4e-4);
    arena_free(&a);
}

/* A ball that may turn with 10 rad/s at most slides until it rolls so, at 1 m/s, as under ODE. What the limit takes of
 * its spin in the last steps of that is no shear that would pull it below. */
static void test_a_limit_of_the_spin_is_reached(void **state)
{
    (void)state;
    const double steps[2] = {0.01, 0.001};
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, steps[k]);
        dBodyID ball = add_sphere(&a, 0.1, 1, 0.1);
        dBodySetMaxAngularSpeed(ball, 10);
        dBodySetLinearVel(ball, 3, 0, 0);
        dBodySetAngularVel(ball, 0, 30, 0);
        arena_run(&a, 2);
        assert_close(dBodyGetLinearVel(ball)[0], 1, 1e-6);
        assert_close(dBodyGetAngularVel(ball)[1], 10, 1e-6);
        assert_true(pinch_ode_statistics(a.plugin).step_mismatch_angular < 1e-9);
        arena_free(&a);
    }
}

/* How far a body is from the axis of a table that turns about z. */
static double radius_of(dBodyID body)
{
    const double *x = dBodyGetPosition(body);
    return hypot(x[0], x[1]);
}

/*
 * A box sticks on a turntable at 60 % of what friction holds, 1 m from its axis. In each step it goes along a tangent
 * and so outwards by (omega h)^2/2 m, which its contacts take back by the part ERP of a constant displacement,
 * (omega h)^2/2/ERP. From there it does not creep, whichever way its contacts lie: their compliance floors follow their
 * levers, and not the tangents that happen to be chosen. What is left is of the fourth order, 1e-8 m in 8 s.
 */
static void test_what_sticks_on_a_turntable_stays(void **state)
{
    (void)state;
    const double steps[2] = {0.01, 0.005}, omega = 1.716;
    for (int k = 0; k < 2; k++) {
        arena a;
        arena_make(&a, steps[k]);
        dMass m;
        dMassSetBoxTotal(&m, 100, 4, 4, 0.2);
        dBodyID table = add_body(&a, dCreateBox(a.space, 4, 4, 0.2), &m, 0, 0, 0.9);
        dBodySetKinematic(table);
        dBodySetAngularVel(table, 0, 0, omega);
        dBodyID box = add_box(&a, 0.2, 1, 1, 1.1 - 1e-6);
        dBodySetLinearVel(box, 0, omega, 0);
        dBodySetAngularVel(box, 0, 0, omega);
        arena_run(&a, 2);
        double turned = omega * steps[k], offset = 0.5 * turned * turned / dWorldGetERP(a.world), then = radius_of(box);
        assert_close(then - 1, offset, 0.02 * offset);
        arena_run(&a, 8);
        assert_true(fabs(radius_of(box) - then) < 1e-6);
        arena_free(&a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stack_stands_still),
        cmocka_unit_test(test_heavy_on_light),
        cmocka_unit_test(test_feedback_sums_to_the_weight),
        cmocka_unit_test(test_slope),
        cmocka_unit_test(test_sliding_acceleration),
        cmocka_unit_test(test_friction_as_a_force),
        cmocka_unit_test(test_unlimited_friction_holds),
        cmocka_unit_test(test_conveyor),
        cmocka_unit_test(test_bounce),
        cmocka_unit_test(test_no_bounce_is_more_than_elastic),
        cmocka_unit_test(test_bounces_are_exact),
        cmocka_unit_test(test_bats_are_exact),
        cmocka_unit_test(test_what_bounces_comes_to_rest),
        cmocka_unit_test(test_bounces_give_no_energy),
        cmocka_unit_test(test_each_contact_has_its_own_surface),
        cmocka_unit_test(test_slip),
        cmocka_unit_test(test_rolling_friction),
        cmocka_unit_test(test_extreme_parameters),
        cmocka_unit_test(test_sleeping_and_waking),
        cmocka_unit_test(test_a_gap_holds),
        cmocka_unit_test(test_what_sticks_on_a_turntable_stays),
        cmocka_unit_test(test_a_limit_of_the_spin_is_reached),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
