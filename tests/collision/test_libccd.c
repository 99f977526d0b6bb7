/*
 * libccd, an independent library, looks at the same pairs by the portal method (MPR). The two must agree on whether
 * bodies touch, and the depth, which is the least overlap over all directions, must not exceed the overlap along the
 * direction that libccd finds.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <ccd/ccd.h>
#include <math.h>

enum { TRIALS = 3000 };
static const double CLOSE = 1e-4; /* of the bodies' size: nearer to touching than this the two may differ */

/* The support point is the gradient of the support function, here by differences. */
static void support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    static const double STEP = 1e-6;
    const test_tip *t = object;
    const double length = sqrt(ccdVec3Len2(direction));
    for (int i = 0; i < 3; i++) {
        double side[2];
        for (int k = 0; k < 2; k++) {
            double d[3], size = 0;
            for (int j = 0; j < 3; j++) d[j] = direction->v[j] / length + (i == j ? (k ? STEP : -STEP) : 0);
            for (int j = 0; j < 3; j++) size += d[j] * d[j];
            size = sqrt(size);
            for (int j = 0; j < 3; j++) d[j] /= size;
            side[k] = size * test_tip_reach(t, d);
        }
        point->v[i] = (side[1] - side[0]) / (2 * STEP);
    }
}

static void centre(const void *object, ccd_vec3_t *point)
{
    const test_tip *t = object;
    for (int i = 0; i < 3; i++) point->v[i] = t->position[i];
}

/* Returns whether libccd finds that the two overlap, and the direction in which a has to go. */
static bool ask_libccd(const test_tip *a, const test_tip *b, double *depth, double n[3])
{
    ccd_t ccd;
    ccd_vec3_t direction, position;
    ccd_real_t found;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = support;
    ccd.center1 = ccd.center2 = centre;
    ccd.max_iterations = 200;
    ccd.mpr_tolerance = 1e-7;
    if (ccdMPRPenetration(a, b, &ccd, &found, &direction, &position) != 0) return false;
    double length = sqrt(ccdVec3Len2(&direction));
    *depth = found;
    for (int i = 0; i < 3; i++) n[i] = length > 0 ? -direction.v[i] / length : 0;
    return length > 0;
}

/* Of every two kinds of tips but superellipsoids, whose corners are too sharp for differences. */
static void test_libccd_agrees(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 17);
    long touching = 0, apart = 0, wrong = 0, libccd_wrong = 0;
    double least_gain = INFINITY;
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip tip[2];
        for (int k = 0; k < 2; k++) {
            pinch_tip_type type;
            do type = (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT);
            while (type == PINCH_TIP_SUPERELLIPSOID);
            test_tip_make(&random, type, &tip[k]);
        }
        test_tips_touch(&random, &tip[0], &tip[1], 0.3, 1.1);
        dContactGeom c[TEST_TIP_CONTACTS];
        double size = tip[0].size + tip[1].size, depth = 0, theirs = 0, n[3];
        int count = test_tips_collide(&tip[0], &tip[1], c);
        for (int k = 0; k < count; k++) depth = fmax(depth, c[k].depth);
        bool overlap = ask_libccd(&tip[0], &tip[1], &theirs, n);
        if (count > 0) touching++;
        if (!overlap) apart++;
        bool agree = overlap ? count > 0 || theirs < CLOSE * size : depth < CLOSE * size;
        if (!agree && overlap && test_least_overlap(&tip[0], &tip[1], 2000, 10, 0, n) < 0) {
            libccd_wrong++; /* there is a direction that separates them */
            overlap = false;
            agree = true;
        }
        if (overlap && count > 0) {
            double gain = test_overlap(&tip[0], &tip[1], n) - depth;
            least_gain = fmin(least_gain, gain / size);
            agree = agree && gain >= -1e-9 * size;
        }
        if (!agree) {
            wrong++;
            print_error("trial %d, tips %d and %d: depth %g, libccd %s %g\n", trial, tip[0].tip.type, tip[1].tip.type,
                        depth, overlap ? "overlap" : "apart", theirs);
        }
        for (int k = 0; k < 2; k++) test_tip_free(&tip[k]);
    }
    print_message("%ld touch, %ld apart by libccd, which was wrong %ld times; least gain over its direction %g\n",
                  touching, apart, libccd_wrong, least_gain);
    assert_int_equal(wrong, 0);
    assert_true(libccd_wrong <= TRIALS / 100);
    assert_true(touching > TRIALS / 4 && apart > TRIALS / 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_libccd_agrees)};
    dInitODE();
    int failed = cmocka_run_group_tests_name("libccd", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
