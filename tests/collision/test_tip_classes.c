/*
 * Compares fingertips with ODE's own classes: with ODE's answers where they are exact, and with what ODE hands over to
 * the plugin.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <string.h>

enum { TRIALS = 400 };

/* An ellipsoid with equal radii is a sphere. */
static void test_round_ellipsoid(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b;
        dContactGeom c[TEST_TIP_CONTACTS];
        for (int k = 0; k < 2; k++) {
            test_tip *t = k ? &b : &a;
            memset(t, 0, sizeof *t);
            t->tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
            t->tip.size[0] = t->tip.size[1] = t->tip.size[2] = draw_log_uniform(&random, 0.3, 3);
            test_tip_make_geom(t);
        }
        test_tips_touch(&random, &a, &b, 0.1, 1.1);
        int count = test_tips_collide(&a, &b, c);
        double n[3], distance = 0;
        for (int i = 0; i < 3; i++) n[i] = a.position[i] - b.position[i];
        distance = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        double depth = a.tip.size[0] + b.tip.size[0] - distance;
        assert_int_equal(count, depth > 0);
        if (count) {
            assert_close(c[0].depth, depth, 1e-9);
            for (int i = 0; i < 3; i++) assert_close(c[0].normal[i], n[i] / distance, 1e-9);
            for (int i = 0; i < 3; i++)
                assert_close(c[0].pos[i], b.position[i] + (b.tip.size[0] - 0.5 * depth) * n[i] / distance, 1e-9);
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

/* ODE's sphere against its box, capsule, cylinder, plane and sphere, and a round ellipsoid in the sphere's place. */
static void test_like_odes_sphere(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 4);
    int touching = 0;
    for (int trial = 0; trial < 5 * TRIALS; trial++) {
        double r = draw_log_uniform(&random, 0.3, 2), R[9], x[3], d[3];
        pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
        tip.size[0] = tip.size[1] = tip.size[2] = r;
        dGeomID ball, sphere = dCreateSphere(NULL, r), other;
        assert_int_equal(pinch_create_tip(NULL, &tip, &ball), PINCH_OK);
        double p = draw_uniform(&random, 0.3, 2), q = draw_uniform(&random, 0.3, 2), s = draw_uniform(&random, 0.3, 2);
        int kind = trial % 5;
        other = kind == 0   ? dCreateSphere(NULL, p)
                : kind == 1 ? dCreateBox(NULL, p, q, s)
                : kind == 2 ? dCreateCapsule(NULL, p, q)
                : kind == 3 ? dCreateCylinder(NULL, p, q)
                            : dCreatePlane(NULL, 0.6, 0, 0.8, p - 1);
        draw_frame(&random, R);
        dMatrix3 rotation = {R[0], R[1], R[2], 0, R[3], R[4], R[5], 0, R[6], R[7], R[8], 0};
        if (kind != 4) dGeomSetRotation(other, rotation);
        draw_direction(&random, d);
        for (int i = 0; i < 3; i++) x[i] = draw_uniform(&random, 0.5, 1) * (r + 0.5 * (p + q)) * d[i];
        dGeomSetPosition(ball, x[0], x[1], x[2]);
        dGeomSetPosition(sphere, x[0], x[1], x[2]);
        dContactGeom theirs[TEST_TIP_CONTACTS], ours[TEST_TIP_CONTACTS];
        int n = dCollide(sphere, other, TEST_TIP_CONTACTS, theirs, sizeof theirs[0]);
        int m = dCollide(ball, other, TEST_TIP_CONTACTS, ours, sizeof ours[0]);
        /* a centre inside: ODE's sphere-box and sphere-cylinder take the nearest face there, too, but not the rest */
        double distance, nearest[3], normal[3];
        if (kind != 4) assert_int_equal(pinch_tip_closest_point(other, x, &distance, nearest, normal), PINCH_OK);
        if (n == 1 && theirs[0].depth > 1e-9 && (kind == 4 || distance > 1e-3)) {
            assert_int_equal(m, 1);
            touching++;
            assert_close(ours[0].depth, theirs[0].depth, 1e-9);
            for (int i = 0; i < 3; i++) assert_close(ours[0].normal[i], theirs[0].normal[i], 1e-9);
            assert_true(ours[0].g1 == ball && ours[0].g2 == other);
            int k = dCollide(other, ball, TEST_TIP_CONTACTS, ours, sizeof ours[0]);
            assert_int_equal(k, 1);
            assert_true(ours[0].g1 == other && ours[0].g2 == ball);
            for (int i = 0; i < 3; i++) assert_close(ours[0].normal[i], -theirs[0].normal[i], 1e-9);
        }
        dGeomDestroy(ball);
        dGeomDestroy(sphere);
        dGeomDestroy(other);
    }
    assert_true(touching > TRIALS);
}

/* ODE's other classes: plane, trimesh, convex, transform, offset, ray. */
static void test_odes_classes(void **state)
{
    (void)state;
    static const double V[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const dTriIndex T[] = {0, 1, 2, 0, 2, 3};
    test_tip t = test_tip_of(PINCH_TIP_ELLIPSOID, 0.2, 0.1, 0.05, 0),
             box = test_tip_of(PINCH_TIP_BOX, 0.2, 0.1, 0.06, 0);
    dContactGeom c[TEST_TIP_CONTACTS];
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, V, 3 * sizeof(double), 4, T, 6, 3 * sizeof(dTriIndex));
    dGeomID ground[2] = {dCreateTriMesh(NULL, data, NULL, NULL, NULL), dCreatePlane(NULL, 0, 0, 1, 0)};
    for (int k = 0; k < 2; k++) {
        test_tip_place(&t, (const double[3]){0.3, 0.3, 0.049}, TEST_TIP_UPRIGHT); /* over the triangles' common edge */
        assert_int_equal(dCollide(t.geom, ground[k], TEST_TIP_CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].depth, 0.001, 1e-9);
        assert_close(c[0].normal[2], 1, 1e-9);
        assert_int_equal(dCollide(ground[k], t.geom, TEST_TIP_CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].normal[2], -1, 1e-9);
        test_tip_place(&t, (const double[3]){0.1, 0.3, 0.049},
                       TEST_TIP_UPRIGHT); /* the edge's triangles see it differently */
        assert_int_equal(dCollide(t.geom, ground[k], TEST_TIP_CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].normal[2], 1, 1e-9);
        test_tip_place(&box, (const double[3]){0.2, 0.25, 0.029}, TEST_TIP_UPRIGHT);
        int count = dCollide(box.geom, ground[k], TEST_TIP_CONTACTS, c, sizeof c[0]);
        assert_in_range(count, 4, 8);
        for (int i = 0; i < count; i++) {
            assert_close(c[i].depth, 0.001, 1e-9);
            assert_close(c[i].normal[2], 1, 1e-9);
        }
    }
    test_tip_place(&t, (const double[3]){0, 0, 0.5}, TEST_TIP_UPRIGHT);
    assert_int_equal(dCollide(t.geom, ground[0], TEST_TIP_CONTACTS, c, sizeof c[0]), 0);
    for (int k = 0; k < 2; k++) dGeomDestroy(ground[k]);
    dGeomTriMeshDataDestroy(data);

    dGeomID ray = dCreateRay(NULL, 2);
    dGeomRaySet(ray, 0, 0.05, 2, 0, 0, -1);
    assert_int_equal(dCollide(ray, t.geom, TEST_TIP_CONTACTS, c, sizeof c[0]), 1);
    assert_close(c[0].depth, 1.5 - 0.05 * sqrt(0.75), 1e-9); /* z = c sqrt(1 - (y/b)^2) */
    assert_true(c[0].normal[2] > 0 && c[0].g1 == ray);
    dGeomRaySet(ray, 0, 0, 0.5, 0, 0, -1); /* from inside */
    assert_int_equal(dCollide(t.geom, ray, TEST_TIP_CONTACTS, c, sizeof c[0]), 1);
    assert_close(c[0].depth, 0.05, 1e-9);
    dGeomRaySet(ray, 0, 0.101, 2, 0, 0, -1);
    assert_int_equal(dCollide(ray, t.geom, TEST_TIP_CONTACTS, c, sizeof c[0]), 0);
    dGeomDestroy(ray);
    test_tip_free(&box);
    test_tip_free(&t);
}

static void test_convex_and_offsets(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 5);
    dContactGeom c[TEST_TIP_CONTACTS], d[TEST_TIP_CONTACTS];
    dWorldID world = dWorldCreate();
    for (int trial = 0; trial < 200; trial++) {
        test_tip a, b;
        do {
            test_tip_make(&random, PINCH_TIP_CONVEX, &b);
            if (b.tip.skin == 0) break;
            test_tip_free(&b);
        } while (true);
        test_tip_make(&random, PINCH_TIP_ELLIPSOID, &a);
        test_tips_touch(&random, &a, &b, 0.7, 1);
        int count = test_tips_collide(&a, &b, c);
        /* ODE's convex, on a body, with an offset */
        dGeomID convex =
            dCreateConvex(NULL, b.planes, b.convex.plane_count, b.points, b.convex.point_count, b.polygons);
        dBodyID body = dBodyCreate(world);
        dGeomSetBody(convex, body);
        dBodySetPosition(body, 1, 2, 3);
        dGeomSetOffsetWorldPosition(convex, b.position[0], b.position[1], b.position[2]);
        dGeomSetOffsetWorldRotation(convex, dGeomGetRotation(b.geom));
        pinch_tip_reset_statistics();
        assert_int_equal(dCollide(a.geom, convex, TEST_TIP_CONTACTS, d, sizeof d[0]), 0);
        assert_int_equal(pinch_tip_statistics().unknown_convex, 1);
        assert_int_equal(pinch_tip_know_convex(convex, &b.convex), PINCH_OK);
        assert_int_equal(dCollide(a.geom, convex, TEST_TIP_CONTACTS, d, sizeof d[0]), count);
        for (int k = 0; k < count; k++)
            for (int i = 0; i < 3; i++) assert_close(c[k].pos[i], d[k].pos[i], 1e-9);
        assert_int_equal(pinch_tip_know_convex(convex, NULL), PINCH_OK);
        dGeomDestroy(convex);
        test_tip_free(&a);
        test_tip_free(&b);
    }
    dWorldDestroy(world);
}

