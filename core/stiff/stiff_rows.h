/* Products with the rows of an element's blocks; those of a contact with friction on a free body have their loops
 * unrolled. */
#ifndef PINCH_STIFF_STIFF_ROWS_H
#define PINCH_STIFF_STIFF_ROWS_H

#include "problem/reduced_rows.h"

enum { PINCH_STIFF_CONTACT = 3, PINCH_STIFF_BODY = 6 };

/* The square of one row's length: of a contact, W_ii in (m/s)/(N s) or (rad/s)/(N m s). */
static inline double pinch_stiff_row_norm2(const pinch_element_block block[2], int row)
{
    double sum = 0;
    for (int b = 0; b < 2; b++)
        for (int k = 0; k < block[b].size; k++) {
            double g = block[b].g[row * block[b].size + k];
            sum += g * g;
        }
    return sum;
}

/* w[rows] += G x */
static inline void pinch_stiff_rows_times(int rows, int size, const double *g, const double *x, double *w)
{
    if (rows == PINCH_STIFF_CONTACT && size == PINCH_STIFF_BODY) {
        for (int i = 0; i < PINCH_STIFF_CONTACT; i++, g += PINCH_STIFF_BODY)
            w[i] += (g[0] * x[0] + g[2] * x[2] + g[4] * x[4]) + (g[1] * x[1] + g[3] * x[3] + g[5] * x[5]);
        return;
    }
    for (int i = 0; i < rows; i++) {
        double sum = 0;
        for (int k = 0; k < size; k++) sum += g[i * size + k] * x[k];
        w[i] += sum;
    }
}

/* q[size] += G^T x */
static inline void pinch_stiff_rows_transposed_times(int rows, int size, const double *restrict g,
                                                     const double *restrict x, double *restrict q)
{
    if (rows == PINCH_STIFF_CONTACT && size == PINCH_STIFF_BODY) {
        double x0 = x[0], x1 = x[1], x2 = x[2];
        for (int k = 0; k < PINCH_STIFF_BODY; k++)
            q[k] += x0 * g[k] + x1 * g[PINCH_STIFF_BODY + k] + x2 * g[2 * PINCH_STIFF_BODY + k];
        return;
    }
    for (int i = 0; i < rows; i++) {
        if (x[i] == 0) continue;
        for (int k = 0; k < size; k++) q[k] += x[i] * g[i * size + k];
    }
}

#endif
