/*
 * Bodies that are level except for a little, that overhang, that are equal or that are moved together must get the same
 * points.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <string.h>

enum { ROOM = 64 };

/* Tilted about x and y by that angle, in some way beyond the border of the lower one. */
static void tilt(test_tip *upper, double angle, const double x[3])
{
    dMatrix3 R;
    dQuaternion q = {1, 0.5 * angle, 0.5 * angle, 0};
    double length = sqrt(1 + 0.5 * angle * angle), Q[9];
    for (int i = 0; i < 4; i++) q[i] /= length;
    dRfromQ(R, q);
    for (int i = 0; i < 9; i++) Q[i] = R[4 * (i / 3) + i % 3];
    test_tip_place(upper, x, Q);
}

static double most_of(const dContactGeom *c, int count, int axis, double sign)
{
    double most = -INFINITY;
    for (int k = 0; k < count; k++) most = fmax(most, sign * c[k].pos[axis]);
    return sign * most;
}

/* A millimetre deep and a tilt of a micrometre or a tenth of a millimetre: as many points as it takes, over both. */
static void test_overhang(void **state)
{
    (void)state;
    static const double TILTS[] = {0, 1e-9, 1e-8, 1e-7, 4e-7, 1e-6, 1e-5, 1e-4, 1e-3};
    const test_tip uppers[] = {test_tip_of(PINCH_TIP_BOX, 0.5, 0.5, 0.5, 0),
                               test_tip_of(PINCH_TIP_BOX, 0.5, 0.5, 0.5, 0.05),
                               test_tip_of(PINCH_TIP_CYLINDER, 0.25, 0.5, 0, 0)};
    test_tip lower = test_tip_of(PINCH_TIP_BOX, 1, 1, 1, 0);
    test_tip_place(&lower, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
    for (size_t shape = 0; shape < sizeof uppers / sizeof uppers[0]; shape++)
        for (size_t k = 0; k < sizeof TILTS / sizeof TILTS[0]; k++) {
            test_tip upper = uppers[shape];
            dContactGeom c[ROOM];
            double deepest = 0;
            tilt(&upper, TILTS[k], (const double[3]){0.55, 0.1, 0.749});
            int count = dCollide(upper.geom, lower.geom, ROOM, c, sizeof c[0]);
            assert_in_range(count, 4, 16);
            for (int i = 0; i < count; i++) {
                assert_true(c[i].pos[0] < 0.5 + 1e-6 && c[i].pos[0] > 0.3 - 1e-3);
                assert_close(c[i].pos[2], 0.4995, 1e-3);
                assert_true(c[i].depth > 0.4e-3 && c[i].depth < 1.6e-3);
                deepest = fmax(deepest, c[i].depth);
            }
            const double n[3] = {c[0].normal[0], c[0].normal[1], c[0].normal[2]};
            assert_close(deepest, test_overlap(&upper, &lower, n), 1e-6);
            assert_true(most_of(c, count, 0, 1) > 0.49); /* they reach to the border and well inwards */
            assert_true(most_of(c, count, 0, -1) < 0.4);
            assert_true(most_of(c, count, 1, 1) - most_of(c, count, 1, -1) > 0.35);
        }
    for (size_t shape = 0; shape < sizeof uppers / sizeof uppers[0]; shape++) {
        test_tip upper = uppers[shape];
        test_tip_free(&upper);
    }
    test_tip_free(&lower);
}

/* The pair moved as one. */
static void move(const test_tip *tip, const double *R, const double *x, test_tip *moved)
{
    double at[3], turned[9];
    for (int i = 0; i < 3; i++) {
        at[i] = x[i];
        for (int k = 0; k < 3; k++) at[i] += R[3 * i + k] * tip->position[k];
        for (int j = 0; j < 3; j++) {
            turned[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) turned[3 * i + j] += R[3 * i + k] * tip->R[3 * k + j];
        }
    }
    test_tip_place(moved, at, turned);
}

static void assert_moved(const dContactGeom *c, const dContactGeom *m, int count, const double *R, const double *x)
{
    for (int k = 0; k < count; k++)
        for (int i = 0; i < 3; i++) {
            double expected = x[i];
            for (int j = 0; j < 3; j++) expected += R[3 * i + j] * c[k].pos[j];
            assert_close(m[k].pos[i], expected, 1e-9);
        }
}

/* Whatever there is room for, and of equal bodies, too: which points are kept does not depend on where the pair is. */
static void test_moved(void **state)
{
    (void)state;
    const struct {
        test_tip a, b;
        double x[3], turn;
    } pairs[] = {
        {test_tip_of(PINCH_TIP_BOX, 1, 1, 1, 0), test_tip_of(PINCH_TIP_BOX, 0.5, 0.5, 0.5, 0), {0.1, 0, 0.749}, 0},
        {test_tip_of(PINCH_TIP_BOX, 1, 1, 1, 0), test_tip_of(PINCH_TIP_BOX, 1, 1, 1, 0), {0.2, 0.1, 0.999}, 0},
        {test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0),
         test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0),
         {0, 0, 0.999},
         0.3},
        {test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0),
         test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0),
         {0.3, 0, 0.999},
         0},
    };
    pinch_random random;
    pinch_random_seed(&random, 81);
    for (size_t p = 0; p < sizeof pairs / sizeof pairs[0]; p++) {
        test_tip a = pairs[p].a, b = pairs[p].b;
        const double c0 = cos(pairs[p].turn), s0 = sin(pairs[p].turn), Rb[9] = {c0, -s0, 0, s0, c0, 0, 0, 0, 1};
        for (int n = 0; n < 300; n++) {
            dContactGeom c[ROOM], m[ROOM];
            test_tip a_moved = a, b_moved = b;
            double R[9], x[3];
            int room = 1 + n % 9;
            draw_frame(&random, R);
            for (int i = 0; i < 3; i++) x[i] = draw_uniform(&random, -3, 3);
            test_tip_place(&a, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
            test_tip_place(&b, pairs[p].x, Rb);
            a_moved = a, b_moved = b;
            int count = dCollide(b.geom, a.geom, room, c, sizeof c[0]);
            move(&a, R, x, &a_moved);
            move(&b, R, x, &b_moved);
            assert_int_equal(dCollide(b.geom, a.geom, room, m, sizeof m[0]), count);
            assert_moved(c, m, count, R, x);
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

/* No two points of a stack of cylinders are one. */
static void test_no_doubles(void **state)
{
    (void)state;
    static const double ASIDE[][2] = {{0.3, 0}, {0.3, 0.3}, {0, -0.2}, {-0.25, 0.25}, {0.3, 1e-7}};
    for (size_t k = 0; k < sizeof ASIDE / sizeof ASIDE[0]; k++) {
        test_tip lower = test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0),
                 upper = test_tip_of(PINCH_TIP_CYLINDER, 0.5, 1, 0, 0);
        dContactGeom c[ROOM];
        test_tip_place(&lower, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
        test_tip_place(&upper, (const double[3]){ASIDE[k][0], ASIDE[k][1], 0.999}, TEST_TIP_UPRIGHT);
        int count = dCollide(upper.geom, lower.geom, ROOM, c, sizeof c[0]);
        assert_in_range(count, 4, 12);
        for (int i = 0; i < count; i++)
            for (int j = 0; j < i; j++) assert_true(hypot(c[i].pos[0] - c[j].pos[0], c[i].pos[1] - c[j].pos[1]) > 0.04);
        test_tip_free(&lower);
        test_tip_free(&upper);
    }
}

enum { PIECES = 3 };

/* Boxes side by side as the pieces of one body. */
typedef struct blocks {
    double planes[PIECES][24], points[PIECES][24];
    pinch_convex piece[PIECES];
    dGeomID geom;
} blocks;

static void make_blocks(pinch_random *random, blocks *b)
{
    static const unsigned POLYGONS[30] = {4, 1, 3, 7, 5, 4, 0, 4, 6, 2, 4, 2, 6, 7, 3,
                                          4, 0, 1, 5, 4, 4, 4, 5, 7, 6, 4, 0, 2, 3, 1};
    pinch_tip tip = pinch_default_tip(PINCH_TIP_CONVEX);
    double from = -0.3;
    for (int k = 0; k < PIECES; k++) {
        double high[3] = {from + draw_uniform(random, 0.1, 0.3), draw_uniform(random, 0.1, 0.3),
                          draw_uniform(random, 0.1, 0.3)};
        double low[3] = {from, -0.2, -0.2};
        from = high[0];
        for (int c = 0; c < 8; c++)
            for (int i = 0; i < 3; i++) b->points[k][3 * c + i] = c >> i & 1 ? high[i] : low[i];
        for (int f = 0; f < 6; f++) {
            memset(&b->planes[k][4 * f], 0, 4 * sizeof(double));
            b->planes[k][4 * f + f / 2] = f % 2 ? -1 : 1;
            b->planes[k][4 * f + 3] = f % 2 ? -low[f / 2] : high[f / 2];
        }
        b->piece[k] = (pinch_convex){b->planes[k], 6, b->points[k], POLYGONS, 8};
    }
    tip.pieces = b->piece;
    tip.piece_count = PIECES;
    assert_int_equal(pinch_create_tip(NULL, &tip, &b->geom), PINCH_OK);
}

static void place_blocks(pinch_random *random, const blocks *b, double spread)
{
    dMatrix3 R;
    double axis[3], at[3];
    draw_direction(random, axis);
    dRFromAxisAndAngle(R, axis[0], axis[1], axis[2], draw_chance(random, 0.3) ? 0 : draw_uniform(random, 0, 3));
    dGeomSetRotation(b->geom, R);
    for (int i = 2; i >= 0; i--) at[i] = draw_uniform(random, -spread, spread);
    dGeomSetPosition(b->geom, at[0], at[1], at[2]);
}

/* Bodies of several pieces, the other one first: the same contacts in the same order, mirrored to the bit. */
static void test_pieces_swapped(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 82);
    int touching = 0;
    for (int n = 0; n < 1000; n++) {
        blocks a, b;
        dContactGeom c[ROOM], m[ROOM];
        make_blocks(&random, &a);
        make_blocks(&random, &b);
        place_blocks(&random, &a, 0);
        place_blocks(&random, &b, 0.4);
        int room = 1 + n % 12, count = dCollide(a.geom, b.geom, room, c, sizeof c[0]);
        assert_int_equal(dCollide(b.geom, a.geom, room, m, sizeof m[0]), count);
        touching += count > 0;
        for (int k = 0; k < count; k++) {
            assert_memory_equal(c[k].pos, m[k].pos, 3 * sizeof(dReal));
            assert_true(c[k].depth == m[k].depth);
            for (int i = 0; i < 3; i++) assert_true(c[k].normal[i] == -m[k].normal[i]);
        }
        dGeomDestroy(a.geom);
        dGeomDestroy(b.geom);
    }
    assert_in_range(touching, 300, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_overhang), cmocka_unit_test(test_moved),
                                       cmocka_unit_test(test_no_doubles), cmocka_unit_test(test_pieces_swapped)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    pinch_close_tips();
    dCloseODE();
    return failed;
}
