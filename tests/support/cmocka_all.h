#ifndef PINCH_TEST_CMOCKA_ALL_H
#define PINCH_TEST_CMOCKA_ALL_H

/* cmocka.h wants these before it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

/* cmocka compares floats only, and rounds doubles to floats first */
#define assert_close(actual, expected, tolerance)                                                                      \
    test_assert_close((actual), (expected), (tolerance), __FILE__, __LINE__)

static inline void test_assert_close(double actual, double expected, double tolerance, const char *file, int line)
{
    if (fabs(actual - expected) <= tolerance) return;
    print_error("%.17g is not %.17g to %g\n", actual, expected, tolerance);
    _fail(file, line);
}

#endif
