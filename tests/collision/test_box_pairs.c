/*
 * Boxes with parallel edges, turned any way: what ODE's collider loses or gets wrong by rounding is put right, and all
 * else stays as it has returned it.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/fingertip.h>

#include <string.h>

enum { ROOM = 16, ORIENTATIONS = 60000 /* of which a normal run takes a hundredth */, TILTS = 40 };
static const double CUBE = 0.1, PAD = 0.02, THICK = 0.01, DEPTH = 0.0005;

typedef struct found {
    dContactGeom at[ROOM];
    int count;
} found;

static double deepest(const found *f)
{
    double depth = 0;
    for (int k = 0; k < f->count; k++) depth = fmax(depth, f->at[k].depth);
    return depth;
}

static double dot3(const dReal *a, const dReal *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Lays the cube somewhere, any way, and presses the pad into a face of it, tilted about an axis of the cube's. */
static void place(pinch_random *random, dGeomID cube, dGeomID pad, const double *axis, double tilt)
{
    dQuaternion turn, tilted, both;
    dVector3 somewhere, beside;
    for (int i = 0; i < 4; i++) turn[i] = draw_uniform(random, -1, 1);
    dNormalize4(turn);
    for (int i = 0; i < 3; i++) somewhere[i] = draw_uniform(random, -1, 1);
    dQFromAxisAndAngle(tilted, axis[0], axis[1], axis[2], tilt);
    dQMultiply0(both, turn, tilted);
    dNormalize4(both);
    dGeomSetQuaternion(cube, turn);
    dGeomSetPosition(cube, somewhere[0], somewhere[1], somewhere[2]);
    const dReal *R = dGeomGetRotation(cube);
    for (int i = 0; i < 3; i++) beside[i] = somewhere[i] - (0.5 * CUBE + 0.5 * THICK - DEPTH) * R[4 * i];
    dGeomSetQuaternion(pad, both);
    dGeomSetPosition(pad, beside[0], beside[1], beside[2]);
}

static found collide(dGeomID a, dGeomID b, found *by_ode)
{
    found f;
    by_ode->count = dCollide(a, b, ROOM, by_ode->at, sizeof by_ode->at[0]);
    f = *by_ode;
    f.count = pinch_tip_mend_boxes(a, b, ROOM, f.at, sizeof f.at[0], f.count);
    return f;
}

/* A pad that is pressed on has as many points as its corners go in, as deep as they do, whatever way all of it lies. */
static void pressed_pads_keep_their_points(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 31);
    dGeomID cube = dCreateBox(NULL, CUBE, CUBE, CUBE), pad = dCreateBox(NULL, THICK, PAD, PAD);
    static const double axes[][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, scales[] = {1e-3, 1e-5, 1e-8, 1e-12};
    for (int trial = 0; trial < draw_count(ORIENTATIONS); trial++) {
        for (int k = -TILTS; k <= TILTS; k++) {
            const double *axis = axes[draw_index(&random, 3)];
            double tilt = scales[draw_index(&random, 4)] * k;
            bool swapped = draw_chance(&random, 0.5);
            found ode, f, exact;
            place(&random, cube, pad, axis, tilt);
            f = collide(swapped ? pad : cube, swapped ? cube : pad, &ode);
            exact.count =
                pinch_tip_collide(swapped ? pad : cube, swapped ? cube : pad, ROOM, exact.at, sizeof exact.at[0]);
            assert_int_equal(f.count, exact.count);
            assert_close(deepest(&f), deepest(&exact), 1e-9);
            /* by the pad's corners: half the pad tilts by that much, half its thickness by its cosine */
            double sine = axis == axes[2] ? 0 : fabs(sin(tilt)), cosine = axis == axes[2] ? 1 : cos(tilt);
            double goes_in = DEPTH - 0.5 * THICK * (1 - cosine) + 0.5 * PAD * sine;
            assert_close(deepest(&f), goes_in, 2e-4 * goes_in);
            for (int i = 0; i < f.count; i++) assert_true(fabs(dot3(f.at[i].normal, exact.at[0].normal)) > 1 - 1e-9);
            if (ode.count == f.count && ode.at[0].depth == f.at[0].depth)
                assert_memory_equal(ode.at, f.at, (size_t)f.count * sizeof f.at[0]);
        }
    }
    dGeomDestroy(cube);
    dGeomDestroy(pad);
}

/* Boxes without a parallel edge, and boxes that are apart, are ODE's. */
static void all_else_stays(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 32);
    for (int trial = 0; trial < draw_count(ORIENTATIONS); trial++) {
        double sides[6];
        for (int i = 0; i < 6; i++) sides[i] = draw_log_uniform(&random, 0.01, 0.3);
        dGeomID a = dCreateBox(NULL, sides[0], sides[1], sides[2]), b = dCreateBox(NULL, sides[3], sides[4], sides[5]);
        for (int side = 0; side < 2; side++) {
            dQuaternion turn;
            for (int i = 0; i < 4; i++) turn[i] = draw_uniform(&random, -1, 1);
            dNormalize4(turn);
            dGeomSetQuaternion(side ? b : a, turn);
            dGeomSetPosition(side ? b : a, draw_uniform(&random, -0.2, 0.2), draw_uniform(&random, -0.2, 0.2), 0);
        }
        found ode, f = collide(a, b, &ode);
        assert_int_equal(f.count, ode.count);
        assert_memory_equal(ode.at, f.at, (size_t)f.count * sizeof f.at[0]);
        for (int side = 0; side < 2; side++) dGeomSetQuaternion(side ? b : a, (const dQuaternion){1, 0, 0, 0});
        dGeomSetPosition(a, 0, 0, 0);
        dGeomSetPosition(b, 0, 0.5 * (sides[1] + sides[4]) + 1e-15, 0); /* they touch, but for rounding */
        f = collide(a, b, &ode);
        assert_int_equal(f.count, ode.count);
        dGeomDestroy(a);
        dGeomDestroy(b);
    }
}

/* There is as much room as the caller says, and who wants any contact gets ODE's. */
static void flags_count(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 33);
    dGeomID cube = dCreateBox(NULL, CUBE, CUBE, CUBE), pad = dCreateBox(NULL, THICK, PAD, PAD);
    dGeomID ball = dCreateSphere(NULL, PAD);
    dContactGeom at[ROOM];
    for (int trial = 0; trial < 2000; trial++) {
        place(&random, cube, pad, (const double[]){0, 1, 0}, 1e-3 * (trial % 50));
        memset(at, 0, sizeof at);
        assert_int_equal(pinch_tip_mend_boxes(cube, pad, 2, at, sizeof at[0], 0), 2);
        for (int i = 0; i < 2; i++) {
            assert_true(at[i].g1 == cube && at[i].g2 == pad);
            assert_true(at[i].depth > 0);
        }
        assert_true(at[2].g1 == NULL);
        assert_int_equal(pinch_tip_mend_boxes(cube, pad, (int)(2 | CONTACTS_UNIMPORTANT), at, sizeof at[0], 0), 0);
        dGeomSetPosition(ball, dGeomGetPosition(pad)[0], dGeomGetPosition(pad)[1], dGeomGetPosition(pad)[2]);
        assert_int_equal(pinch_tip_mend_boxes(cube, ball, 2, at, sizeof at[0], 0), 0);
    }
    dGeomDestroy(cube);
    dGeomDestroy(pad);
    dGeomDestroy(ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pressed_pads_keep_their_points),
        cmocka_unit_test(all_else_stays),
        cmocka_unit_test(flags_count),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
