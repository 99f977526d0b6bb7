/* Compares mass properties, distances and supports of the scene's shapes with closed forms. */

#include "support/cmocka_all.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <stdlib.h>
#include <string.h>

/* rounding of a few dozen operations on numbers of size one */
static const double ROUNDING = 1e-14;

static scene_shape box(double x, double y, double z)
{
    scene_shape s = {.type = SCENE_BOX, .u.box.size = {x, y, z}};
    assert_int_equal(scene_shape_complete(&s), SCENE_SHAPE_FINE);
    return s;
}

static scene_shape round_shape(scene_shape_type type, double radius, double length)
{
    scene_shape s = {.type = type};
    if (type == SCENE_SPHERE) {
        s.u.sphere.radius = radius;
    } else {
        s.u.cylinder.radius = radius;
        s.u.cylinder.length = length;
    }
    assert_int_equal(scene_shape_complete(&s), SCENE_SHAPE_FINE);
    return s;
}

static scene_shape ellipsoid(double a, double b, double c)
{
    scene_shape s = {.type = SCENE_ELLIPSOID, .u.ellipsoid.radii = {a, b, c}};
    assert_int_equal(scene_shape_complete(&s), SCENE_SHAPE_FINE);
    return s;
}

static scene_shape_fault complete_points(scene_shape *s, const double *points, size_t count)
{
    memset(s, 0, sizeof *s);
    s->type = SCENE_CONVEX;
    s->u.convex.count = count;
    s->u.convex.vertices = malloc(3 * count * sizeof *points);
    memcpy(s->u.convex.vertices, points, 3 * count * sizeof *points);
    return scene_shape_complete(s);
}

static scene_shape_fault complete_prism(scene_shape *s, const double *corners, size_t count, double height)
{
    memset(s, 0, sizeof *s);
    s->type = SCENE_PRISM;
    s->u.prism.count = count;
    s->u.prism.height = height;
    s->u.prism.vertices = malloc(2 * count * sizeof *corners);
    memcpy(s->u.prism.vertices, corners, 2 * count * sizeof *corners);
    return scene_shape_complete(s);
}

/* the box as eight points about `centre` */
static scene_shape box_of_points(double x, double y, double z, const double centre[3])
{
    double points[24];
    for (int i = 0; i < 8; i++) {
        points[3 * i] = centre[0] + (i & 1 ? 0.5 : -0.5) * x;
        points[3 * i + 1] = centre[1] + (i & 2 ? 0.5 : -0.5) * y;
        points[3 * i + 2] = centre[2] + (i & 4 ? 0.5 : -0.5) * z;
    }
    scene_shape s;
    assert_int_equal(complete_points(&s, points, 8), SCENE_SHAPE_FINE);
    return s;
}

static void assert_inertia(const scene_shape *s, const double expected[9], double tolerance)
{
    for (int i = 0; i < 9; i++) assert_close(s->unit_inertia[i], expected[i], tolerance);
}

static void test_inertia_closed_forms(void **state)
{
    (void)state;
    scene_shape s = box(1, 2, 3);
    assert_close(s.volume, 6.0, ROUNDING);
    assert_inertia(&s, (double[9]){13.0 / 12, 0, 0, 0, 10.0 / 12, 0, 0, 0, 5.0 / 12}, ROUNDING);
    assert_close(s.bounding_radius, 0.5 * sqrt(14.0), ROUNDING);

    s = round_shape(SCENE_SPHERE, 2, 0);
    assert_inertia(&s, (double[9]){1.6, 0, 0, 0, 1.6, 0, 0, 0, 1.6}, ROUNDING);

    s = round_shape(SCENE_CYLINDER, 1, 2);
    assert_inertia(&s, (double[9]){7.0 / 12, 0, 0, 0, 7.0 / 12, 0, 0, 0, 0.5}, ROUNDING);

    s = ellipsoid(1, 2, 3);
    assert_inertia(&s, (double[9]){2.6, 0, 0, 0, 2.0, 0, 0, 0, 1.0}, ROUNDING);
}

/* the capsule's mean squares by the midpoint rule over its slices: an independent, slow way */
static void test_capsule_inertia(void **state)
{
    (void)state;
    double r = 0.3, l = 0.8, volume = 0, zz = 0, xx = 0;
    int slices = 200000;
    for (int i = 0; i < slices; i++) {
        double z = (i + 0.5) / slices * (r + 0.5 * l), over = fmax(z - 0.5 * l, 0.0);
        double square = r * r - over * over;
        volume += square;
        zz += square * z * z;
        xx += square * square / 4;
    }
    scene_shape s = round_shape(SCENE_CAPSULE, r, l);
    assert_close(s.volume, volume * 2 * SCENE_PI * (r + 0.5 * l) / slices, 1e-9);
    assert_close(s.unit_inertia[0], (xx + zz) / volume, 1e-9);
    assert_close(s.unit_inertia[8], 2 * xx / volume, 1e-9);
}

