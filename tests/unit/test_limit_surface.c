/*
 * Compares the projection onto the limit surface with brute force: no point of the surface is closer, and the
 * derivatives are those of differences.
 */
#include "law/friction_cone.h"
#include "support/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

static double uniform(pinch_random *random, double low, double high)
{
    return low + (high - low) * pinch_random_uniform(random);
}

static double log_uniform(pinch_random *random, double low, double high)
{
    return exp(uniform(random, log(low), log(high)));
}

static double distance2(const double k[3], const double r[3], const double s[3])
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) sum += (r[i] - s[i]) * (r[i] - s[i]) / k[i];
    return sum;
}

/* Closest point of the surface in spherical angles: a grid, then ever finer grids about its best point. */
static double brute_force_distance2(const double axis[3], const double k[3], const double s[3])
{
    const double pi = 3.14159265358979323846;
    double best = INFINITY, center[2] = {0.5 * pi, 0.0}, width[2] = {0.5 * pi, pi};
    for (int level = 0; level < 24; level++) {
        double here[2] = {center[0], center[1]};
        for (int i = -20; i <= 20; i++)
            for (int j = -20; j <= 20; j++) {
                double theta = here[0] + width[0] * i / 20.0, phi = here[1] + width[1] * j / 20.0;
                double r[3] = {axis[0] * sin(theta) * cos(phi), axis[1] * sin(theta) * sin(phi), axis[2] * cos(theta)};
                double d = distance2(k, r, s);
                if (d < best) {
                    best = d;
                    center[0] = theta;
                    center[1] = phi;
                }
            }
        width[0] *= 0.45;
        width[1] *= 0.45;
    }
    return best;
}

static double outside(const double axis[3], const double r[3])
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) sum += (r[i] / axis[i]) * (r[i] / axis[i]);
    return sqrt(sum);
}

typedef struct random_case {
    double axis[3], k[3], s[3];
} random_case;

static random_case draw(pinch_random *random, bool soft)
{
    random_case c;
    for (int i = 0; i < 3; i++) {
        c.axis[i] = log_uniform(random, 1e-2, 1e2);
        c.k[i] = log_uniform(random, 1e-1, 1e4);
    }
    if (!soft) {
        c.axis[1] = c.axis[0];
        c.k[1] = c.k[0];
        c.axis[2] = 0.0;
    }
    for (int i = 0; i < 3; i++) c.s[i] = uniform(random, -3.0, 3.0) * (c.axis[i] > 0.0 ? c.axis[i] : 0.0);
    return c;
}

static void no_point_of_the_surface_is_closer(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 11);
    for (int trial = 0; trial < 300; trial++) {
        random_case c = draw(&random, true);
        for (int i = 0; i < 3; i++) { /* in a long thin valley the grid would get lost */
            double direction = c.s[i] / c.axis[i];
            c.axis[i] = log_uniform(&random, 0.3, 3.0);
            c.k[i] = log_uniform(&random, 1.0, 10.0);
            c.s[i] = direction * c.axis[i];
        }
        double r[3];
        bool stick = pinch_limit_surface_project(c.axis, c.k, c.s, r, NULL, NULL);
        assert_true(stick == (outside(c.axis, c.s) <= 1.0));
        if (stick) {
            assert_memory_equal(r, c.s, sizeof r);
            continue;
        }
        /* 1e-14: rounding of the sum of three squares */
        assert_true(fabs(outside(c.axis, r) - 1.0) <= 1e-14);
        double mine = distance2(c.k, r, c.s), brute = brute_force_distance2(c.axis, c.k, c.s);
        assert_true(mine <= brute * (1.0 + 1e-12));
        /* rounding where the surface is only just left */
        assert_true(brute <= mine * (1.0 + 1e-6) + 1e-14 * distance2(c.k, (double[3]){0}, c.s));
    }
}

static void the_closest_point_is_stationary_to_rounding(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 12);
    for (int trial = 0; trial < 20000; trial++) {
        random_case c = draw(&random, true);
        double pull = log_uniform(&random, 1.0, 1e12);
        for (int i = 0; i < 3; i++) c.s[i] *= pull;
        double r[3];
        if (pinch_limit_surface_project(c.axis, c.k, c.s, r, NULL, NULL)) continue;
        assert_true(fabs(outside(c.axis, r) - 1.0) <= 1e-14);
        /* (s_i - r_i)/k_i = lambda r_i/axis_i^2 with one lambda: compared through the largest component */
        double lambda[3];
        int p = 0;
        for (int i = 0; i < 3; i++) {
            lambda[i] = (c.s[i] - r[i]) / c.k[i] / (r[i] / (c.axis[i] * c.axis[i]));
            if (fabs(c.s[i] - r[i]) / fabs(c.s[i]) > fabs(c.s[p] - r[p]) / fabs(c.s[p])) p = i;
        }
        for (int i = 0; i < 3; i++) {
            double ri = c.s[i] / (1.0 + lambda[p] * c.k[i] / (c.axis[i] * c.axis[i]));
            /* cancellation in s - r where the surface is only just left */
            double noise = 1e-14 * fmax(1.0, fabs(c.s[p]) / fabs(c.s[p] - r[p]));
            assert_true(fabs(ri - r[i]) <= noise * fabs(r[i]));
        }
    }
}

