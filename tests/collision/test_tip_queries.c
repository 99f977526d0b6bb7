/*
 * Asks for closest points, curvatures and mass properties of one fingertip, and checks that wrong shapes are refused.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

enum { TRIALS = 400 };

/* Closest points lie on the surface, and the way there is along the normal: checked on the reference's support. */
static void test_closest_points(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 6);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip t;
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &t);
        double x[3], n[3], nearest[3], distance, R[9];
        draw_frame(&random, R);
        test_tip_place(&t, (const double[3]){0.3, -0.2, 0.1}, R);
        for (int i = 0; i < 3; i++) x[i] = draw_uniform(&random, -2, 2);
        assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_OK);
        double along = n[0] * x[0] + n[1] * x[1] + n[2] * x[2];
        assert_close(along - test_tip_reach(&t, n), distance, 1e-9); /* the plane at the nearest point touches */
        for (int i = 0; i < 3; i++) assert_close(nearest[i] + distance * n[i], x[i], 1e-12);
        test_tip_free(&t);
    }
}

static void test_curvatures(void **state)
{
    (void)state;
    double k[2], u[3];
    test_tip e = test_tip_of(PINCH_TIP_ELLIPSOID, 3, 2, 1, 0), c = test_tip_of(PINCH_TIP_CYLINDER, 2, 3, 0, 0.5);
    test_tip b = test_tip_of(PINCH_TIP_BOX, 2, 2, 2, 0.25);
    assert_int_equal(pinch_tip_curvature(e.geom, (const double[3]){0, 0, 1}, k, u), PINCH_OK);
    assert_close(k[0], 1.0 / 9, 1e-12); /* c/a^2 along x, c/b^2 along y */
    assert_close(k[1], 1.0 / 4, 1e-12);
    assert_close(fabs(u[0]), 1, 1e-12);
    assert_int_equal(pinch_tip_curvature(c.geom, (const double[3]){1, 0, 0}, k, u), PINCH_OK);
    assert_close(k[0], 0, 0);
    assert_close(k[1], 0.5, 1e-12);
    assert_close(fabs(u[2]), 1, 1e-12);
    assert_int_equal(pinch_tip_curvature(c.geom, (const double[3]){0, 0, -1}, k, u), PINCH_OK);
    assert_close(k[1], 0, 0);
    assert_int_equal(pinch_tip_curvature(b.geom, (const double[3]){0.6, 0.8, 0}, k, u), PINCH_OK);
    assert_close(k[0], 0, 0);
    assert_close(k[1], 4, 1e-9);
    test_tip_free(&e);
    test_tip_free(&c);
    test_tip_free(&b);
}

/* Volume and inertia by the divergence theorem on a fine grid of normals would need the surface; counting points inside
 * needs only the distance. */
static void test_inertia(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 7);
    for (int type = 0; type < PINCH_TIP_COUNT; type++) {
        test_tip t;
        do {
            test_tip_make(&random, (pinch_tip_type)type, &t);
            if (type != PINCH_TIP_CONVEX || t.tip.skin == 0) break;
            test_tip_free(&t);
        } while (true);
        double volume, inertia[9], sum[4] = {0, 0, 0, 0};
        dReal box[6];
        assert_int_equal(pinch_tip_inertia(&t.tip, &volume, inertia), PINCH_OK);
        dGeomGetAABB(t.geom, box);
        double whole = (box[1] - box[0]) * (box[3] - box[2]) * (box[5] - box[4]);
        enum { N = 16 };
        for (int k = 0; k < N * N * N; k++) {
            int cell[3] = {k % N, k / N % N, k / (N * N)};
            double x[3], n[3], nearest[3], distance;
            for (int i = 0; i < 3; i++) x[i] = box[2 * i] + (cell[i] + 0.5) / N * (box[2 * i + 1] - box[2 * i]);
            assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_OK);
            if (distance > 0) continue;
            sum[3] += whole / (N * N * N);
            for (int i = 0; i < 3; i++) sum[i] += whole / (N * N * N) * x[i] * x[i];
        }
        assert_close(sum[3] / volume, 1, 0.06); /* the grid's accuracy */
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            assert_close((sum[j] + sum[k]) / (volume * inertia[4 * i]), 1, 0.1);
        }
        test_tip_free(&t);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    dGeomID geom;
    pinch_tip tip = pinch_default_tip(PINCH_TIP_BOX);
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    for (int i = 0; i < 3; i++) tip.size[i] = 1;
    tip.skin = 0.5;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    tip.skin = NAN;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    tip = pinch_default_tip(PINCH_TIP_CONVEX);
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    static const double POINTS[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const double S = 0.57735026918962576;
    static const double PLANES[16] = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, S, S, S, S};
    static const unsigned POLYGONS[16] = {3, 0, 3, 2, 3, 0, 1, 3, 3, 0, 2, 1, 3, 1, 2, 3};
    static const unsigned BEYOND[16] = {3, 0, 3, 2, 3, 0, 1, 3, 3, 0, 2, 1, 3, 1, 2, 4};
    pinch_convex corner = {PLANES, 4, POINTS, POLYGONS, 4};
    tip.pieces = &corner;
    tip.piece_count = 1;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_OK);
    dGeomDestroy(geom);
    corner.polygons = BEYOND; /* names a point that there is not */
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_create_tip(NULL, NULL, &geom), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_tip_take_over(dRayClass, dSphereClass), PINCH_INVALID_ARGUMENT);
}

/* A point with a coordinate that is infinite or no number is refused. */
static void test_points_that_are_none(void **state)
{
    (void)state;
    static const double wrong[] = {NAN, INFINITY, -INFINITY};
    test_tip t = test_tip_of(PINCH_TIP_BOX, 3, 2, 1, 0.1);
    dGeomID plane = dCreatePlane(NULL, 0, 0, 1, 0);
    for (int i = 0; i < 9; i++) {
        double x[3] = {1, 2, 3}, distance, nearest[3], n[3];
        assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_OK);
        assert_int_equal(pinch_tip_closest_point(plane, x, &distance, nearest, n), PINCH_OK);
        x[i / 3] = wrong[i % 3];
        assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_INVALID_ARGUMENT);
        assert_int_equal(pinch_tip_closest_point(plane, x, &distance, nearest, n), PINCH_INVALID_ARGUMENT);
    }
    dGeomDestroy(plane);
    test_tip_free(&t);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closest_points),
        cmocka_unit_test(test_curvatures),
        cmocka_unit_test(test_inertia),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_points_that_are_none),
    };
    int failed = cmocka_run_group_tests_name("tip queries", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