static void test_convex_box_is_the_box(void **state)
{
    (void)state;
    scene_shape exact = box(1, 2, 3), s = box_of_points(1, 2, 3, (double[3]){5, -7, 11});
    assert_int_equal(s.hull.vertex_count, 8);
    assert_int_equal(s.hull.face_count, 6); /* coplanar triangles merged */
    assert_close(s.volume, 6.0, 1e-12);
    assert_inertia(&s, exact.unit_inertia, 1e-12);
    for (int k = 0; k < 3; k++) assert_close(s.shift[k], ((double[3]){5, -7, 11})[k], 1e-12);
    assert_close(s.bounding_radius, exact.bounding_radius, 1e-12);
    scene_shape_free(&s);
}

/* far away and back: what is centred already must not move again */
static void test_recentring_settles(void **state)
{
    (void)state;
    scene_shape s = box_of_points(0.1, 0.2, 0.3, (double[3]){1e6, -1e6, 1e6}), again;
    assert_int_equal(complete_points(&again, s.u.convex.vertices, 8), SCENE_SHAPE_FINE);
    for (int k = 0; k < 3; k++) assert_true(again.shift[k] == 0.0);
    assert_memory_equal(again.u.convex.vertices, s.u.convex.vertices, 24 * sizeof(double));
    scene_shape_free(&s);
    scene_shape_free(&again);
}

/* tetrahedron with corners at the origin and the unit points: C = 1/80 off, 3/80 on the diagonal about its centre */
static void test_tetrahedron(void **state)
{
    (void)state;
    double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    scene_shape s;
    assert_int_equal(complete_points(&s, points, 4), SCENE_SHAPE_FINE);
    assert_close(s.volume, 1.0 / 6, ROUNDING);
    for (int k = 0; k < 3; k++) assert_close(s.shift[k], 0.25, ROUNDING);
    double on = 3.0 / 40, off = 1.0 / 80;
    assert_inertia(&s, (double[9]){on, off, off, off, on, off, off, off, on}, ROUNDING);
    scene_shape_free(&s);
}

static void test_prism_inertia(void **state)
{
    (void)state;
    double square[8] = {1, 1, 3, 1, 3, 4, 1, 4};
    scene_shape s, exact = box(2, 3, 5);
    assert_int_equal(complete_prism(&s, square, 4, 5), SCENE_SHAPE_FINE);
    assert_inertia(&s, exact.unit_inertia, 1e-13);
    assert_close(s.shift[0], 2, ROUNDING);
    assert_close(s.shift[1], 2.5, ROUNDING);
    assert_true(s.shift[2] == 0.0);
    scene_shape_free(&s);
    /* isosceles right triangle, hypotenuse 1 along y: the paper's prism */
    double triangle[6] = {0.5, 0, 0, 0.5, 0, -0.5};
    assert_int_equal(complete_prism(&s, triangle, 3, 1), SCENE_SHAPE_FINE);
    assert_close(s.shift[0], 1.0 / 6, ROUNDING);
    assert_close(s.unit_inertia[8], 1.0 / 72 + 1.0 / 24, ROUNDING);
    scene_shape_free(&s);
}

