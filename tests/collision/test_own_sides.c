/* How large a geom is in its own axes: what its box in the world is while it lies straight, whatever its pose. */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include "collision/ode/collide.h"

#include <pinch/fingertip.h>

#include <string.h>

enum { TURNS = 20 };

static void turn(pinch_random *random, dGeomID geom)
{
    dQuaternion q;
    for (int i = 0; i < 4; i++) q[i] = draw_uniform(random, -1, 1);
    dNormalize4(q);
    dGeomSetQuaternion(geom, q);
    dGeomSetPosition(geom, draw_uniform(random, -1, 1), draw_uniform(random, -1, 1), draw_uniform(random, -1, 1));
}

/* `near` m: what rounding does to a mesh's points in the world; 0: the sides are the same to the bit. */
static void expect_own_sides(dGeomID geom, double near)
{
    pinch_random random;
    dReal box[6];
    double sides[3], turned[3];
    pinch_random_seed(&random, 61);
    dGeomGetAABB(geom, box);
    assert_true(pinch_own_sides(geom, sides));
    for (int i = 0; i < 3; i++) assert_close(sides[i], box[2 * i + 1] - box[2 * i], near);
    for (int n = 0; n < TURNS; n++) {
        turn(&random, geom);
        assert_true(pinch_own_sides(geom, turned));
        for (int i = 0; i < 3; i++) assert_close(turned[i], sides[i], near);
    }
    dGeomDestroy(geom);
}

static void shapes_have_their_own_sides(void **state)
{
    (void)state;
    expect_own_sides(dCreateSphere(NULL, 0.3), 0);
    expect_own_sides(dCreateBox(NULL, 0.1, 0.2, 0.7), 0);
    expect_own_sides(dCreateCapsule(NULL, 0.1, 0.33), 0);
    expect_own_sides(dCreateCylinder(NULL, 0.1, 0.33), 0);
    for (int type = 0; type < PINCH_TIP_CONVEX; type++) {
        pinch_tip tip = pinch_default_tip((pinch_tip_type)type);
        dGeomID geom;
        for (int i = 0; i < 3; i++) tip.size[i] = 0.011 + 0.007 * i;
        if (type == PINCH_TIP_BOX || type == PINCH_TIP_CYLINDER) tip.skin = 0.002;
        assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_OK);
        expect_own_sides(geom, 0);
    }
}

static void meshes_and_convexes_have_theirs(void **state)
{
    (void)state;
    static const double points[] = {0, 0, 0, 0.3, 0, 0, 0, 0.2, 0, 0, 0, 0.1}, third = 0.57735026918962573;
    static const dTriIndex triangles[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    static const unsigned polygons[] = {3, 0, 2, 1, 3, 0, 1, 3, 3, 0, 3, 2, 3, 1, 2, 3};
    const double planes[] = {0, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, 0, third, third, third, 0.3 * third};
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, points, 3 * sizeof *points, 4, triangles, 12, 3 * sizeof *triangles);
    expect_own_sides(dCreateTriMesh(NULL, data, NULL, NULL, NULL), 1e-7); /* its points are floats in ODE */
    dGeomTriMeshDataDestroy(data);

    dGeomID convex = dCreateConvex(NULL, planes, 4, points, 4, polygons);
    double sides[3];
    assert_false(pinch_own_sides(convex, sides));
    assert_int_equal(pinch_tip_statistics().unknown_convex, 0);
    assert_int_equal(pinch_tip_know_convex(convex, &(pinch_convex){planes, 4, points, polygons, 4}), PINCH_OK);
    expect_own_sides(convex, 0);
}

static void others_have_none(void **state)
{
    (void)state;
    double sides[3];
    dGeomID plane = dCreatePlane(NULL, 0, 0, 1, 0), ray = dCreateRay(NULL, 1);
    assert_false(pinch_own_sides(plane, sides));
    assert_false(pinch_own_sides(ray, sides));
    dGeomDestroy(plane);
    dGeomDestroy(ray);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_have_their_own_sides),
        cmocka_unit_test(meshes_and_convexes_have_theirs),
        cmocka_unit_test(others_have_none),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
