/*
 * ODE's collider returns one end of a capsule that lies on a box, and the other is added. What a program has made of
 * the one before it handed it over counts for both.
 */
#include "support/cmocka_all.h"

#include "contacts/collider_points.h"

#include <math.h>
#include <ode/ode.h>
#include <string.h>

static const double RADIUS = 0.05, LENGTH = 0.3, DEPTH = 1e-3, EXACT = 1e-15;

/* A capsule along x on a box whose upper face is z = 0, or the box on the capsule. */
typedef struct pair {
    dGeomID geom[2];
    int class[2];
    double out;         /* of the box, as a factor of the normal */
    double found_depth; /* of the collider's contact */
    pinch_detected_point point[2];
} pair;

/* The end at +x lies `tilt` of the length deeper than the other, and the middle by DEPTH. */
static void pair_make(pair *p, bool capsule_first, double tilt)
{
    dMatrix3 rotation;
    dContactGeom found;
    dGeomID capsule = dCreateCapsule(NULL, RADIUS, LENGTH), box = dCreateBox(NULL, 1, 1, 0.2);
    memset(p, 0, sizeof *p);
    dRFromAxisAndAngle(rotation, 0, 1, 0, 0.5 * M_PI + asin(tilt));
    dGeomSetRotation(capsule, rotation);
    dGeomSetPosition(capsule, 0, 0, RADIUS - DEPTH);
    dGeomSetPosition(box, 0, 0, -0.1);
    p->geom[0] = capsule_first ? capsule : box;
    p->geom[1] = capsule_first ? box : capsule;
    for (int side = 0; side < 2; side++) p->class[side] = dGeomGetClass(p->geom[side]);
    p->out = capsule_first ? 1 : -1;
    assert_int_equal(dCollide(p->geom[0], p->geom[1], 1, &found, sizeof found), 1);
    memcpy(p->point->position, found.pos, sizeof p->point->position);
    memcpy(p->point->normal, found.normal, sizeof p->point->normal);
    p->found_depth = p->point->depth = found.depth;
}

static void pair_free(const pair *p)
{
    dGeomDestroy(p->geom[0]);
    dGeomDestroy(p->geom[1]);
}

static int add_end(pair *p)
{
    return pinch_add_capsule_end(p->geom, p->class, p->point, 1);
}

/* Checks that the point is the end of a line that tilts, on the side of `x`, deeper and lower than the collider has it
 * by that much. */
static void check_end(const pair *p, int index, double x, double tilt, double deeper, double lower)
{
    const pinch_detected_point *end = &p->point[index];
    double overlap = DEPTH + x * tilt * 0.5 * LENGTH;
    assert_close(end->position[0], x * 0.5 * LENGTH * sqrt(1 - tilt * tilt), EXACT);
    assert_close(end->position[1], 0, EXACT);
    assert_close(end->position[2], -0.5 * overlap - lower, EXACT);
    assert_close(end->normal[2], p->out, EXACT);
    assert_close(end->depth, overlap + deeper, EXACT);
}

static const double TILT = 1e-3; /* the ends are 0.15 mm deeper and less deep than the middle */

static void test_the_other_end_is_added(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        pair p;
        double tilt = k / 2 ? TILT : 0;
        pair_make(&p, k % 2, tilt);
        assert_int_equal(add_end(&p), 2);
        check_end(&p, 0, -1, tilt, 0, 0);
        check_end(&p, 1, 1, tilt, 0, 0);
        pair_free(&p);
    }
}

static void test_slop_and_margin_count_for_both_ends(void **state)
{
    (void)state;
    static const double change[] = {-1e-4, -8e-4, 1e-4, 5e-3, -1e-9};
    for (int k = 0; k < 20; k++) {
        pair p;
        double tilt = k / 10 ? TILT : 0, deeper = change[k % 5];
        pair_make(&p, k / 5 % 2, tilt);
        p.point->depth += deeper;
        assert_int_equal(add_end(&p), 2);
        check_end(&p, 0, -1, tilt, deeper, 0);
        check_end(&p, 1, 1, tilt, deeper, 0);
        pair_free(&p);
    }
}

/* The deeper end touches by more than the slop, and the other does not. */
static void test_an_end_within_the_slop_does_not_touch(void **state)
{
    (void)state;
    pair p;
    pair_make(&p, true, TILT);
    p.point->depth -= 9e-4;
    const pinch_detected_point handed = *p.point;
    assert_int_equal(add_end(&p), 1);
    assert_memory_equal(&handed, p.point, sizeof handed);
    pair_free(&p);
}

/* The deeper end is in the box, the other above it by less than the margin. */
static void test_an_end_within_the_margin_touches(void **state)
{
    (void)state;
    const double tilt = 1e-2, margin = 8e-4;
    pair p;
    pair_make(&p, true, tilt);
    assert_int_equal(add_end(&p), 1);
    p.point->depth += margin;
    assert_int_equal(add_end(&p), 2);
    check_end(&p, 0, -1, tilt, margin, 0);
    check_end(&p, 1, 1, tilt, margin, 0);
    pair_free(&p);
}

/* A program that hands over contacts within the slop as gaps hands over all that touch without it. */
static void test_both_ends_are_gaps(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        pair p;
        const double tilt = k < 2 ? TILT : 1e-2, slop = k ? 5e-3 : DEPTH + 0.5 * TILT * LENGTH;
        pair_make(&p, true, tilt);
        p.point->depth -= slop;
        if (k == 0) p.point->depth = 0;
        assert_int_equal(add_end(&p), k < 2 ? 2 : 1);
        if (k == 1) check_end(&p, 0, -1, tilt, -slop, 0);
        if (k == 1) check_end(&p, 1, 1, tilt, -slop, 0);
        pair_free(&p);
    }
}

/* A program that wants its contacts on the box moves them there. */
static void test_both_ends_lie_where_the_program_has_put_one(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        pair p;
        double lower = -0.5 * DEPTH;
        pair_make(&p, k, 0);
        p.point->position[2] -= lower;
        assert_int_equal(add_end(&p), 2);
        check_end(&p, 0, -1, 0, 0, lower);
        check_end(&p, 1, 1, 0, 0, lower);
        pair_free(&p);
    }
}

static void turn_normal(pair *p)
{
    p->point->normal[0] = 0.01 * p->out;
    p->point->normal[2] = sqrt(1 - 0.01 * 0.01) * p->out;
}

static void move_to_the_middle(pair *p)
{
    p->point->position[0] = 0;
}

static void move_beside(pair *p)
{
    p->point->position[1] += 0.1 * RADIUS;
}

static void move_away(pair *p)
{
    p->point->position[2] += 2 * RADIUS;
}

static void test_a_contact_of_the_program_s_own_stays(void **state)
{
    (void)state;
    void (*const makes[])(pair * p) = {turn_normal, move_to_the_middle, move_beside, move_away};
    for (int k = 0; k < 8; k++) {
        pair p;
        pair_make(&p, k / 4, 0);
        makes[k % 4](&p);
        const pinch_detected_point handed = *p.point;
        assert_int_equal(add_end(&p), 1);
        assert_memory_equal(&handed, p.point, sizeof handed);
        pair_free(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_other_end_is_added),
        cmocka_unit_test(test_slop_and_margin_count_for_both_ends),
        cmocka_unit_test(test_an_end_within_the_slop_does_not_touch),
        cmocka_unit_test(test_an_end_within_the_margin_touches),
        cmocka_unit_test(test_both_ends_are_gaps),
        cmocka_unit_test(test_both_ends_lie_where_the_program_has_put_one),
        cmocka_unit_test(test_a_contact_of_the_program_s_own_stays),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