static void test_bad_hulls(void **state)
{
    (void)state;
    scene_shape s;
    double flat[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    assert_int_equal(complete_points(&s, flat, 4), SCENE_SHAPE_FLAT);
    scene_shape_free(&s);
    double same[12] = {0};
    assert_int_equal(complete_points(&s, same, 4), SCENE_SHAPE_FLAT);
    scene_shape_free(&s);
    double clockwise[6] = {0, 0, 0, 1, 1, 0};
    assert_int_equal(complete_prism(&s, clockwise, 3, 1), SCENE_SHAPE_CLOCKWISE);
    scene_shape_free(&s);
    double dented[8] = {0, 0, 2, 0, 0.5, 0.5, 0, 2};
    assert_int_equal(complete_prism(&s, dented, 4, 1), SCENE_SHAPE_NOT_CONVEX);
    scene_shape_free(&s);
    double line[6] = {0, 0, 1, 0, 2, 0};
    assert_int_equal(complete_prism(&s, line, 3, 1), SCENE_SHAPE_NOT_CONVEX);
    scene_shape_free(&s);
    double star[10]; /* left turns only, but twice around */
    for (int i = 0; i < 5; i++) {
        star[2 * i] = cos(4 * SCENE_PI * i / 5);
        star[2 * i + 1] = sin(4 * SCENE_PI * i / 5);
    }
    assert_int_equal(complete_prism(&s, star, 5, 1), SCENE_SHAPE_NOT_CONVEX);
    scene_shape_free(&s);
    scene_shape huge = {.type = SCENE_BOX, .u.box.size = {1e200, 1e200, 1}};
    assert_int_equal(scene_shape_complete(&huge), SCENE_SHAPE_OUT_OF_RANGE);
}

static void test_interior_points_are_dropped(void **state)
{
    (void)state;
    double points[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.1, 0.1, 0.1};
    scene_shape s;
    assert_int_equal(complete_points(&s, points, 5), SCENE_SHAPE_FINE);
    assert_int_equal(s.hull.vertex_count, 4);
    assert_int_equal(s.u.convex.count, 5);
    scene_shape_free(&s);
}

/* every polygon counter-clockwise from outside, every vertex on the inner side of every plane */
static void test_hull_orientation(void **state)
{
    (void)state;
    double points[60];
    unsigned random = 1;
    for (int i = 0; i < 60; i++) {
        random = random * 1664525u + 1013904223u;
        points[i] = random / 4294967296.0;
    }
    scene_shape s;
    assert_int_equal(complete_points(&s, points, 20), SCENE_SHAPE_FINE);
    const scene_hull *h = &s.hull;
    const unsigned *polygon = h->polygons;
    for (size_t f = 0; f < h->face_count; polygon += 1 + polygon[0], f++) {
        double a[3], b[3], n[3];
        scene_subtract(h->vertices + 3 * polygon[2], h->vertices + 3 * polygon[1], a);
        scene_subtract(h->vertices + 3 * polygon[3], h->vertices + 3 * polygon[1], b);
        scene_cross(a, b, n);
        assert_true(scene_dot(n, h->planes + 4 * f) > 0.0);
        for (size_t i = 0; i < h->vertex_count; i++)
            assert_true(scene_dot(h->planes + 4 * f, h->vertices + 3 * i) <= h->planes[4 * f + 3] + 1e-12);
    }
    assert_int_equal((size_t)(polygon - h->polygons), h->polygons_length);
    scene_shape_free(&s);
}

static void assert_distance(const scene_shape *s, double x, double y, double z, double expected)
{
    double p[3] = {x, y, z};
    assert_close(scene_shape_distance(s, p), expected, 1e-13);
}

static void test_distances(void **state)
{
    (void)state;
    scene_shape s = box(2, 4, 6);
    assert_distance(&s, 0, 0, 0, -1);
    assert_distance(&s, 1, 2, 3, 0);
    assert_distance(&s, 4, 6, 3, 5);
    s = round_shape(SCENE_CAPSULE, 1, 4);
    assert_distance(&s, 0, 0, 3, 0);
    assert_distance(&s, 3, 0, 6, 4);
    assert_distance(&s, 0.5, 0, 1, -0.5);
    s = round_shape(SCENE_CYLINDER, 1, 4);
    assert_distance(&s, 4, 0, 6, 5);
    assert_distance(&s, 0, 0, 1.75, -0.25);
    s = box_of_points(2, 4, 6, (double[3]){0, 0, 0});
    assert_distance(&s, 0, 0, 0, -1);
    assert_distance(&s, 4, 6, 3, 5);
    assert_distance(&s, 4, 5, -15, sqrt(162));
    assert_distance(&s, 0.5, 0, 3.5, 0.5);
    scene_shape_free(&s);
}

static void test_ellipsoid_distance(void **state)
{
    (void)state;
    scene_shape s = ellipsoid(3, 2, 1);
    assert_distance(&s, 0, 0, 0, -1);
    assert_distance(&s, 5, 0, 0, 2);
    assert_distance(&s, 0, 0, -1.5, 0.5);
    assert_distance(&s, 3, 0, 0, 0);
    /* points along the normal of a known surface point have a known distance; inside up to the focal set */
    double u[3] = {0.36, 0.48, 0.8}, on[3] = {3 * u[0], 2 * u[1], u[2]}, n[3] = {u[0] / 3, u[1] / 2, u[2]};
    double length = scene_norm(n);
    for (double d = -0.3; d < 100; d = d < 0 ? d + 0.1 : 2 * d + 0.01)
        assert_distance(&s, on[0] + d * n[0] / length, on[1] + d * n[1] / length, on[2] + d * n[2] / length, d);
    /* on the middle plane inside the focal ellipse the nearest point is above it */
    assert_distance(&s, 1, 0, 0, -hypot(1.0 / 8, sqrt(55.0 / 64)));
    s = ellipsoid(2, 2, 2);
    assert_distance(&s, 0, 0, 0, -2);
    assert_distance(&s, 3, 4, 0, 3);
    /* needle and disc: no overflow, no NaN */
    s = ellipsoid(1, 1e-6, 1e-6);
    assert_close(scene_shape_distance(&s, (double[3]){0.5, 1, 0}), 1 - 1e-6 * sqrt(0.75), 1e-12);
}

static void test_pointing_in(void **state)
{
    (void)state;
    scene_shape s = box(2, 2, 2);
    double edge[3] = {1, 1, 0}, face[3] = {1, 0, 0};
    assert_true(scene_shape_points_in(&s, edge, (double[3]){-1, 0, 0}, 1e-9));
    assert_true(scene_shape_points_in(&s, edge, (double[3]){0, -1, 0}, 1e-9));
    assert_false(scene_shape_points_in(&s, edge, (double[3]){0, 0, 1}, 1e-9));
    assert_false(scene_shape_points_in(&s, face, (double[3]){1, 0, 0}, 1e-9));
    assert_false(scene_shape_points_in(&s, face, (double[3]){0, 1, 0}, 1e-9));
    s = round_shape(SCENE_CYLINDER, 1, 2);
    assert_true(scene_shape_points_in(&s, face, (double[3]){-1, 0, 0}, 1e-9));
    assert_false(scene_shape_points_in(&s, face, (double[3]){0, 0, -1}, 1e-9));
    assert_true(scene_shape_points_in(&s, (double[3]){1, 0, 1}, (double[3]){0, 0, -1}, 1e-9));
    s = ellipsoid(3, 2, 1);
    assert_true(scene_shape_points_in(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, -1}, 1e-9));
    assert_false(scene_shape_points_in(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, 1}, 1e-9));
}

