/* The yardstick of demos/bench/projection: what a projection onto one dense row of n entries costs at least. The
 * residual is a dot product, the update adds a multiple of the row, and F_i and V_i take two square roots. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROWS = 1000, MOST = 1024 };

__attribute__((noinline)) static double dense_row(const double *restrict row, double *restrict x, int n)
{
    /* Without partial sums the compiler would have to add one term after the other. */
    enum { LANES = 4 };
    double sum[LANES] = {0.0};
    int j = 0;
    for (; j + LANES <= n; j += LANES)
        for (int l = 0; l < LANES; l++) sum[l] += row[j + l] * x[j + l];
    for (; j < n; j++) sum[0] += row[j] * x[j];
    double dot = (sum[0] + sum[2]) + (sum[1] + sum[3]), step = sqrt(dot * dot + 1.0) - sqrt(dot * dot + 2.0);
    for (j = 0; j < n; j++) x[j] += step * row[j];
    return dot;
}

int main(int argc, char **argv)
{
    static double row[MOST], x[MOST];
    int n = argc == 2 ? atoi(argv[1]) : 0;
    if (n < 1 || n > MOST) {
        fprintf(stderr, "usage: dense_row ENTRIES (1 to %d)\n", MOST);
        return 2;
    }
    double sum = 0.0;
    for (int j = 0; j < n; j++) row[j] = sin(j + 1.0) / n;
    for (int i = 0; i < ROWS; i++) sum += dense_row(row, x, n);
    printf("%g\n", sum);
    return 0;
}
