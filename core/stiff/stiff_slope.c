/* How a contact's force follows its velocity in a Newton step. */
#include "stiff/stiff_slope.h"

#include "stiff/stiff_rows.h"
#include "support/lu.h"

#include <math.h>

/*
 * D = A^-1 J rho of a contact with friction. The normal force depends on nothing else, so J is
 *
 *     [ j 0 ]                    [ D_n  0   ]
 *     [ c T ]    and        D =  [ D_tn D_t ]    with B = I - T (I - rho C)_t:
 *
 *     D_n = j rho_n / (1 - j (1 - rho C)_n),  D_tn = B^-1 c (rho_n + (1 - rho C)_n D_n),  D_t = B^-1 T rho_t
 */
static bool slope_of_friction(pinch_stiff_element *e, const double *derivative)
{
    double stays[3], *d = e->slope;
    for (int i = 0; i < 3; i++) stays[i] = 1 - e->rho[i] * e->compliance[i];
    d[0] = derivative[0] * e->rho[0] / (1 - derivative[0] * stays[0]);
    d[1] = d[2] = 0;
    const double *t = derivative;
    double b00 = 1 - t[4] * stays[1], b01 = -t[5] * stays[2], b10 = -t[7] * stays[1], b11 = 1 - t[8] * stays[2];
    double over = 1 / (b00 * b11 - b01 * b10), by_normal = e->rho[0] + stays[0] * d[0];
    const double right[3][2] = {{t[3] * by_normal, t[6] * by_normal},
                                {t[4] * e->rho[1], t[7] * e->rho[1]},
                                {t[5] * e->rho[2], t[8] * e->rho[2]}};
    for (int k = 0; k < 3; k++) {
        d[3 + k] = over * (b11 * right[k][0] - b01 * right[k][1]);
        d[6 + k] = over * (b00 * right[k][1] - b10 * right[k][0]);
    }
    return isfinite(over);
}

static bool slope_of_any(pinch_stiff_element *e, const double *derivative)
{
    enum { N = PINCH_STIFF_ROWS };
    double a[N * N], column[N], scratch[N];
    int pivot[N], rows = e->law.rows;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            a[i * rows + j] = (i == j) - derivative[i * rows + j] * (1 - e->rho[j] * e->compliance[j]);
    if (!pinch_lu_factor(rows, a, pivot, scratch)) return false;
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < rows; i++) column[i] = derivative[i * rows + j] * e->rho[j];
        pinch_lu_solve(rows, a, pivot, column, column);
        for (int i = 0; i < rows; i++) e->slope[i * rows + j] = column[i];
    }
    return true;
}

/* The shift A^-1 F follows from A^-1 = I + D rho^-1 (I - rho C). */
bool pinch_stiff_eliminate(pinch_stiff_element *e)
{
    enum { N = PINCH_STIFF_ROWS };
    double derivative[N * N], p[N], weighted[N];
    int rows = e->law.rows;
    (void)pinch_stiff_project(&e->law, e->rho, e->z, p, derivative);
    if (!(rows == PINCH_STIFF_CONTACT ? slope_of_friction(e, derivative) : slope_of_any(e, derivative))) return false;
    for (int j = 0; j < rows; j++) weighted[j] = (1 - e->rho[j] * e->compliance[j]) / e->rho[j] * e->f[j];
    e->gives = false;
    for (int i = 0; i < rows; i++) {
        e->shift[i] = e->f[i];
        for (int j = 0; j < rows; j++) {
            e->shift[i] += e->slope[i * rows + j] * weighted[j];
            e->gives = e->gives || e->slope[i * rows + j] != 0;
        }
    }
    return true;
}
