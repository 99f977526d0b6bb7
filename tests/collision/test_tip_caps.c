/* Two discs lie over each other, and the contact points must be those of their common area. */
#include "support/cmocka_all.h"

#include "support/tips.h"

enum { ROOM = 64 };

/* A cylinder upright on another one, `aside` of its axis. */
static int stand(const test_tip *lower, test_tip *upper, const double aside[2], double depth, dContactGeom c[ROOM])
{
    const double at[3] = {aside[0], aside[1], 0.5 * lower->tip.size[1] + 0.5 * upper->tip.size[1] - depth};
    test_tip_place(upper, at, TEST_TIP_UPRIGHT);
    return dCollide(upper->geom, lower->geom, ROOM, c, sizeof c[0]);
}

/* Of two discs whose centres are apart by d. */
static double lens(double a, double b, double d)
{
    if (d <= fabs(a - b)) return M_PI * fmin(a, b) * fmin(a, b);
    if (d >= a + b) return 0;
    double x = (d * d + a * a - b * b) / (2 * d), y = sqrt(a * a - x * x);
    return a * a * atan2(y, x) + b * b * atan2(y, d - x) - d * y;
}

static int by_angle(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (p[2] > q[2]) - (p[2] < q[2]);
}

/* Of the convex polygon that the points are the corners of. */
static double area_of(const dContactGeom *c, int count)
{
    double p[ROOM][3], middle[2] = {0, 0}, area = 0;
    for (int k = 0; k < count; k++)
        for (int i = 0; i < 2; i++) middle[i] += c[k].pos[i] / count;
    for (int k = 0; k < count; k++) {
        p[k][0] = c[k].pos[0] - middle[0];
        p[k][1] = c[k].pos[1] - middle[1];
        p[k][2] = atan2(p[k][1], p[k][0]);
    }
    qsort(p, (size_t)count, sizeof p[0], by_angle);
    for (int k = 0; k < count; k++) {
        const double *a = p[k], *b = p[(k + 1) % count];
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    return area;
}

/* How far the point of one set is from the nearest of another, at most. */
static double farthest_from(const dContactGeom *a, int na, const dContactGeom *b, int nb)
{
    double most = 0;
    for (int i = 0; i < na; i++) {
        double least = INFINITY;
        for (int j = 0; j < nb; j++) least = fmin(least, hypot(a[i].pos[0] - b[j].pos[0], a[i].pos[1] - b[j].pos[1]));
        most = fmax(most, least);
    }
    return most;
}

/* They lie over both caps, take up most of where the discs are over each other, and go with the bodies. */
static void test_over_the_border(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 71);
    for (int n = 0; n < 2000; n++) {
        double a = draw_log_uniform(&random, 0.03, 0.3), b = 0.1, direction = draw_uniform(&random, 0, 2 * M_PI);
        double apart = draw_uniform(&random, 0, 0.95) * (a + b), depth = 1e-4 * b;
        double aside[2] = {apart * cos(direction), apart * sin(direction)}, step[2] = {aside[0] + 1e-8, aside[1]};
        dContactGeom c[ROOM], moved[ROOM];
        test_tip lower = test_tip_of(PINCH_TIP_CYLINDER, b, 0.2, 0, 0),
                 upper = test_tip_of(PINCH_TIP_CYLINDER, a, 0.3, 0, 0);
        test_tip_place(&lower, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
        int count = stand(&lower, &upper, aside, depth, c), after = stand(&lower, &upper, step, depth, moved);
        double overlap = lens(a, b, apart);
        for (int k = 0; k < count; k++) {
            const double *x = c[k].pos;
            assert_true(hypot(x[0], x[1]) <= b * (1 + 1e-6));
            assert_true(hypot(x[0] - aside[0], x[1] - aside[1]) <= a * (1 + 1e-6));
            assert_close(c[k].depth, depth, 1e-9 * b);
            assert_close(c[k].normal[2], 1, 1e-12);
        }
        assert_true(area_of(c, count) <= overlap * (1 + 1e-6));
        assert_true(area_of(c, count) >= 0.7 * overlap - 1e-9);
        assert_true(farthest_from(c, count, moved, after) < 1e-3 * b);
        assert_true(farthest_from(moved, after, c, count) < 1e-3 * b);
        test_tip_free(&lower);
        test_tip_free(&upper);
    }
}

/* A line along a cap ends where it crosses the rim. */
static void test_line_on_cap(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 72);
    for (int n = 0; n < 500; n++) {
        test_tip lower = test_tip_of(PINCH_TIP_CYLINDER, 0.1, 0.2, 0, 0),
                 line = test_tip_of(PINCH_TIP_CAPSULE, 0.02, 0.5, 0, 0);
        double y = draw_uniform(&random, -0.08, 0.08), half = sqrt(0.01 - y * y);
        const double R[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0}; /* its axis along x */
        dContactGeom c[ROOM];
        test_tip_place(&lower, (const double[3]){0, 0, 0}, TEST_TIP_UPRIGHT);
        test_tip_place(&line, (const double[3]){draw_uniform(&random, -0.1, 0.1), y, 0.12 - 1e-4}, R);
        assert_int_equal(dCollide(line.geom, lower.geom, ROOM, c, sizeof c[0]), 2);
        assert_close(fabs(c[0].pos[0]), half, 1e-8);
        assert_close(c[0].pos[0] + c[1].pos[0], 0, 1e-8);
        for (int k = 0; k < 2; k++) assert_close(c[k].pos[1], y, 1e-12);
        test_tip_free(&lower);
        test_tip_free(&line);
    }
}

/* A corner that alone is pressed into a face is the one contact, as deep as the pair. */
static void test_lone_corner(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 73);
    test_tip ground = test_tip_of(PINCH_TIP_BOX, 1, 1, 0.4, 0);
    test_tip_place(&ground, (const double[3]){0, 0, -0.2}, TEST_TIP_UPRIGHT);
    for (int n = 0; n < 2000; n++) {
        static const pinch_tip_type TYPES[] = {PINCH_TIP_BOX, PINCH_TIP_CONVEX, PINCH_TIP_CYLINDER};
        const double down[3] = {0, 0, -1};
        double R[9], at[3] = {draw_uniform(&random, -0.1, 0.1), draw_uniform(&random, -0.1, 0.1), 0};
        dContactGeom c[ROOM];
        test_tip tip;
        test_tip_make(&random, TYPES[n % 3], &tip);
        draw_frame(&random, R);
        test_tip_place(&tip, at, R);
        double depth = 1e-7 * tip.size;
        at[2] = test_tip_reach(&tip, down) - depth;
        test_tip_place(&tip, at, R);
        if (tip.size < 0.3) {
            assert_int_equal(dCollide(tip.geom, ground.geom, ROOM, c, sizeof c[0]), 1);
            assert_close(c[0].depth, depth, 1e-12);
            assert_close(c[0].pos[2], -0.5 * depth, 1e-12);
        }
        test_tip_free(&tip);
    }
    test_tip_free(&ground);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_over_the_border), cmocka_unit_test(test_line_on_cap),
                                       cmocka_unit_test(test_lone_corner)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    pinch_close_tips();
    dCloseODE();
    return failed;
}
