/*
 * Hulls of many vertices have a tree to find the farthest one in. It has to be the vertex that a look at all of them
 * finds, to the last bit, also where many are as far, as those of level faces are.
 */
#include "support/cmocka_all.h"

#include "collision/shape/hull.h"
#include "support/draw.h"
#include "support/vec3.h"

#include <stdlib.h>
#include <string.h>

enum { RINGS = 24, AROUND = 32, POINTS = RINGS * AROUND + 2, FACES = (RINGS + 1) * AROUND, DIRECTIONS = 3000 };

typedef struct lattice {
    double points[3 * POINTS], planes[4 * FACES];
    unsigned polygons[5 * FACES];
    pinch_convex convex;
} lattice;

/* The profile of a body of revolution: its radius and height from one pole (0) to the other (1). */
typedef void profile(double along, double *radius, double *height);

static void ball(double along, double *radius, double *height)
{
    *radius = sin(M_PI * along);
    *height = -cos(M_PI * along);
}

/* Two discs with their corners in rings, all level, and a rim of straight lines. */
static void can(double along, double *radius, double *height)
{
    *radius = fmin(1, 3 * fmin(along, 1 - along));
    *height = fmin(1, fmax(-1, 6 * (along - 0.5)));
}

static void put_point(lattice *l, unsigned k, double x, double y, double z)
{
    pinch_v3_set(l->points + 3 * k, x, y, z);
}

static unsigned at(int ring, int around)
{
    return (unsigned)(ring * AROUND + around % AROUND);
}

/* Adds a face of three or four corners, in their order seen from outside. */
static void put_face(lattice *l, unsigned face, unsigned **polygon, const unsigned *corners, unsigned count)
{
    double e[2][3], *plane = l->planes + 4 * face;
    const double *first = l->points + 3 * corners[0];
    for (int i = 0; i < 2; i++) pinch_v3_sub(l->points + 3 * corners[count - 2 + (unsigned)i], first, e[i]);
    pinch_v3_cross(e[0], e[1], plane);
    pinch_v3_scale(plane, 1 / pinch_v3_norm(plane));
    plane[3] = pinch_v3_dot(plane, first);
    *(*polygon)++ = count;
    memcpy(*polygon, corners, count * sizeof *corners);
    *polygon += count;
}

/* Makes a hull of rings of corners between two poles, stretched by `size`. */
static void make(lattice *l, profile *of, const double size[3], pinch_hull *hull)
{
    const unsigned south = RINGS * AROUND, north = south + 1;
    unsigned face = 0, *polygon = l->polygons;
    double radius, height;
    for (int ring = 0; ring < RINGS; ring++)
        for (int k = 0; k < AROUND; k++) {
            double angle = 2 * M_PI * k / AROUND;
            of((ring + 1.0) / (RINGS + 1), &radius, &height);
            put_point(l, at(ring, k), size[0] * radius * cos(angle), size[1] * radius * sin(angle), size[2] * height);
        }
    put_point(l, south, 0, 0, -size[2]);
    put_point(l, north, 0, 0, size[2]);
    for (int k = 0; k < AROUND; k++) {
        put_face(l, face++, &polygon, (const unsigned[]){south, at(0, k + 1), at(0, k)}, 3);
        put_face(l, face++, &polygon, (const unsigned[]){north, at(RINGS - 1, k), at(RINGS - 1, k + 1)}, 3);
        for (int ring = 0; ring + 1 < RINGS; ring++)
            put_face(l, face++, &polygon,
                     (const unsigned[]){at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)}, 4);
    }
    assert_int_equal(face, FACES);
    l->convex = (pinch_convex){l->planes, FACES, l->points, l->polygons, POINTS};
    assert_true(pinch_hull_of_convex(&l->convex, hull));
    assert_true(hull->tree.leaves > 0);
}

/* Looks for the vertex in both ways. d need not be a unit vector. */
static void look_along(const pinch_hull *hull, const double *d)
{
    unsigned found = pinch_hull_support_vertex(hull, d), expected = pinch_hull_scan_vertices(hull, d);
    const double *points = hull->convex.points;
    assert_int_equal(found, expected);
    for (unsigned k = 0; k < POINTS; k++)
        assert_true(pinch_v3_dot(points + 3 * k, d) <= pinch_v3_dot(points + 3 * found, d));
    double near = pinch_v3_dot(points + 3 * pinch_hull_near_vertex(hull, d), d);
    assert_true(near <= pinch_v3_dot(points + 3 * found, d));
}

/* Random directions, those of faces and axes, across edges, and next to all of these. */
static void look_around(const pinch_hull *hull, pinch_random *random)
{
    static const double NEXT[3] = {0, 1e-15, 1e-9};
    for (int i = 0; i < DIRECTIONS; i++) {
        double d[3], aside[3];
        for (int k = 0; k < 3; k++) {
            d[k] = draw_uniform(random, -1, 1);
            aside[k] = draw_uniform(random, -1, 1);
        }
        look_along(hull, d);
        if (i % 3 == 0) pinch_v3_copy(d, hull->convex.planes + 4 * (i % FACES));
        if (i % 3 == 1) pinch_v3_set(d, i % 2, i / 2 % 2, i / 4 % 2 - 0.5);
        if (i % 3 == 2) pinch_v3_cross(hull->arcs[i % hull->edge_count].u, aside, d);
        pinch_v3_add_scaled(d, NEXT[i / 3 % 3], aside);
        look_along(hull, d);
    }
}

static void test_farthest_vertices(void **state)
{
    (void)state;
    static const double SIZES[3][3] = {{1, 1, 1}, {0.02, 0.03, 0.01}, {1, 1, 1e-6}};
    pinch_random random;
    pinch_random_seed(&random, 67);
    lattice *l = malloc(sizeof *l);
    assert_non_null(l);
    for (int i = 0; i < 6; i++) {
        pinch_hull hull;
        make(l, i % 2 ? can : ball, SIZES[i / 2], &hull);
        look_around(&hull, &random);
        pinch_hull_free(&hull);
    }
    free(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_farthest_vertices)};
    return cmocka_run_group_tests_name("large_hulls", tests, NULL, NULL);
}
