/* Success rates with their intervals, and how well a quantity predicts success. */
#include "report.h"

#include <math.h>
#include <stdlib.h>

void wilson_interval(size_t succeeded, size_t count, double *low, double *high)
{
    const double z = 1.959963984540054;
    double n = (double)count, p = count ? (double)succeeded / n : 0.5;
    *low = 0.0;
    *high = 1.0;
    if (count == 0) return;
    double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
    double half = z / (1 + z * z / n) * sqrt(p * (1 - p) / n + z * z / (4 * n * n));
    /* the ends are exact where all or none succeeded, and rounding would miss them */
    if (succeeded > 0) *low = fmax(0.0, middle - half);
    if (succeeded < count) *high = fmin(1.0, middle + half);
}

typedef struct scored {
    double value;
    bool success;
} scored;

static int by_value(const void *a, const void *b)
{
    double x = ((const scored *)a)->value, y = ((const scored *)b)->value;
    return (x > y) - (x < y);
}

/* Mann and Whitney (1947): the mean rank of the successes says it. Equal values share their ranks. */
double area_under_roc(const double *values, const bool *success, size_t count)
{
    scored *list = malloc((count + 1) * sizeof *list);
    size_t n = 0;
    double good = 0.0, ranks = 0.0;
    if (!list) return NAN;
    for (size_t i = 0; i < count; i++)
        if (!isnan(values[i])) list[n++] = (scored){values[i], success[i]};
    qsort(list, n, sizeof *list, by_value);
    for (size_t i = 0; i < n;) {
        size_t end = i, here = 0;
        for (; end < n && list[end].value == list[i].value; end++) here += list[end].success;
        ranks += (double)here * 0.5 * ((double)i + 1 + (double)end);
        good += (double)here;
        i = end;
    }
    free(list);
    double bad = (double)n - good;
    return good > 0 && bad > 0 ? (ranks - 0.5 * good * (good + 1)) / (good * bad) : NAN;
}

size_t area_interval(const double *values, const bool *success, size_t count, double area, double *low, double *high)
{
    double good = 0.0, bad = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (isnan(values[i])) continue;
        good += success[i];
        bad += !success[i];
    }
    /* how likely two successes are both above a failure, and a success above two failures, for exponential values */
    double both = area / (2 - area), one = 2 * area * area / (1 + area), square = area * area;
    double variance = (area * (1 - area) + (good - 1) * (both - square) + (bad - 1) * (one - square)) / (good * bad);
    double half = 1.959963984540054 * sqrt(fmax(variance, 0.0));
    *low = fmax(0.0, area - half);
    *high = fmin(1.0, area + half);
    return (size_t)(good + bad);
}