static void derivatives_match_differences(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 13);
    for (int trial = 0; trial < 4000; trial++) {
        random_case c = draw(&random, trial % 2 == 0);
        double r[3], ds[9], dscale[3];
        bool stick = pinch_limit_surface_project(c.axis, c.k, c.s, r, ds, dscale);
        double level = 0.0;
        for (int i = 0; i < 3; i++)
            if (c.axis[i] > 0.0) level = hypot(level, c.s[i] / c.axis[i]);
        if (fabs(level - 1.0) < 1e-3) continue; /* differences would straddle the kink */
        for (int j = 0; j <= 3; j++) {
            double plus[3], minus[3], step = j < 3 ? 1e-6 * (c.axis[j] > 0.0 ? c.axis[j] : 1.0) : 1e-6;
            random_case up = c, down = c;
            for (int i = 0; i < 3; i++) {
                up.s[i] += i == j ? step : 0.0;
                down.s[i] -= i == j ? step : 0.0;
                up.axis[i] *= j == 3 ? 1.0 + step : 1.0;
                down.axis[i] *= j == 3 ? 1.0 - step : 1.0;
            }
            pinch_limit_surface_project(up.axis, up.k, up.s, plus, NULL, NULL);
            pinch_limit_surface_project(down.axis, down.k, down.s, minus, NULL, NULL);
            for (int i = 0; i < 3; i++) {
                double difference = (plus[i] - minus[i]) / (2.0 * step);
                double analytic = j < 3 ? ds[3 * i + j] : dscale[i];
                double unit = (c.axis[i] > 0.0 ? c.axis[i] : 1.0) / (j < 3 && c.axis[j] > 0.0 ? c.axis[j] : 1.0);
                assert_true(fabs(difference - analytic) <= 1e-6 * unit);
            }
        }
        if (stick) assert_true(dscale[0] == 0.0 && dscale[1] == 0.0 && dscale[2] == 0.0);
    }
}

static void the_disc_is_radial_and_the_ellipsoid_agrees_with_it(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 14);
    for (int trial = 0; trial < 2000; trial++) {
        random_case c = draw(&random, false);
        double r[3], ds[9], dscale[3], general[3], general_ds[9], general_dscale[3];
        bool stick = pinch_limit_surface_project(c.axis, c.k, c.s, r, ds, dscale);
        double length = hypot(c.s[0], c.s[1]);
        assert_true(stick == (length <= c.axis[0]));
        if (!stick) {
            assert_true(fabs(hypot(r[0], r[1]) - c.axis[0]) <= 1e-15 * c.axis[0] * 4.0);
            assert_true(fabs(r[0] * c.s[1] - r[1] * c.s[0]) <= 1e-15 * c.axis[0] * length * 4.0);
        }
        /* a torsional axis that bears no load makes it an ellipsoid with the same answer */
        double axis[3] = {c.axis[0], c.axis[1], 1.0};
        pinch_limit_surface_project(axis, c.k, c.s, general, general_ds, general_dscale);
        for (int i = 0; i < 2; i++) {
            assert_true(fabs(general[i] - r[i]) <= 1e-14 * c.axis[0]);
            assert_true(fabs(general_dscale[i] - dscale[i]) <= 1e-13 * c.axis[0]);
            for (int j = 0; j < 2; j++) assert_true(fabs(general_ds[3 * i + j] - ds[3 * i + j]) <= 1e-12);
        }
    }
}

static void limits_of_the_axes(void **state)
{
    (void)state;
    const double k[3] = {1.0, 1.0, 2.0}, s[3] = {3.0, 4.0, 5.0};
    double r[3], ds[9], dscale[3];
    const double none[3] = {0.0, 0.0, 0.0};
    assert_false(pinch_limit_surface_project(none, k, s, r, ds, dscale));
    for (int i = 0; i < 3; i++) assert_true(r[i] == 0.0 && dscale[i] == 0.0);
    for (int i = 0; i < 9; i++) assert_true(ds[i] == 0.0);
    const double at_rest[3] = {0.0, 0.0, 0.0};
    assert_true(pinch_limit_surface_project(none, k, at_rest, r, ds, dscale));

    const double rough[3] = {INFINITY, INFINITY, INFINITY};
    assert_true(pinch_limit_surface_project(rough, k, s, r, ds, dscale));
    assert_memory_equal(r, s, sizeof r);

    const double only_torsion[3] = {0.0, 0.0, 1.0};
    assert_false(pinch_limit_surface_project(only_torsion, k, s, r, ds, dscale));
    assert_true(r[0] == 0.0 && r[1] == 0.0 && fabs(r[2] - 1.0) <= 1e-15);

    const double tiny[3] = {1e-200, 1e-200, 1e-203};
    assert_false(pinch_limit_surface_project(tiny, k, s, r, ds, dscale));
    assert_true(fabs(outside(tiny, r) - 1.0) <= 1e-14);
    for (int i = 0; i < 9; i++) assert_true(isfinite(ds[i]));

    /* next to no sliding friction takes the limit off no torsion */
    const double flat[3] = {1e-200, 1e-200, 1.0};
    assert_false(pinch_limit_surface_project(flat, k, s, r, ds, dscale));
    assert_true(hypot(r[0], r[1]) <= 1e-200 && fabs(r[2] - 1.0) <= 1e-15);
    for (int i = 0; i < 9; i++) assert_true(isfinite(ds[i]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_point_of_the_surface_is_closer),
        cmocka_unit_test(the_closest_point_is_stationary_to_rounding),
        cmocka_unit_test(derivatives_match_differences),
        cmocka_unit_test(the_disc_is_radial_and_the_ellipsoid_agrees_with_it),
        cmocka_unit_test(limits_of_the_axes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
