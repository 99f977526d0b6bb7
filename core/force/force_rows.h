/* Products with the rows of an element's blocks; those of a contact with friction on a free body have their loops
 * unrolled. */
#ifndef PINCH_FORCE_FORCE_ROWS_H
#define PINCH_FORCE_FORCE_ROWS_H

#include "kinematics/reduced_rows.h"

enum { PINCH_FORCE_CONTACT = 3, PINCH_FORCE_BODY = 6 };

/* w[rows] += G x */
static inline void pinch_force_rows_times(int rows, int size, const double *g, const double *x, double *w)
{
    if (rows == PINCH_FORCE_CONTACT && size == PINCH_FORCE_BODY) {
        for (int i = 0; i < PINCH_FORCE_CONTACT; i++, g += PINCH_FORCE_BODY)
            w[i] += (g[0] * x[0] + g[2] * x[2] + g[4] * x[4]) + (g[1] * x[1] + g[3] * x[3] + g[5] * x[5]);
        return;
    }
    if (size == 0) { /* what does not move adds zeros, as others that are at rest do */
        for (int i = 0; i < rows; i++) w[i] += 0.0;
        return;
    }
    for (int i = 0; i < rows; i++) {
        double sum = 0;
        for (int k = 0; k < size; k++) sum += g[i * size + k] * x[k];
        w[i] += sum;
    }
}

/* q[size] += G^T x */
static inline void pinch_force_rows_transposed_times(int rows, int size, const double *restrict g,
                                                     const double *restrict x, double *restrict q)
{
    if (rows == PINCH_FORCE_CONTACT && size == PINCH_FORCE_BODY) {
        double x0 = x[0], x1 = x[1], x2 = x[2];
        for (int k = 0; k < PINCH_FORCE_BODY; k++)
            q[k] += x0 * g[k] + x1 * g[PINCH_FORCE_BODY + k] + x2 * g[2 * PINCH_FORCE_BODY + k];
        return;
    }
    for (int i = 0; i < rows; i++) {
        if (x[i] == 0) continue;
        for (int k = 0; k < size; k++) q[k] += x[i] * g[i * size + k];
    }
}

#endif
