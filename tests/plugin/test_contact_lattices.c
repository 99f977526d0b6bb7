/*
 * Pairs of geoms with many contacts, each with surface parameters of its own: a plate on the ground whose collider
 * returns a lattice of points. Each contact is a spring, and has its own friction, as in ODE: how deep and how tilted
 * the plate lies and how it slows down follow from sums over all of them.
 */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

enum { MOST = 20 };
static const double STEP = 0.005, G = 9.81, MASS = 2, HALF = 0.2, THICK = 0.01, ERP = 0.2;

typedef struct plate {
    dWorldID world;
    dSpaceID space;
    dGeomID geom, ground;
    dBodyID body;
    pinch_ode *plugin;
    int rows; /* of the lattice */
    double erp, cfm, mu[MOST][MOST];
    bool belts;  /* rows move on along one direction and its opposite in turn */
    double from; /* m: contacts are handed over from here on alone */
    int crowd;   /* so many more contacts in a corner */
} plate;

static void plate_make(plate *p, int rows, double cfm, double mu)
{
    memset(p, 0, sizeof *p);
    p->rows = rows;
    p->erp = ERP;
    p->cfm = cfm;
    p->from = -HALF;
    for (int i = 0; i < rows * rows; i++) p->mu[i / rows][i % rows] = mu;
    p->world = dWorldCreate();
    p->space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(p->world, 0, 0, -G);
    p->ground = dCreatePlane(p->space, 0, 0, 1, 0);
    p->geom = dCreateBox(p->space, 2 * HALF, 2 * HALF, 2 * THICK);
    p->body = dBodyCreate(p->world);
    dMass mass;
    dMassSetBoxTotal(&mass, MASS, 2 * HALF, 2 * HALF, 2 * THICK);
    dBodySetMass(p->body, &mass);
    dGeomSetBody(p->geom, p->body);
    dBodySetPosition(p->body, 0, 0, THICK - 1e-6);
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
}

/* The place of a lattice point beside the middle, in either direction. */
static double place(const plate *p, int i)
{
    return HALF * (2.0 * i / (p->rows - 1) - 1);
}

/* Hands over a contact at a place of the lower face, where it is below the ground. */
static void hand_over(plate *p, double x, double y, double mu, bool back)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    dBodyGetRelPointPos(p->body, x, y, -THICK, contact.geom.pos);
    if (contact.geom.pos[2] >= 0) return;
    contact.geom.normal[2] = 1;
    contact.geom.depth = -contact.geom.pos[2];
    contact.geom.g1 = p->geom;
    contact.geom.g2 = p->ground;
    contact.surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    contact.surface.soft_erp = p->erp;
    contact.surface.soft_cfm = p->cfm;
    contact.surface.mu = mu;
    if (p->belts) {
        contact.surface.mode |= dContactFDir1 | dContactMotion1;
        contact.surface.motion1 = 1;
        contact.fdir1[1] = back ? -1 : 1;
    }
    assert_int_equal(pinch_ode_add_contact(p->plugin, &contact, p->body, NULL), PINCH_OK);
}

static void plate_step(plate *p)
{
    for (int i = 0; i < p->rows * p->rows; i++) {
        int row = i / p->rows, column = i % p->rows;
        if (place(p, row) >= p->from)
            hand_over(p, place(p, row), place(p, column), p->mu[row][column], (row + column) % 2);
    }
    for (int i = 0; i < p->crowd; i++) hand_over(p, 0.9 * HALF + 1e-3 * (i % 10), 0.9 * HALF + 1e-3 * (i / 10), 0, 0);
    assert_int_equal(pinch_ode_step(p->plugin, STEP), PINCH_OK);
}

static void plate_free(plate *p)
{
    pinch_ode_stats stats = pinch_ode_statistics(p->plugin);
    assert_int_equal(stats.unconverged_steps, 0);
    assert_int_equal(stats.contacts_left, 0);
    pinch_ode_destroy(p->plugin);
    dSpaceDestroy(p->space);
    dWorldDestroy(p->world);
}

static const int lattices[] = {3, 5, 7, 8, 9, 15, 20};
enum { LATTICES = sizeof lattices / sizeof *lattices };

/* A force beside the middle tilts the plate by F d / (k sum x^2), and it lies as deep as its weight presses springs
 * with k = erp / (h cfm) each. */
static void each_contact_is_a_spring(void **state)
{
    (void)state;
    enum { STEPS = 600 };
    const double force = 4, beside = 0.03, cfm = 1e-3, k = ERP / (STEP * cfm);
    for (int n = 0; n < LATTICES; n++) {
        plate p;
        plate_make(&p, lattices[n], cfm, 0.5);
        double squares = 0, count = p.rows * p.rows;
        for (int i = 0; i < p.rows; i++) squares += p.rows * place(&p, i) * place(&p, i);
        for (int step = 0; step < STEPS; step++) {
            dBodyAddForceAtPos(p.body, 0, 0, -force, beside, 0, 0);
            plate_step(&p);
        }
        assert_close(THICK - dBodyGetPosition(p.body)[2], (MASS * G + force) / (k * count), 1e-6 / (k * count));
        assert_close(-dBodyGetRotation(p.body)[8], force * beside / (k * squares),
                     1e-4 * force * beside / (k * squares));
        plate_free(&p);
    }
}

/* Returns the deceleration of the plate as it slides, or turns about its middle. */
static double deceleration(plate *p, bool turns)
{
    enum { SETTLE = 200, STEPS = 40 };
    for (int step = 0; step < SETTLE; step++) plate_step(p);
    dBodySetLinearVel(p->body, 0, turns ? 0 : 3, 0);
    dBodySetAngularVel(p->body, 0, 0, turns ? 20 : 0);
    plate_step(p);
    const double *v = turns ? dBodyGetAngularVel(p->body) + 2 : dBodyGetLinearVel(p->body) + 1;
    double before = *v;
    for (int step = 0; step < STEPS; step++) plate_step(p);
    return (before - *v) / (STEPS * STEP);
}

