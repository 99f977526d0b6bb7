/*
 * These rules hold for contacts of all shapes: they are mirrored to the bit when the bodies are swapped, they stay the
 * same when both are moved together, and it does not matter where a polyhedron or a mesh has its origin.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <string.h>

enum { TRIALS = 400, MOVES = 1000 };

static int deepest(const dContactGeom *c, int count)
{
    int best = 0;
    for (int k = 1; k < count; k++)
        if (c[k].depth > c[best].depth) best = k;
    return best;
}

static void test_swapped_is_mirrored(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 1);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b;
        dContactGeom c[TEST_TIP_CONTACTS], d[TEST_TIP_CONTACTS];
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &a);
        if (draw_chance(&random, 0.3)) {
            b = a; /* the same shape twice */
            if (b.tip.pieces) b.tip.pieces = &a.convex;
            test_tip_make_geom(&b);
        } else {
            test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        }
        test_tips_touch(&random, &a, &b, 0.3, 1);
        int count = test_tips_collide(&a, &b, c);
        assert_int_equal(test_tips_collide(&b, &a, d), count);
        for (int k = 0; k < count; k++) {
            assert_true(c[k].g1 == a.geom && c[k].g2 == b.geom && d[k].g1 == b.geom && d[k].g2 == a.geom);
            assert_true(c[k].depth == d[k].depth);
            for (int i = 0; i < 3; i++) assert_true(c[k].pos[i] == d[k].pos[i] && c[k].normal[i] == -d[k].normal[i]);
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

static void turn(const double Q[9], const double *v, double *out)
{
    double r[3];
    for (int i = 0; i < 3; i++) r[i] = Q[3 * i] * v[0] + Q[3 * i + 1] * v[1] + Q[3 * i + 2] * v[2];
    memcpy(out, r, sizeof r);
}

static void move(test_tip *t, const double Q[9], const double *shift)
{
    double x[3], R[9];
    turn(Q, t->position, x);
    for (int i = 0; i < 3; i++) x[i] += shift[i];
    for (int j = 0; j < 3; j++) {
        double column[3] = {t->R[j], t->R[3 + j], t->R[6 + j]};
        turn(Q, column, column);
        for (int i = 0; i < 3; i++) R[3 * i + j] = column[i];
    }
    test_tip_place(t, x, R);
}

/* Depth and normal, and where there is one point its position; a point of a manifold may be another one where two are
 * equally deep. */
static void test_moved_together(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 2);
    int compared = 0;
    for (int trial = 0; trial < MOVES; trial++) {
        test_tip a, b;
        dContactGeom c[TEST_TIP_CONTACTS], d[TEST_TIP_CONTACTS];
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &a);
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        test_tips_touch(&random, &a, &b, 0.7, 1);
        int count = test_tips_collide(&a, &b, c);
        double Q[9], shift[3];
        draw_frame(&random, Q);
        for (int i = 0; i < 3; i++) shift[i] = draw_uniform(&random, -5, 5);
        move(&a, Q, shift);
        move(&b, Q, shift);
        int moved = test_tips_collide(&a, &b, d);
        if (count > 0 && c[deepest(c, count)].depth > 1e-9) {
            assert_true(moved > 0);
            const dContactGeom *x = &c[deepest(c, count)], *y = &d[deepest(d, moved)];
            assert_close(x->depth, y->depth, 1e-9);
            double n[3];
            turn(Q, x->normal, n);
            for (int i = 0; i < 3; i++) assert_close(n[i], y->normal[i], 1e-9);
            /* a superellipsoid's flat spots make much of rounding in the normal */
            bool smooth = a.tip.type != PINCH_TIP_SUPERELLIPSOID && b.tip.type != PINCH_TIP_SUPERELLIPSOID;
            double at[3];
            turn(Q, x->pos, at);
            for (int i = 0; i < 3 && count == 1 && moved == 1; i++)
                assert_close(at[i] + shift[i], y->pos[i], smooth ? 1e-9 : 1e-6);
            compared++;
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
    assert_true(compared > MOVES / 2);
}

/* The same body, its corners given from another origin, `from` in its axes. */
static void make_about(const test_tip *tip, const double from[3], test_tip *about)
{
    double origin[3];
    *about = *tip;
    for (unsigned k = 0; k < 3 * tip->convex.point_count; k++) about->points[k] -= from[k % 3];
    for (unsigned k = 0; k < tip->convex.plane_count; k++)
        for (int i = 0; i < 3; i++) about->planes[4 * k + 3] -= about->planes[4 * k + i] * from[i];
    about->convex.points = about->points;
    about->convex.planes = about->planes;
    about->convex.polygons = about->polygons;
    about->tip.pieces = &about->convex;
    test_tip_make_geom(about);
    for (int i = 0; i < 3; i++)
        origin[i] =
            tip->position[i] + tip->R[3 * i] * from[0] + tip->R[3 * i + 1] * from[1] + tip->R[3 * i + 2] * from[2];
    test_tip_place(about, origin, tip->R);
}

/* A polyhedron's origin, which is not inside it where it is a piece of a larger body, is of no matter. */
static void test_origin_outside(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 11);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b, about;
        dContactGeom c[TEST_TIP_CONTACTS], d[TEST_TIP_CONTACTS];
        double from[3];
        test_tip_make(&random, PINCH_TIP_CONVEX, &a);
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        test_tips_touch(&random, &a, &b, 0.5, 1);
        for (int i = 0; i < 3; i++) from[i] = draw_uniform(&random, -4, 4);
        make_about(&a, from, &about);
        int count = test_tips_collide(&a, &b, c), again = test_tips_collide(&about, &b, d);
        double depth = count ? c[deepest(c, count)].depth : 0, same = again ? d[deepest(d, again)].depth : 0;
        assert_close(depth, same, 1e-9);
        test_tip_free(&about);
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

/* A polyhedron on a triangle of a mesh whose origin is far away is as deep as on a plane. */
static void test_mesh_far_from_its_origin(void **state)
{
    (void)state;
    static const double V[9] = {-10, 20, 7, 30, 20, 7, 10, 60, 7};
    static const dTriIndex T[3] = {0, 1, 2};
    static const double MIDDLE[3] = {10, 30, 7};
    pinch_random random;
    pinch_random_seed(&random, 12);
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, V, 3 * sizeof(double), 3, T, 3, 3 * sizeof(dTriIndex));
    dGeomID mesh = dCreateTriMesh(NULL, data, NULL, NULL, NULL), plane = dCreatePlane(NULL, 0, 0, 1, 7);
    for (int trial = 0; trial < 100; trial++) {
        test_tip a;
        dContactGeom c[TEST_TIP_CONTACTS], d[TEST_TIP_CONTACTS];
        double R[9], down[3] = {0, 0, -1}, x[3] = {MIDDLE[0], MIDDLE[1], MIDDLE[2]};
        test_tip_make(&random, PINCH_TIP_CONVEX, &a);
        draw_frame(&random, R);
        test_tip_place(&a, x, R);
        x[2] += draw_uniform(&random, 0.1, 0.99) * (test_tip_reach(&a, down) + MIDDLE[2]);
        test_tip_place(&a, x, R);
        int on_plane = dCollide(a.geom, plane, TEST_TIP_CONTACTS, c, sizeof *c);
        int on_mesh = dCollide(a.geom, mesh, TEST_TIP_CONTACTS, d, sizeof *d);
        assert_true(on_plane > 0 && on_mesh > 0);
        assert_close(c[deepest(c, on_plane)].depth, d[deepest(d, on_mesh)].depth, 1e-9);
        test_tip_free(&a);
    }
    dGeomDestroy(mesh);
    dGeomDestroy(plane);
    dGeomTriMeshDataDestroy(data);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_swapped_is_mirrored),
        cmocka_unit_test(test_moved_together),
        cmocka_unit_test(test_origin_outside),
        cmocka_unit_test(test_mesh_far_from_its_origin),
    };
    int failed = cmocka_run_group_tests_name("tip rules", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