/* ODE's own classes, taken over: capsule beside cylinder, axes parallel, is a line. It lasts: the last of the tests. */
static void test_taken_over(void **state)
{
    (void)state;
    dGeomID capsule = dCreateCapsule(NULL, 0.03, 0.1), cylinder = dCreateCylinder(NULL, 0.05, 0.2);
    dContactGeom c[TEST_TIP_CONTACTS];
    dGeomSetPosition(capsule, 0.079, 0, 0.02);
    assert_int_equal(pinch_tip_take_over(dCapsuleClass, dCylinderClass), PINCH_OK);
    for (int swapped = 0; swapped < 2; swapped++) {
        dGeomID first = swapped ? cylinder : capsule, second = swapped ? capsule : cylinder;
        assert_int_equal(dCollide(first, second, TEST_TIP_CONTACTS, c, sizeof c[0]), 2);
        for (int k = 0; k < 2; k++) {
            assert_true(c[k].g1 == first && c[k].g2 == second);
            assert_close(c[k].depth, 0.001, 1e-9);
            assert_close(c[k].normal[0], swapped ? -1 : 1, 1e-9);
        }
    }
    dGeomDestroy(capsule);
    dGeomDestroy(cylinder);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_ellipsoid), cmocka_unit_test(test_like_odes_sphere),
        cmocka_unit_test(test_odes_classes),    cmocka_unit_test(test_convex_and_offsets),
        cmocka_unit_test(test_taken_over),
    };
    int failed = cmocka_run_group_tests_name("tips and ODE's classes", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