/* Only some contacts have friction, others with less or more to bear: hard ones and soft ones bear alike. */
static void each_contact_has_its_own_friction(void **state)
{
    (void)state;
    static const double compliances[] = {1e-9, 1e-3};
    for (int k = 0; k < 2 * LATTICES; k++) {
        plate p;
        plate_make(&p, lattices[k / 2], compliances[k % 2], 0);
        int last = p.rows - 1;
        p.mu[0][0] = p.mu[0][last] = p.mu[last][0] = p.mu[last][last] = 1;
        double wanted = 4 * G / (p.rows * p.rows);
        assert_close(deceleration(&p, false), wanted, 1e-4 * wanted);
        plate_free(&p);
    }
    plate p; /* one in the middle, among which others stand for those around it */
    plate_make(&p, 15, 1e-3, 0);
    p.mu[7][7] = 1;
    assert_close(deceleration(&p, false), G / 225, 1e-4 * G / 225);
    plate_free(&p);
}

/* Friction resists turning by mu m g times the mean distance of the contacts from the middle. */
static void all_contacts_resist_turning(void **state)
{
    (void)state;
    for (int n = 0; n < LATTICES; n++) {
        plate p;
        plate_make(&p, lattices[n], 1e-3, 0.3);
        double sum = 0, count = p.rows * p.rows;
        for (int i = 0; i < p.rows * p.rows; i++) sum += hypot(place(&p, i / p.rows), place(&p, i % p.rows));
        double inertia = MASS * (2 * HALF) * (2 * HALF) / 6, wanted = 0.3 * MASS * G * (sum / count) / inertia;
        assert_close(deceleration(&p, true), wanted, (p.rows * p.rows > 64 ? 1e-2 : 1e-3) * wanted);
        plate_free(&p);
    }
}

/* What rests on more contacts than are kept rests to the bit: from step to step the same ones are kept. */
static void what_lies_on_many_comes_to_rest(void **state)
{
    (void)state;
    enum { STEPS = 600, LAST = 100 };
    plate p;
    plate_make(&p, 20, 1e-3, 0.5);
    for (int step = 0; step < STEPS; step++) {
        plate_step(&p);
        if (step == STEPS - LAST) pinch_ode_reset_statistics(p.plugin);
    }
    assert_int_equal(pinch_ode_statistics(p.plugin).islands_at_rest, LAST - 1);
    assert_true(dCalcVectorLength3(dBodyGetLinearVel(p.body)) == 0);
    plate_free(&p);
}

/* A chequerboard of belts that run one way and the other leaves what lies on it in its place. */
static void belts_against_each_other_move_nothing(void **state)
{
    (void)state;
    static const int even[] = {4, 8, 10, 16, 20};
    for (int n = 0; n < 5; n++) {
        plate p;
        plate_make(&p, even[n], 1e-3, 0.5);
        p.belts = true;
        for (int step = 0; step < 200; step++) plate_step(&p);
        assert_true(dCalcVectorLength3(dBodyGetLinearVel(p.body)) < 1e-3);
        plate_free(&p);
    }
}

/* What is no longer handed over does not hold: a plate without contacts under one side tips. */
static void contacts_that_are_taken_away_are_gone(void **state)
{
    (void)state;
    static const int rows[] = {3, 4, 6, 8, 16};
    for (int n = 0; n < 5; n++) {
        plate p;
        plate_make(&p, rows[n], 1e-9, 0.5);
        for (int step = 0; step < 100; step++) plate_step(&p);
        p.from = 0.3 * HALF;
        for (int step = 0; step < 30; step++) plate_step(&p);
        assert_true(fabs(dBodyGetRotation(p.body)[8]) > 0.2);
        plate_free(&p);
    }
}

/* At an ERP of 0 nothing takes an overlap back, and without a CFM nothing gives way. The plate stays where it is. */
static void overlaps_may_stay(void **state)
{
    (void)state;
    for (int n = 0; n < LATTICES; n++) {
        plate p;
        plate_make(&p, lattices[n], 0, 0.5);
        p.erp = 0;
        for (int step = 0; step < 50; step++) plate_step(&p);
        assert_close(dBodyGetPosition(p.body)[2], THICK - 1e-6, 1e-6);
        plate_free(&p);
    }
}

/* Many contacts in a corner stand for each other. The few elsewhere are not so soft for it that they count as springs,
 * which may give back what deep overlaps would hold. */
static void crowds_of_contacts_throw_nothing(void **state)
{
    (void)state;
    plate p;
    plate_make(&p, 16, 1e-10, 0.5);
    p.crowd = 100;
    dBodySetPosition(p.body, 0, 0, THICK - 0.1);
    double fastest = 0;
    for (int step = 0; step < 100; step++) {
        plate_step(&p);
        fastest = fmax(fastest, dCalcVectorLength3(dBodyGetLinearVel(p.body)));
    }
    assert_true(fastest < sqrt(2 * G * 0.1)); /* that of a fall from as high as it was deep */
    plate_free(&p);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_contact_is_a_spring),
        cmocka_unit_test(each_contact_has_its_own_friction),
        cmocka_unit_test(all_contacts_resist_turning),
        cmocka_unit_test(what_lies_on_many_comes_to_rest),
        cmocka_unit_test(belts_against_each_other_move_nothing),
        cmocka_unit_test(contacts_that_are_taken_away_are_gone),
        cmocka_unit_test(crowds_of_contacts_throw_nothing),
        cmocka_unit_test(overlaps_may_stay),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
