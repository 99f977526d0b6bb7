#ifndef PINCH_BENCH_FIT_H
#define PINCH_BENCH_FIT_H

enum { FIT_FROM = 100 };

/* The slope of log cost against log size by least squares, over the sizes from FIT_FROM on; NAN where these are less
 * than two, or a cost is not there. */
double fit_exponent(const double *size, const double *cost, int count);

#endif
