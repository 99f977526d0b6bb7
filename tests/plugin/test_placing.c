/* Contacts must lie on the surface of the side that does not give way, wherever the collider puts them. */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/fingertip.h>
#include <pinch/ode.h>
#include <string.h>

enum { SPHERE, CAPSULE, CYLINDER, BOX, PLANE, SHAPES, CONTACTS = 8, TRIALS = 40 };

static const double PRESSED = 1e-4; /* m, of shapes of some cm */

/* ODE's points for cylinders on anything but balls and planes are off by as much as they are deep. */
static int collide(dGeomID a, dGeomID b, dContactGeom *c, int skip)
{
    int class[2] = {dGeomGetClass(a), dGeomGetClass(b)};
    for (int k = 0; k < 2; k++)
        if (class[k] == dCylinderClass && class[!k] != dSphereClass && class[!k] != dPlaneClass)
            return pinch_tip_collide(a, b, CONTACTS, c, skip);
    return dCollide(a, b, CONTACTS, c, skip);
}

static dGeomID make(pinch_random *random, int shape)
{
    double r = draw_uniform(random, 0.01, 0.03), l = draw_uniform(random, 0.02, 0.05);
    return shape == SPHERE     ? dCreateSphere(NULL, r)
           : shape == CAPSULE  ? dCreateCapsule(NULL, r, l)
           : shape == CYLINDER ? dCreateCylinder(NULL, r, l)
           : shape == BOX      ? dCreateBox(NULL, 2 * r, l, draw_uniform(random, 0.02, 0.06))
                               : dCreatePlane(NULL, 0, 0, 1, 0);
}

static void turn(pinch_random *random, dGeomID geom)
{
    double R[9];
    draw_frame(random, R);
    dMatrix3 rotation = {R[0], R[1], R[2], 0, R[3], R[4], R[5], 0, R[6], R[7], R[8], 0};
    dGeomSetRotation(geom, rotation);
}

/* The upper geom, on the body, above the lower one, from where they touch on by PRESSED; false: they never do. */
static bool press(pinch_random *random, dBodyID body, dGeomID upper, dGeomID lower, bool level)
{
    dContactGeom c[CONTACTS];
    dGeomSetBody(upper, body);
    if (!level) turn(random, upper);
    if (dGeomGetClass(lower) != dPlaneClass && !level) turn(random, lower);
    double x = draw_uniform(random, -0.005, 0.005), low = 0, high = 0.2;
    while (high - low > 1e-9) {
        double z = 0.5 * (low + high);
        dBodySetPosition(body, x, 0, z);
        *(collide(upper, lower, c, sizeof c[0]) > 0 ? &low : &high) = z;
    }
    dBodySetPosition(body, x, 0, low - PRESSED);
    return low > 0;
}

static double distance_to(dGeomID geom, const double *x)
{
    double distance, nearest[3], normal[3];
    assert_int_equal(pinch_tip_closest_point(geom, x, &distance, nearest, normal), PINCH_OK);
    return distance;
}

/* upper_part: how much of the compliance is the upper's. */
static void check(pinch_ode *plugin, dBodyID body, dGeomID upper, dGeomID lower, double upper_part, long *checked)
{
    dContact c[CONTACTS];
    memset(c, 0, sizeof c);
    int count = collide(upper, lower, &c[0].geom, sizeof c[0]), points;
    assert_true(count > 0);
    for (int k = 0; k < count; k++) assert_int_equal(pinch_ode_add_contact(plugin, &c[k], body, NULL), PINCH_OK);
    const pinch_ode_contact *list;
    assert_int_equal(pinch_ode_solve(plugin, 1e-3), PINCH_OK);
    assert_int_equal(pinch_ode_contacts(plugin, &list, &points), PINCH_OK);
    assert_true(points > 0);
    int deepest = 0;
    for (int k = 1; k < points; k++) deepest = list[k].depth > list[deepest].depth ? k : deepest;
    const pinch_ode_contact *p = &list[deepest];
    double from_upper = -distance_to(upper, p->position), from_lower = -distance_to(lower, p->position);
    if (upper_part == 1) assert_close(from_lower, 0, 1e-3 * p->depth);
    if (upper_part == 0) assert_close(from_upper, 0, 1e-3 * p->depth);
    /* beside an edge the way out along the normal is longer than the nearest one */
    if (fabs(from_upper + from_lower - p->depth) < 0.01 * p->depth) {
        assert_close(from_upper, upper_part * p->depth, 0.02 * p->depth);
        assert_close(from_lower, (1 - upper_part) * p->depth, 0.02 * p->depth);
        ++*checked;
    }
    assert_int_equal(pinch_ode_advance(plugin, 1e-3), PINCH_OK);
}

static void test_on_the_rigid_side(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 12);
    for (int i = 0; i < BOX + 1; i++)
        for (int j = 0; j < SHAPES; j++) {
            if (i == BOX && j >= BOX) continue; /* flat faces: as found */
            long checked = 0;
            for (int trial = 0; trial < TRIALS; trial++) {
                dWorldID world = dWorldCreate();
                dBodyID body = dBodyCreate(world);
                dGeomID upper = make(&random, i), lower = make(&random, j);
                pinch_ode *plugin;
                pinch_ode_settings settings = pinch_ode_default_settings();
                pinch_material m = pinch_default_material(), twice = m;
                assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_OK);
                if (press(&random, body, upper, lower, trial % 4 == 0 && i + j != 2 * CYLINDER)) {
                    int which = trial % 3; /* of the two gives: the upper, the lower, both, the lower half as much */
                    twice.stiffness[0] *= 2;
                    if (which != 1) assert_int_equal(pinch_ode_set_material(plugin, upper, &m), PINCH_OK);
                    if (which != 0) assert_int_equal(pinch_ode_set_material(plugin, lower, &twice), PINCH_OK);
                    check(plugin, body, upper, lower, which == 0 ? 1 : which == 1 ? 0 : 2.0 / 3, &checked);
                }
                pinch_ode_destroy(plugin);
                dGeomDestroy(upper);
                dGeomDestroy(lower);
                dWorldDestroy(world);
            }
            assert_true(checked >= 5);
        }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_on_the_rigid_side)};
    int failed = cmocka_run_group_tests_name("placing", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
