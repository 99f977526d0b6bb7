/* A disc's rim crosses an edge. What the plugin says of it without a search must be what a search finds. */
#include "support/cmocka_all.h"

#include "collision/penetration/rim_line.h"
#include "support/draw.h"

static double overlap_at(double X, double Y, double r, double m, double angle)
{
    double s = sin(angle);
    return X * cos(angle) + Y * s + r * sqrt(m + (1 - m) * s * s);
}

/* An arc that is said not to have the minimum does not have it, and most that do not are known. */
static void test_off(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 61);
    long elsewhere = 0, known = 0;
    for (int n = 0; n < 200000; n++) {
        double r = draw_log_uniform(&random, 1e-2, 1e2),
               m = draw_chance(&random, 0.2) ? 1e-6 : draw_uniform(&random, 0, 1);
        double X = draw_uniform(&random, -2, 1) * r, Y = draw_uniform(&random, -2, 2) * r, c, s;
        double from = draw_uniform(&random, -3.2, 3.2), to = from + draw_uniform(&random, 1e-3, 3.1);
        const double forth[2][2] = {{cos(from), sin(from)}, {cos(to), sin(to)}};
        const double back[2][2] = {{cos(to), sin(to)}, {cos(from), sin(from)}};
        bool off = pinch_rim_least_is_off(X, Y, r, m, 1 - m, forth);
        assert_int_equal(off, pinch_rim_least_is_off(X, Y, r, m, 1 - m, back));
        if (!pinch_rim_least(X, Y, r, m, 1 - m, &c, &s)) continue;
        double turns = floor((from - atan2(s, c)) / 6.283185307179586) + 1;
        bool on_arc = atan2(s, c) + turns * 6.283185307179586 < to;
        if (off) assert_false(on_arc);
        elsewhere += !on_arc;
        known += off;
    }
    assert_in_range(known, elsewhere / 3, elsewhere);
}

/* It is a minimum, and in its half the only one. */
static void test_least(void **state)
{
    (void)state;
    enum { STEPS = 200 };
    pinch_random random;
    pinch_random_seed(&random, 62);
    for (int n = 0; n < 5000; n++) {
        double r = draw_log_uniform(&random, 1e-2, 1e2), m = draw_uniform(&random, 0.01, 0.99), c, s;
        double X = draw_uniform(&random, -2, 1) * r, Y = draw_uniform(&random, -2, 2) * r;
        bool found = pinch_rim_least(X, Y, r, m, 1 - m, &c, &s);
        double least = found ? overlap_at(X, Y, r, m, atan2(s, c)) : 0, step = 3.14159 / STEPS;
        for (int k = 1; k < STEPS; k++) {
            double a = -1.570795 + k * step, here = overlap_at(X, Y, r, m, a);
            bool lowest = here < overlap_at(X, Y, r, m, a - step) && here < overlap_at(X, Y, r, m, a + step);
            if (!lowest || k < 2 || k > STEPS - 2) continue;
            assert_true(found);
            assert_true(fabs(atan2(s, c) - a) < 1.01 * step);
            assert_true(least <= here + 1e-12 * r);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_off), cmocka_unit_test(test_least)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
