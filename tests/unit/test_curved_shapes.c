/*
 * Flat capsules, superellipsoids, rounded boxes and cylinders of a scene: mass properties are compared with counted
 * points, distances are known along normals, supports lie on the surface, and a printed scene is read back.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHAPES = 6 };

static scene_shape shape_number(int k)
{
    scene_shape s;
    memset(&s, 0, sizeof s);
    switch (k) {
    case 0:
        s.type = SCENE_BOX;
        memcpy(s.u.box.size, (double[3]){1.0, 0.8, 0.6}, sizeof s.u.box.size);
        s.u.box.rounding = 0.2;
        break;
    case 1:
        s.type = SCENE_CYLINDER;
        s.u.cylinder.radius = 0.5;
        s.u.cylinder.length = 0.8;
        s.u.cylinder.rounding = 0.15;
        break;
    case 2:
        s.type = SCENE_FLAT_CAPSULE;
        s.u.flat_capsule.radius = 0.4;
        s.u.flat_capsule.length = 0.7;
        break;
    default: {
        static const double exponents[3][2] = {{1, 1}, {0.4, 0.6}, {1.3, 0.8}};
        s.type = SCENE_SUPERELLIPSOID;
        memcpy(s.u.superellipsoid.radii, (double[3]){0.6, 0.45, 0.5}, sizeof s.u.superellipsoid.radii);
        memcpy(s.u.superellipsoid.exponents, exponents[k - 3], sizeof s.u.superellipsoid.exponents);
    }
    }
    assert_int_equal(scene_shape_complete(&s), SCENE_SHAPE_FINE);
    return s;
}

static double middle_of_flat_capsule(const scene_shape *s)
{
    double r = s->u.flat_capsule.radius, l = s->u.flat_capsule.length, tube = r * r * l, dome = 2.0 / 3 * r * r * r;
    return -dome * (0.5 * l + 0.375 * r) / (tube + dome);
}

/* Below 1 inside, above outside: the shape's own definition. */
static double level(const scene_shape *s, const double x[3])
{
    double a = fabs(x[0]), b = fabs(x[1]), c = fabs(x[2]);
    if (s->type == SCENE_BOX) {
        const double *size = s->u.box.size, rounding = s->u.box.rounding;
        double over[3] = {fmax(a - 0.5 * size[0] + rounding, 0), fmax(b - 0.5 * size[1] + rounding, 0),
                          fmax(c - 0.5 * size[2] + rounding, 0)};
        return sqrt(over[0] * over[0] + over[1] * over[1] + over[2] * over[2]) / rounding;
    }
    if (s->type == SCENE_CYLINDER) {
        double rounding = s->u.cylinder.rounding;
        double out = fmax(sqrt(a * a + b * b) - s->u.cylinder.radius + rounding, 0);
        double up = fmax(c - 0.5 * s->u.cylinder.length + rounding, 0);
        return sqrt(out * out + up * up) / rounding;
    }
    if (s->type == SCENE_FLAT_CAPSULE) {
        double r = s->u.flat_capsule.radius, half = 0.5 * s->u.flat_capsule.length;
        double z = x[2] - middle_of_flat_capsule(s), over = fmax(z - half, 0);
        return fmax(sqrt(a * a + b * b + over * over) / r, -z / half);
    }
    const double *radii = s->u.superellipsoid.radii, *e = s->u.superellipsoid.exponents;
    double across = pow(a / radii[0], 2 / e[1]) + pow(b / radii[1], 2 / e[1]);
    return pow(across, e[1] / e[0]) + pow(c / radii[2], 2 / e[0]);
}

/* Points that fill the cube evenly: additive recurrence, Roberts' generalized golden ratio. With so many the quotients
 * are within 1.5e-3 of 1, with twenty times as many within 1e-4. */
static void test_moments(void **state)
{
    (void)state;
    enum { POINTS = 400000 };
    static const double STEP[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int k = 0; k < SHAPES; k++) {
        scene_shape s = shape_number(k);
        double R = s.bounding_radius, count = 0, sum[3] = {0}, square[3] = {0}, farthest = 0;
        for (int n = 1; n <= POINTS; n++) {
            double x[3];
            for (int i = 0; i < 3; i++) x[i] = R * (2 * fmod(n * STEP[i], 1) - 1);
            if (level(&s, x) > 1) continue;
            count++;
            farthest = fmax(farthest, scene_norm(x));
            for (int i = 0; i < 3; i++) sum[i] += x[i];
            for (int i = 0; i < 3; i++) square[i] += x[i] * x[i];
        }
        assert_close(s.volume / (8 * R * R * R * count / POINTS), 1, 3e-3);
        for (int i = 0; i < 3; i++) assert_close(sum[i] / count, 0, 1e-3 * R);
        for (int i = 0; i < 3; i++) {
            double expected = (square[(i + 1) % 3] + square[(i + 2) % 3]) / count;
            assert_close(s.unit_inertia[4 * i] / expected, 1, 3e-3);
        }
        assert_true(farthest <= R && farthest > 0.97 * R);
    }
}

static void draw_direction(unsigned *seed, double d[3])
{
    double length = 0;
    do {
        for (int i = 0; i < 3; i++) {
            *seed = *seed * 1664525u + 1013904223u;
            d[i] = (double)(*seed >> 8) / 8388608.0 - 1;
        }
        length = scene_norm(d);
    } while (!(length > 0.1 && length < 1));
    for (int i = 0; i < 3; i++) d[i] /= length;
}

