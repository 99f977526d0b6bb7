/* Eliminates a contact from a Newton step, equation (26) of core/README.md: its conductance D says how its force
 * follows its velocity. */
#include "force/force_system.h"

#include "force/force_rows.h"
#include "support/lu.h"

#include <math.h>

/*
 * Finds D = A^-1 J rho of a contact with friction. The normal force depends on no other row, so J is
 *
 *     [ j 0 ]                    [ D_n  0   ]
 *     [ c T ]    and        D =  [ D_tn D_t ]    with B = I - T (I - rho C)_t:
 *
 *     D_n = j rho_n / (1 - j (1 - rho C)_n),  D_tn = B^-1 c (rho_n + (1 - rho C)_n D_n),  D_t = B^-1 T rho_t
 */
static bool conductance_of_friction(const pinch_force_element *e, const double *derivative)
{
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double stays[3], *d = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    for (int i = 0; i < 3; i++) stays[i] = 1 - rho[i] * compliance[i];
    d[0] = derivative[0] * rho[0] / (1 - derivative[0] * stays[0]);
    d[1] = d[2] = 0;
    const double *t = derivative;
    double b00 = 1 - t[4] * stays[1], b01 = -t[5] * stays[2], b10 = -t[7] * stays[1], b11 = 1 - t[8] * stays[2];
    double over = 1 / (b00 * b11 - b01 * b10), by_normal = rho[0] + stays[0] * d[0];
    const double right[3][2] = {
        {t[3] * by_normal, t[6] * by_normal}, {t[4] * rho[1], t[7] * rho[1]}, {t[5] * rho[2], t[8] * rho[2]}};
    for (int k = 0; k < 3; k++) {
        d[3 + k] = over * (b11 * right[k][0] - b01 * right[k][1]);
        d[6 + k] = over * (b00 * right[k][1] - b10 * right[k][0]);
    }
    return isfinite(over);
}

static bool conductance_of_any(const pinch_force_element *e, const double *derivative)
{
    enum { N = PINCH_CONTACT_ROWS_MAX };
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double a[N * N], column[N], scratch[N], *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    int pivot[N], rows = e->rows;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            a[i * rows + j] = (i == j) - derivative[i * rows + j] * (1 - rho[j] * compliance[j]);
    if (!pinch_lu_factor(rows, a, pivot, scratch)) return false;
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < rows; i++) column[i] = derivative[i * rows + j] * rho[j];
        pinch_lu_solve(rows, a, pivot, column, column);
        for (int i = 0; i < rows; i++) conductance[i * rows + j] = column[i];
    }
    return true;
}

void pinch_force_residual(const pinch_force_element *e, double *f, double *derivative)
{
    const double *r = pinch_force_values(e, PINCH_FORCE_R);
    double p[PINCH_CONTACT_ROWS_MAX];
    (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO),
                                    pinch_force_values(e, PINCH_FORCE_Z), p, derivative);
    for (int i = 0; i < e->rows; i++) f[i] = r[i] - p[i];
}

/* The shift A^-1 F follows from A^-1 = I + D rho^-1 (I - rho C). */
bool pinch_force_eliminate(pinch_force_element *e)
{
    enum { N = PINCH_CONTACT_ROWS_MAX };
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO),
                 *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double derivative[N * N], f[N], weighted[N], *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
    int rows = e->rows;
    pinch_force_residual(e, f, derivative);
    if (!(rows == PINCH_FORCE_CONTACT ? conductance_of_friction(e, derivative) : conductance_of_any(e, derivative)))
        return false;
    for (int j = 0; j < rows; j++) weighted[j] = (1 - rho[j] * compliance[j]) / rho[j] * f[j];
    e->conducts = false;
    for (int i = 0; i < rows; i++) {
        double shift = f[i];
        for (int j = 0; j < rows; j++) {
            shift += conductance[i * rows + j] * weighted[j];
            e->conducts = e->conducts || conductance[i * rows + j] != 0;
        }
        change[i] = -shift;
    }
    return true;
}
