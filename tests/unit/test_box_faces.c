/* What is put right in the points that ODE's collider finds where faces of two boxes lie on each other. */
#include "support/cmocka_all.h"

#include "contacts/collider_points.h"

#include <math.h>
#include <ode/ode.h>
#include <string.h>

enum { MOST = 8 };

/* Two boxes that touch along x: the normal points into the first. */
typedef struct pair {
    dGeomID geom[2];
    double position[2][3], rotation[2][12];
    pinch_detected_point point[MOST];
    int count;
} pair;

static void box_make(pair *p, int side, double x, double tilt, double depth)
{
    const double rotation[12] = {cos(tilt), 0, sin(tilt), 0, 0, 1, 0, 0, -sin(tilt), 0, cos(tilt), 0};
    const double position[3] = {x, 0, 0};
    p->geom[side] = dCreateBox(NULL, 1, depth, 1);
    memcpy(p->rotation[side], rotation, sizeof rotation);
    memcpy(p->position[side], position, sizeof position);
}

static void pair_make(pair *p, double tilt, double depth)
{
    p->count = 0;
    box_make(p, 0, 0.5, 0, 1);
    box_make(p, 1, -0.5, tilt, depth);
}

static void pair_free(const pair *p)
{
    dGeomDestroy(p->geom[0]);
    dGeomDestroy(p->geom[1]);
}

/* Adds a point of the face x = 0. */
static void add(pair *p, double y, double z)
{
    p->point[p->count++] = (pinch_detected_point){.position = {0, y, z}, .normal = {1, 0, 0}, .depth = 1e-6};
}

static int settle(pair *p)
{
    const int class[2] = {dGeomGetClass(p->geom[0]), dGeomGetClass(p->geom[1])};
    const pinch_pose pose[2] = {{p->position[0], p->rotation[0]}, {p->position[1], p->rotation[1]}};
    return pinch_settle_box_faces(p->geom, class, pose, p->point, p->count);
}

static void test_crossings_of_coincident_edges_are_dropped(void **state)
{
    (void)state;
    pair p;
    pair_make(&p, 1e-6, 1);
    add(&p, 0.5, 0.5);
    add(&p, 0.5, 0.1234); /* edges along z lie on each other */
    add(&p, 0.5, -0.5);
    add(&p, -0.5, -0.5);
    add(&p, -0.2, -0.5); /* and so do those along y */
    add(&p, -0.5, 0.5);
    add(&p, 0.5, 0.3);
    memcpy(p.point[6].normal, (double[3]){0, 1, 0}, sizeof p.point[6].normal); /* of other faces */
    assert_int_equal(settle(&p), 5);
    assert_true(p.point[4].normal[1] == 1);
    for (int k = 0; k < 4; k++)
        for (int i = 1; i < 3; i++) assert_true(fabs(p.point[k].position[i]) == 0.5);
    pair_free(&p);
}

/* The second box is narrower: its corners lie on edges of the first, and no edges along z lie on each other. */
static void test_other_points_stay(void **state)
{
    (void)state;
    pair p;
    pair_make(&p, 0, 0.5);
    add(&p, 0.25, 0.5);
    add(&p, -0.25, 0.5);
    add(&p, 0.25, 0.1);
    add(&p, -0.25, -0.5);
    assert_int_equal(settle(&p), 4);
    pair_free(&p);
}

/* A line has but two ends, and where all points are crossings, none of them is more than the others. */
static void test_something_is_left(void **state)
{
    (void)state;
    pair p;
    pair_make(&p, 0, 1);
    add(&p, 0.5, 0.1);
    add(&p, 0.5, -0.1);
    assert_int_equal(settle(&p), 2);
    add(&p, 0.5, 0.2);
    assert_int_equal(settle(&p), 3);
    pair_free(&p);
}

/* A program that turns normals by more than faces that lie on each other are tilted means it. */
static void test_normals_of_the_program_s_own_stay(void **state)
{
    (void)state;
    pair p;
    const double turned[3] = {cos(0.02), sin(0.02), 0};
    pair_make(&p, 1e-4, 1);
    add(&p, 0.5, 0.5);
    add(&p, -0.5, 0.5);
    memcpy(p.point[1].normal, turned, sizeof turned);
    assert_int_equal(settle(&p), 2);
    assert_true(p.point[0].normal[2] < 0);
    assert_memory_equal(p.point[1].normal, turned, sizeof turned);
    pair_free(&p);
}

static void test_the_normal_is_between_those_of_the_faces(void **state)
{
    (void)state;
    static const double tilt[3] = {1e-6, -1e-4, 0.01}; /* with the last, the faces do not lie on each other */
    for (int k = 0; k < 3; k++) {
        pair p;
        pair_make(&p, tilt[k], 1);
        add(&p, 0.5, 0.5);
        add(&p, -0.5, 0.5);
        (void)settle(&p);
        double turned = k < 2 ? 0.5 * tilt[k] : 0;
        for (int i = 0; i < 2; i++) {
            assert_true(fabs(p.point[i].normal[0] - cos(turned)) <= 1e-15 && p.point[i].normal[1] == 0);
            assert_true(fabs(p.point[i].normal[2] + sin(turned)) <= 1e-15);
        }
        pair_free(&p);
    }
}

static void test_other_shapes_are_left_alone(void **state)
{
    (void)state;
    pair p;
    pair_make(&p, 1e-6, 1);
    dGeomDestroy(p.geom[1]);
    p.geom[1] = dCreateSphere(NULL, 0.5);
    add(&p, 0.5, 0.1);
    add(&p, 0.5, 0.2);
    add(&p, 0.5, 0.5);
    assert_int_equal(settle(&p), 3);
    assert_true(p.point[0].normal[0] == 1);
    pair_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_crossings_of_coincident_edges_are_dropped),
        cmocka_unit_test(test_other_points_stay),
        cmocka_unit_test(test_something_is_left),
        cmocka_unit_test(test_normals_of_the_program_s_own_stay),
        cmocka_unit_test(test_the_normal_is_between_those_of_the_faces),
        cmocka_unit_test(test_other_shapes_are_left_alone),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
