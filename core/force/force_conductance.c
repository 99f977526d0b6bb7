/* Eliminates a contact from a Newton step, equation (26) of core/README.md: its conductance D says how its force
 * follows its velocity. */
#include "force/force_system.h"

#include "force/force_rows.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

/* Finds the rows of D for two rows of friction that share a limit, from `first` on: D_tn and D_t below. */
static inline bool conductance_of_two(const pinch_force_element *e, const double *derivative, int first)
{
    const int rows = e->rows;
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double *d = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    const double *t = derivative + rows * first, *u = t + rows, *tt = t + first, *ut = u + first;
    double stays[2] = {1 - rho[first] * compliance[first], 1 - rho[first + 1] * compliance[first + 1]};
    double b00 = 1 - tt[0] * stays[0], b01 = -tt[1] * stays[1], b10 = -ut[0] * stays[0], b11 = 1 - ut[1] * stays[1];
    double over = 1 / (b00 * b11 - b01 * b10), by_normal = rho[0] + (1 - rho[0] * compliance[0]) * d[0];
    const double right[3][2] = {{t[0] * by_normal, u[0] * by_normal},
                                {tt[0] * rho[first], ut[0] * rho[first]},
                                {tt[1] * rho[first + 1], ut[1] * rho[first + 1]}};
    for (int k = 0; k < 3; k++) {
        int column = k == 0 ? 0 : first + k - 1;
        d[first * rows + column] = over * (b11 * right[k][0] - b01 * right[k][1]);
        d[(first + 1) * rows + column] = over * (b00 * right[k][1] - b10 * right[k][0]);
    }
    return isfinite(over);
}

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
    double *d = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    d[0] = derivative[0] * rho[0] / (1 - derivative[0] * (1 - rho[0] * compliance[0]));
    d[1] = d[2] = 0;
    return conductance_of_two(e, derivative, 1);
}

/*
 * The same with rolling and spinning, which have limits of their own (contact_law.c). The two rolling rows share one as
 * the tangents do. The row of spinning has but c in the normal's column and t on the diagonal of J, so that
 *
 *     D_n = c (rho_n + (1 - rho C)_n D_n) / b,  D_t = t rho / b    with b = 1 - t (1 - rho C).
 */
static bool conductance_of_rolling(const pinch_force_element *e, const double *derivative)
{
    enum { N = PINCH_CONTACT_ROWS_MAX };
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double *d = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    memset(d, 0, sizeof *d * N * N);
    if (!conductance_of_friction(e, derivative)) return false;
    double by_normal = rho[0] + (1 - rho[0] * compliance[0]) * d[0];
    double c = derivative[N * 3], t = derivative[N * 3 + 3], b = 1 - t * (1 - rho[3] * compliance[3]);
    d[N * 3] = c * by_normal / b;
    d[N * 3 + 3] = t * rho[3] / b;
    return b != 0 && conductance_of_two(e, derivative, 4);
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

/* p = P(z) at the point last evaluated, derivative = J (NULL: not wanted) */
static void project(const pinch_force_element *e, double *p, double *derivative)
{
    (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO),
                                    pinch_force_values(e, PINCH_FORCE_Z), p, derivative);
}

void pinch_force_residual(const pinch_force_element *e, double *f)
{
    const double *r = pinch_force_values(e, PINCH_FORCE_R);
    double p[PINCH_CONTACT_ROWS_MAX];
    project(e, p, NULL);
    for (int i = 0; i < e->rows; i++) f[i] = r[i] - p[i];
}

static bool find_conductance(const pinch_force_element *e, const double *derivative)
{
    if (e->rows == PINCH_FORCE_CONTACT) return conductance_of_friction(e, derivative);
    if (e->rows == PINCH_CONTACT_ROWS_MAX) return conductance_of_rolling(e, derivative);
    return conductance_of_any(e, derivative);
}

/* Tells whether a contact whose force is at the limit of its friction, as it slipped when that was found, hardly sticks
 * at z, p being P(z). */
static bool may_slip_on(const pinch_force_element *e, const double *p)
{
    static const double AT_LIMIT = 1 - 1e-9, NEAR = 0.99;
    const double *r = pinch_force_values(e, PINCH_FORCE_R);
    if (!e->inside || !pinch_force_has_disc(e) || !(r[0] > 0 && p[0] > 0)) return false;
    double limit = e->law->limit[0], friction = e->law->friction[0];
    double before = AT_LIMIT * (limit + friction * r[0]), near = NEAR * (limit + friction * p[0]);
    return near > 0 && near < INFINITY && r[1] * r[1] + r[2] * r[2] >= before * before &&
           p[1] * p[1] + p[2] * p[2] >= near * near;
}

/*
 * Finds P and J of the piece on which such a contact slips. By the slightest change of their velocities contacts that
 * creep are found to stick. A step with the derivative of those that stick spreads over them what moves, and they all
 * slip again in the steps that follow.
 */
static void slip_on(const pinch_force_element *e, double *p, double *derivative)
{
    static const double BEYOND = 1 + 1e-9;
    double outwards = BEYOND * (e->law->limit[0] + e->law->friction[0] * p[0]) / hypot(p[1], p[2]);
    const double slipping[PINCH_FORCE_CONTACT] = {p[0], p[1] * outwards, p[2] * outwards};
    (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO), slipping, p, derivative);
}

/* The shift A^-1 F follows from A^-1 = I + D rho^-1 (I - rho C). */
static inline bool eliminate(pinch_force_element *e, bool first)
{
    enum { N = PINCH_CONTACT_ROWS_MAX };
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO), *r = pinch_force_values(e, PINCH_FORCE_R),
                 *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double derivative[N * N], p[N], f[N], weighted[N], *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
    int rows = e->rows;
    project(e, p, derivative);
    if (first && may_slip_on(e, p)) slip_on(e, p, derivative);
    for (int i = 0; i < rows; i++) f[i] = r[i] - p[i];
    if (!find_conductance(e, derivative)) return false;
    for (int j = 0; j < rows; j++) weighted[j] = (1 - rho[j] * compliance[j]) / rho[j] * f[j];
    bool conducts = false, symmetric = true;
    for (int i = 0; i < rows; i++) {
        double shift = f[i];
        for (int j = 0; j < rows; j++) {
            shift += conductance[i * rows + j] * weighted[j];
            conducts = conducts || conductance[i * rows + j] != 0;
            symmetric = symmetric && conductance[i * rows + j] == conductance[j * rows + i];
        }
        change[i] = -shift;
    }
    e->conducts = conducts;
    e->symmetric = symmetric;
    return true;
}

bool pinch_force_eliminate(pinch_force_element *e, bool first)
{
    if (e->rows == PINCH_FORCE_CONTACT) return eliminate(e, first); /* the same, with loops that the compiler unrolls */
    return eliminate(e, first);
}
