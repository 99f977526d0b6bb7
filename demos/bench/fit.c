#include "fit.h"

#include <math.h>

double fit_exponent(const double *size, const double *cost, int count)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < count; i++) {
        if (size[i] < FIT_FROM) continue;
        double a = log(size[i]), b = log(cost[i]);
        n++, x += a, y += b, xx += a * a, xy += a * b;
    }
    return n < 2 ? NAN : (n * xy - x * y) / (n * xx - x * x);
}