static void assert_support(const scene_shape *s, double dx, double dy, double dz, double x, double y, double z)
{
    double d[3] = {dx, dy, dz}, middle[3];
    scene_shape_support(s, d, middle);
    assert_close(middle[0], x, 1e-12);
    assert_close(middle[1], y, 1e-12);
    assert_close(middle[2], z, 1e-12);
}

static void test_supports(void **state)
{
    (void)state;
    scene_shape s = box(2, 4, 6);
    assert_support(&s, 1, 0, 0, 1, 0, 0);
    assert_support(&s, 0.6, -0.8, 0, 1, -2, 0);
    s = round_shape(SCENE_CAPSULE, 1, 4);
    assert_support(&s, 1, 0, 0, 1, 0, 0);
    assert_support(&s, 0.6, 0, 0.8, 0.6, 0, 2.8);
    s = round_shape(SCENE_CYLINDER, 1, 4);
    assert_support(&s, 0, 0, -1, 0, 0, -2);
    assert_support(&s, 0, 1, 0, 0, 1, 0);
    s = ellipsoid(3, 2, 1);
    assert_support(&s, 0, 1, 0, 0, 2, 0);
    s = box_of_points(2, 4, 6, (double[3]){0, 0, 0});
    assert_support(&s, 0, 0, 1, 0, 0, 3);
    assert_support(&s, 0, 0.6, 0.8, 0, 2, 3);
    scene_shape_free(&s);
    /* the middle of a face is its area's, not its corners' */
    double trapezoid[8] = {0, -2, 3, -1, 3, 1, 0, 2};
    assert_int_equal(complete_prism(&s, trapezoid, 4, 1), SCENE_SHAPE_FINE);
    assert_support(&s, 0, 0, 1, 0, 0, 0.5);
    scene_shape_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_inertia_closed_forms),
        cmocka_unit_test(test_capsule_inertia),
        cmocka_unit_test(test_convex_box_is_the_box),
        cmocka_unit_test(test_recentring_settles),
        cmocka_unit_test(test_tetrahedron),
        cmocka_unit_test(test_prism_inertia),
        cmocka_unit_test(test_bad_hulls),
        cmocka_unit_test(test_interior_points_are_dropped),
        cmocka_unit_test(test_hull_orientation),
        cmocka_unit_test(test_distances),
        cmocka_unit_test(test_ellipsoid_distance),
        cmocka_unit_test(test_pointing_in),
        cmocka_unit_test(test_supports),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
