/* Sums and products of double-double numbers are those of integers of 128 bits, in which they can be taken exactly. */
#include "support/cmocka_all.h"

#include "support/double_double.h"
#include "support/draw.h"

#include <math.h>

__extension__ typedef __int128 whole;

enum { TRIALS = 200000 };

/* up to 2^53 in size, of any length */
static double draw_whole(pinch_random *random)
{
    uint64_t bits = pinch_random_next(random);
    double size = (double)(bits >> (11 + draw_index(random, 52)));
    return draw_chance(random, 0.5) ? size : -size;
}

/* Parts that are whole numbers below 2^127 */
static whole value(pinch_double_double a)
{
    assert_true(fabs(a.low) <= 0.5 * (nextafter(fabs(a.high), INFINITY) - fabs(a.high)));
    return (whole)a.high + (whole)a.low;
}

static void test_sums_and_products_are_exact(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 1);
    for (int i = 0; i < TRIALS; i++) {
        double a = draw_whole(&random), b = draw_whole(&random), shift = ldexp(1, draw_index(&random, 70));
        assert_true(value(pinch_dd_product(a, b)) == (whole)a * (whole)b);
        assert_true(value(pinch_dd_sum(a * shift, b)) == (whole)(a * shift) + (whole)b);
    }
}

/* Sums of up to 60 products whose large ones cancel: all 106 digits are there, and nothing of them is lost. */
static void test_sums_that_cancel(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 2);
    for (int i = 0; i < TRIALS / 50; i++) {
        pinch_double_double sum = {0, 0};
        double a[30], b[30];
        whole exact = 0;
        for (int k = 0; k < 30; k++) {
            a[k] = floor(draw_whole(&random) / 16); /* so that no sum needs more than 106 digits */
            b[k] = floor(draw_whole(&random) / 16);
            sum = pinch_dd_add(sum, pinch_dd_product(a[k], b[k]));
            exact += (whole)a[k] * (whole)b[k];
            assert_true(value(sum) == exact);
        }
        for (int k = 0; k < 30; k++) sum = pinch_dd_add(sum, pinch_dd_times(-a[k], (pinch_double_double){b[k], 0}));
        assert_true(sum.high == 0 && sum.low == 0);
    }
}

/* |a (b.high + b.low) - result| <= 2^-103 |result|, in whole numbers */
static void test_products_with_both_parts(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int i = 0; i < TRIALS; i++) {
        double factor = floor(draw_whole(&random) / 4294967296.0); /* 21 bits, so that 127 hold the product */
        double low = draw_whole(&random);
        pinch_double_double b = pinch_dd_sum(draw_whole(&random) * 4503599627370496.0, low);
        whole exact = (whole)factor * value(b), off = value(pinch_dd_times(factor, b)) - exact;
        if (off < 0) off = -off;
        if (exact < 0) exact = -exact;
        assert_true(off <= exact >> 103);
    }
}

static void test_infinities_stay(void **state)
{
    (void)state;
    pinch_double_double most = pinch_dd_sum(1.7e308, 1.7e308), product = pinch_dd_product(1e200, 1e200);
    assert_true(isinf(most.high) && most.low == 0);
    assert_true(isinf(product.high) && product.low == 0);
    pinch_double_double sum = pinch_dd_add(most, (pinch_double_double){-1, 0});
    assert_true(isinf(sum.high) && sum.low == 0);
    product = pinch_dd_product(1e305, 3); /* too large to be split */
    assert_true(product.high == 3e305 && product.low == 0);
    assert_true(isnan(pinch_dd_add(most, pinch_dd_sum(-1.7e308, -1.7e308)).high));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums_and_products_are_exact),
        cmocka_unit_test(test_sums_that_cancel),
        cmocka_unit_test(test_products_with_both_parts),
        cmocka_unit_test(test_infinities_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
