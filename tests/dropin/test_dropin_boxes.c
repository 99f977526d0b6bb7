/* Boxes that ODE's collider loses by rounding have their contacts under the drop-in layer, but where the program has a
 * collider of its own for boxes. */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode_dropin.h>

enum { ROOM = 8, TRIALS = 2000 };

/* Returns how many of the pads that are pressed onto a cube, each turned another way and tilted about an edge, have
 * contacts. */
static int count_touching(void)
{
    pinch_random random;
    dGeomID cube = dCreateBox(NULL, 0.1, 0.1, 0.1), pad = dCreateBox(NULL, 0.01, 0.02, 0.02);
    int touching = 0;
    pinch_random_seed(&random, 51);
    for (int trial = 0; trial < TRIALS; trial++) {
        dQuaternion turn, tilted, both;
        dContactGeom found[ROOM];
        for (int i = 0; i < 4; i++) turn[i] = draw_uniform(&random, -1, 1);
        dNormalize4(turn);
        dQFromAxisAndAngle(tilted, 0, 1, 0, draw_uniform(&random, 0, 0.1));
        dQMultiply0(both, turn, tilted);
        dGeomSetQuaternion(cube, turn);
        dGeomSetQuaternion(pad, both);
        const dReal *R = dGeomGetRotation(cube);
        dGeomSetPosition(pad, -0.0545 * R[0], -0.0545 * R[4], -0.0545 * R[8]);
        touching += dCollide(cube, pad, ROOM, found, sizeof found[0]) > 1;
    }
    dGeomDestroy(cube);
    dGeomDestroy(pad);
    return touching;
}

static int touch_nothing(dGeomID a, dGeomID b, int flags, dContactGeom *found, int skip)
{
    (void)a, (void)b, (void)flags, (void)found, (void)skip;
    return 0;
}

static void boxes_are_found(void **state)
{
    (void)state;
    assert_int_equal(count_touching(), TRIALS);
}

static void a_programs_own_collider_counts(void **state)
{
    (void)state;
    dSetColliderOverride(dBoxClass, dBoxClass, touch_nothing);
    assert_int_equal(count_touching(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_found),
        cmocka_unit_test(a_programs_own_collider_counts),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