/* The support along d is on the surface, points along d from there are as far outside as they were moved, no drawn
 * point of the surface is farther along d; d leads out there and its opposite in. */
static void test_supports_and_distances(void **state)
{
    (void)state;
    enum { DRAWS = 60 };
    unsigned seed = 1;
    for (int k = 0; k < SHAPES; k++) {
        scene_shape s = shape_number(k);
        double d[DRAWS][3], on[DRAWS][3];
        for (int n = 0; n < DRAWS; n++) {
            draw_direction(&seed, d[n]);
            scene_shape_support(&s, d[n], on[n]);
            assert_close(level(&s, on[n]), 1, 1e-9);
            assert_true(scene_norm(on[n]) <= s.bounding_radius * (1 + 1e-12));
            for (double t = -1e-4; t < 20; t = t < 0 ? t + 1e-4 : 3 * t + 1e-3) {
                double x[3];
                for (int i = 0; i < 3; i++) x[i] = on[n][i] + t * d[n][i];
                /* inside, something of a sharp rim or edge may be nearer */
                if (t < 0)
                    assert_true(scene_shape_distance(&s, x) >= t - 1e-9 && scene_shape_distance(&s, x) < 0);
                else
                    assert_close(scene_shape_distance(&s, x), t, 1e-9);
            }
            double back[3] = {-d[n][0], -d[n][1], -d[n][2]};
            assert_true(scene_shape_points_in(&s, on[n], back, 1e-9));
            assert_false(scene_shape_points_in(&s, on[n], d[n], 1e-9));
        }
        for (int n = 0; n < DRAWS; n++)
            for (int m = 0; m < DRAWS; m++) assert_true(scene_dot(on[m], d[n]) <= scene_dot(on[n], d[n]) + 1e-12);
    }
}

static void test_middle_of_features(void **state)
{
    (void)state;
    scene_shape s = shape_number(2);
    double middle[3], low = middle_of_flat_capsule(&s) - 0.5 * s.u.flat_capsule.length;
    scene_shape_support(&s, (double[3]){0, 0, -1}, middle);
    assert_close(middle[0], 0, 0);
    assert_close(middle[2], low, 1e-15);
    scene_shape_support(&s, (double[3]){0, 1, 0}, middle);
    assert_close(middle[1], 0.4, 1e-15);
    assert_close(middle[2], low + 0.35, 1e-15);
    s = shape_number(0);
    scene_shape_support(&s, (double[3]){1, 0, 0}, middle);
    assert_close(middle[0], 0.5, 1e-15);
    assert_close(middle[1], 0, 0);
    s = shape_number(4);
    assert_close(scene_shape_distance(&s, (double[3]){0, 0, 0}), -0.45, 1e-9);
}

static void print_to(const scene *s, char *text, size_t size)
{
    FILE *stream = fmemopen(text, size, "w");
    assert_non_null(stream);
    assert_int_equal(scene_print(s, stream), SCENE_OK);
    fclose(stream);
}

/* Every key is printed, and what is printed loads again as the same. */
static void test_printed(void **state)
{
    (void)state;
    static const char text[] =
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"superellipsoid\", \"radii\": [0.02, "
        "0.03, "
        "0.04], \"exponents\": [0.5, 0.75]}, \"mass\": 0.1}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, "
        "0, 0], \"tip\": {\"type\": \"flat_capsule\", \"radius\": 0.008, \"length\": 0.02}, \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 20000}, \"friction\": 0.5}, {\"point\": [0.02, 0, 0], \"normal\": [-1, 0, 0], "
        "\"tip\": {\"type\": \"box\", \"size\": [0.01, 0.02, 0.02], \"rounding\": 0.002}, \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 20000}, \"friction\": 0.5}], \"environment\": [{\"shape\": {\"type\": "
        "\"cylinder\", \"radius\": 0.1, \"length\": 0.02, \"rounding\": 0.005}, \"position\": [0, 0, -0.1], "
        "\"stiffness\": {\"normal\": 1e5}, \"friction\": 0.5}]}";
    char first[8192], second[8192], path[] = "/tmp/pinch-curved-XXXXXX";
    scene *s;
    scene_error error;
    int file = mkstemp(path);
    assert_true(file >= 0);
    FILE *stream = fdopen(file, "w");
    fputs(text, stream);
    fclose(stream);
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    print_to(s, first, sizeof first);
    scene_free(s);
    static const char *const keys[] = {"\"exponents\"", "0.75", "\"flat_capsule\"", "\"rounding\"", "0.002", "0.005"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (!strstr(first, keys[k])) fail_msg("no %s in %s", keys[k], first);
    stream = fopen(path, "w");
    assert_non_null(stream);
    fputs(first, stream);
    fclose(stream);
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    print_to(s, second, sizeof second);
    scene_free(s);
    remove(path);
    assert_string_equal(first, second);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moments),
        cmocka_unit_test(test_supports_and_distances),
        cmocka_unit_test(test_middle_of_features),
        cmocka_unit_test(test_printed),
    };
    return cmocka_run_group_tests_name("curved shapes", tests, NULL, NULL);
}
