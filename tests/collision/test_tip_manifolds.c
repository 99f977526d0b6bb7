/*
 * Where flat, straight and nearly flat parts meet, there must be as many contact points as it takes, in the right
 * places.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <string.h>

static const double LYING[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};

/* Flat and straight parts get as many points as they need, all of the true depth, around the true middle. */
static void test_manifolds(void **state)
{
    (void)state;
    test_tip ground = test_tip_of(PINCH_TIP_BOX, 1, 1, 0.2, 0);
    test_tip_place(&ground, (const double[3]){0, 0, -0.1}, TEST_TIP_UPRIGHT);
    const struct {
        test_tip tip;
        const double *R;
        double height;
        int points;
    } cases[] = {
        {test_tip_of(PINCH_TIP_BOX, 0.1, 0.2, 0.06, 0), TEST_TIP_UPRIGHT, 0.03, 4},
        {test_tip_of(PINCH_TIP_BOX, 0.1, 0.2, 0.06, 0.01), TEST_TIP_UPRIGHT, 0.03, 4},
        {test_tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), TEST_TIP_UPRIGHT, 0.1, 8},
        {test_tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0.01), TEST_TIP_UPRIGHT, 0.1, 8},
        {test_tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
        {test_tip_of(PINCH_TIP_CAPSULE, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
        {test_tip_of(PINCH_TIP_CAPSULE, 0.05, 0.2, 0, 0), TEST_TIP_UPRIGHT, 0.15, 1},
        {test_tip_of(PINCH_TIP_ELLIPSOID, 0.05, 0.2, 0.1, 0), TEST_TIP_UPRIGHT, 0.1, 1},
        {test_tip_of(PINCH_TIP_FLAT_CAPSULE, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
    };
    double depth = 1e-4;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        test_tip t = cases[k].tip;
        dContactGeom c[TEST_TIP_CONTACTS];
        double middle[3] = {0, 0, 0};
        test_tip_place(&t, (const double[3]){0.1, 0.05, cases[k].height - depth}, cases[k].R);
        int count = test_tips_collide(&t, &ground, c);
        assert_int_equal(count, cases[k].points);
        for (int i = 0; i < count; i++) {
            assert_close(c[i].depth, depth, 1e-12);
            assert_close(c[i].normal[2], 1, 1e-12);
            assert_close(c[i].pos[2], -0.5 * depth, 1e-12);
            for (int j = 0; j < 3; j++) middle[j] += c[i].pos[j] / count;
        }
        assert_close(middle[0], 0.1, 1e-9);
        if (t.tip.type != PINCH_TIP_FLAT_CAPSULE) assert_close(middle[1], 0.05, 1e-9);
        test_tip_free(&t);
    }
    test_tip_free(&ground);
}

/* Tilted about a level axis by `tilt`, it stands with a pole on the pad, at z = 0, `overlap` deep. Where the middle of
 * the contact's points is; returns how deep they all are. */
static double press_tilted(test_tip *t, int pole, double tilt, dGeomID pad, double overlap, double *middle)
{
    double up[3][9] = {{0, 0, -1, 0, 1, 0, 1, 0, 0}, {1, 0, 0, 0, 0, -1, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}, R[9];
    dMatrix3 tilted;
    dContactGeom c[TEST_TIP_CONTACTS];
    dRFromAxisAndAngle(tilted, 0.6, 0.8, 0, tilt);
    for (int i = 0; i < 9; i++) {
        R[i] = 0;
        for (int k = 0; k < 3; k++) R[i] += tilted[4 * (i / 3) + k] * up[pole][3 * k + i % 3];
    }
    test_tip_place(t, (const double[3]){0, 0, t->tip.size[pole] - overlap}, R);
    int count = dCollide(t->geom, pad, TEST_TIP_CONTACTS, c, sizeof c[0]);
    assert_in_range(count, 1, 8);
    for (int i = 0; i < 3; i++) middle[i] = 0;
    for (int k = 0; k < count; k++) {
        assert_close(c[k].depth, c[0].depth, 1e-12);
        for (int i = 0; i < 3; i++) middle[i] += c[k].pos[i] / count;
    }
    return c[0].depth;
}

/* Where a superellipsoid is nearly flat, the point that reaches farthest runs away at the least tilt. The pressure's
 * middle goes with the tilt: to the side that is pressed in deeper, and never by a jump. */
static void test_flat_spots(void **state)
{
    (void)state;
    static const double EXPONENTS[4][2] = {{0.5, 0.5}, {0.25, 1}, {1, 0.3}, {0.7, 0.8}};
    enum { TILTS = 120 };
    const double overlap = 5e-4;
    dGeomID pads[4] = {dCreatePlane(NULL, 0, 0, 1, 0), dCreateBox(NULL, 0.02, 0.015, 0.01),
                       dCreateCylinder(NULL, 0.008, 0.01), dCreateCapsule(NULL, 0.004, 0.02)};
    dMatrix3 turned;
    dRFromAxisAndAngle(turned, 0, 0, 1, 0.4);
    for (int k = 1; k < 3; k++) {
        dGeomSetRotation(pads[k], turned);
        dGeomSetPosition(pads[k], 1e-4, 2e-4, -0.005);
    }
    dRFromAxisAndAngle(turned, 0.8, 0.6, 0, 1.5707963267948966); /* lying */
    dGeomSetRotation(pads[3], turned);
    dGeomSetPosition(pads[3], 0, 0, -0.004);
    for (int e = 0; e < 4; e++) {
        test_tip t;
        bool flat = EXPONENTS[e][0] < 1 && EXPONENTS[e][1] < 1; /* all around */
        memset(&t, 0, sizeof t);
        t.tip = pinch_default_tip(PINCH_TIP_SUPERELLIPSOID);
        for (int i = 0; i < 3; i++) t.tip.size[i] = 0.02 + 0.005 * i;
        for (int i = 0; i < 2; i++) t.tip.exponent[i] = EXPONENTS[e][i];
        test_tip_make_geom(&t);
        for (int pad = 0; pad < 4; pad++)
            for (int pole = 0; pole < 3; pole++)
                for (int sign = -1; sign < 2; sign += 2) {
                    double level[3], before[3], last = 0, m[3];
                    (void)press_tilted(&t, pole, 0, pads[pad], overlap, level);
                    memcpy(before, level, sizeof before);
                    for (int k = 0; k < TILTS; k++) {
                        double tilt = pow(10, -15 + 13.7 * k / (TILTS - 1)), moved = 0;
                        assert_true(press_tilted(&t, pole, sign * tilt, pads[pad], overlap, m) > 0.9 * overlap);
                        for (int i = 0; i < 2; i++) moved += (m[i] - before[i]) * (m[i] - before[i]);
                        assert_true(sqrt(moved) < 0.5 * (tilt - last) + 1e-11);
                        double deeper = 0.6 * (m[1] - level[1]) - 0.8 * (m[0] - level[0]);
                        if (flat && tilt > 1e-9 && tilt < 1e-3) assert_true(sign * deeper < 0);
                        last = tilt;
                        memcpy(before, m, sizeof m);
                    }
                }
        test_tip_free(&t);
    }
    for (int k = 0; k < 4; k++) dGeomDestroy(pads[k]);
}

/* Two cylinders side by side: two points on the common line. Crossed: one. */
static void test_lines(void **state)
{
    (void)state;
    static const double ACROSS[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    dContactGeom c[TEST_TIP_CONTACTS];
    test_tip a = test_tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), b = test_tip_of(PINCH_TIP_CAPSULE, 0.03, 0.1, 0, 0);
    test_tip_place(&a, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
    test_tip_place(&b, (const double[3]){0.079, 0, 0.02}, TEST_TIP_UPRIGHT);
    assert_int_equal(test_tips_collide(&a, &b, c), 2);
    for (int k = 0; k < 2; k++) {
        assert_close(c[k].depth, 0.001, 1e-9);
        assert_close(c[k].normal[0], -1, 1e-9);
        assert_close(c[k].pos[2], fabs(c[k].pos[2] - 0.07) < 0.01 ? 0.07 : -0.03, 1e-9);
    }
    test_tip_place(&b, (const double[3]){0, 0.079, 0.02}, ACROSS);
    assert_int_equal(test_tips_collide(&a, &b, c), 1);
    assert_close(c[0].depth, 0.001, 1e-9);
    assert_close(c[0].pos[2], 0.02, 1e-9);
    test_tip_free(&a);
    test_tip_free(&b);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_manifolds),
        cmocka_unit_test(test_flat_spots),
        cmocka_unit_test(test_lines),
    };
    int failed = cmocka_run_group_tests_name("tip manifolds", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
