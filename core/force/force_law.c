#include "force/force_law.h"

#include "law/limit_surface.h"

#include <math.h>
#include <string.h>

void pinch_force_law_of_contact(const pinch_contact *c, pinch_force_law *law)
{
    memset(law, 0, sizeof *law); /* laws are compared to the bit */
    law->rows = (int)c->model;
    law->low = 0;
    law->high = c->max_force;
    law->friction[0] = c->friction[0];
    law->friction[1] = c->friction[1];
    law->friction[2] = c->torsional_friction;
    law->friction[3] = c->rolling_friction[0];
    law->friction[4] = c->rolling_friction[1];
    memcpy(law->limit, c->friction_limit, sizeof law->limit);
}

/* limit + friction r_n, infinite as soon as either is */
static double semi_axis(const pinch_force_law *law, int i, double normal)
{
    if (isinf(law->friction[i]) || isinf(law->limit[i])) return INFINITY;
    return law->limit[i] + law->friction[i] * normal;
}

/* Whether z is inside: r = z. The derivative's row and column of friction with respect to the normal: d axis/d r_n. */
static bool project_disc(double axis, double slope, const double *z, double *r, double *derivative, int rows)
{
    double length2 = z[1] * z[1] + z[2] * z[2];
    if (axis == 0) { /* nothing to slip against */
        r[1] = r[2] = 0;
        if (derivative) derivative[rows] = derivative[2 * rows] = 0;
        return true;
    }
    if (length2 <= axis * axis) {
        r[1] = z[1];
        r[2] = z[2];
        if (derivative) derivative[rows + 1] = derivative[2 * rows + 2] = 1;
        return true;
    }
    double length = sqrt(length2), d1 = z[1] / length, d2 = z[2] / length, shrink = axis / length;
    r[1] = axis * d1;
    r[2] = axis * d2;
    if (derivative) {
        derivative[rows] = slope * d1;
        derivative[2 * rows] = slope * d2;
        derivative[rows + 1] = shrink * d2 * d2;
        derivative[2 * rows + 2] = shrink * d1 * d1;
        derivative[rows + 2] = derivative[2 * rows + 1] = -shrink * d1 * d2;
    }
    return false;
}

/*
 * The general limit surface over `count` components. Its derivative with respect to r_n is exact where all semi-axes
 * grow in proportion; where some are constant it is taken as if all grew as the largest share says, which costs Newton
 * steps and no accuracy.
 */
static bool project_surface(const pinch_force_law *law, const double *axis, double normal, double normal_slope,
                            const double *rho, const double *z, double *r, double *derivative)
{
    int rows = law->rows, count = rows == 4 ? 3 : 2;
    double bounds[3] = {axis[0], axis[1], count == 3 ? axis[2] : 0},
           metric[3] = {rho[1], rho[2], count == 3 ? rho[3] : 1};
    double trial[3] = {z[1], z[2], count == 3 ? z[3] : 0}, force[3], by_trial[9], by_scale[3];
    bool stick = pinch_limit_surface_project(bounds, metric, trial, force, derivative ? by_trial : NULL,
                                             derivative ? by_scale : NULL);
    for (int i = 0; i < count; i++) r[1 + i] = force[i];
    if (!derivative) return stick;
    double share = 0;
    for (int i = 0; i < count; i++)
        if (axis[i] > 0 && !isinf(axis[i])) share = fmax(share, law->friction[i] * normal / axis[i]);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) derivative[(1 + i) * rows + 1 + j] = by_trial[3 * i + j];
        derivative[(1 + i) * rows] = normal > 0 ? by_scale[i] * share / normal * normal_slope : 0;
    }
    return stick;
}

/* Torsion and rolling with limits of their own. */
static bool project_interval(double axis, double slope, int row, const double *z, double *r, double *derivative,
                             int rows)
{
    if (axis == 0) {
        r[row] = 0;
        return true;
    }
    if (fabs(z[row]) <= axis) {
        r[row] = z[row];
        if (derivative) derivative[row * rows + row] = 1;
        return true;
    }
    r[row] = copysign(axis, z[row]);
    if (derivative) derivative[row * rows] = copysign(slope, z[row]);
    return false;
}

static pinch_contact_state state_of(const double *r, int rows, bool stick)
{
    bool open = r[0] == 0;
    for (int i = 1; i < rows; i++) open = open && r[i] == 0;
    return open ? PINCH_CONTACT_OPEN : stick ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
}

pinch_contact_state pinch_force_project(const pinch_force_law *law, const double *rho, const double *z, double *r,
                                        double *derivative)
{
    int rows = law->rows;
    if (derivative) memset(derivative, 0, sizeof(double) * (size_t)(rows * rows));
    double slope = 0;
    r[0] = z[0];
    if (!(z[0] > law->low))
        r[0] = law->low;
    else if (z[0] >= law->high)
        r[0] = law->high;
    else
        slope = 1;
    if (derivative) derivative[0] = slope;
    if (rows == 1) return r[0] == 0 ? PINCH_CONTACT_OPEN : PINCH_CONTACT_STICK;

    double axis[5];
    for (int i = 0; i < rows - 1; i++) axis[i] = semi_axis(law, i, r[0]);
    bool round = rows != 4 && axis[0] == axis[1] && law->friction[0] == law->friction[1] && rho[1] == rho[2];
    bool stick = round ? project_disc(axis[0], isinf(axis[0]) ? 0 : law->friction[0] * slope, z, r, derivative, rows)
                       : project_surface(law, axis, r[0], slope, rho, z, r, derivative);
    for (int i = 2; rows == 6 && i < 5; i++) {
        double by_normal = isinf(axis[i]) ? 0 : law->friction[i] * slope;
        stick = project_interval(axis[i], by_normal, 1 + i, z, r, derivative, rows) && stick;
    }
    return state_of(r, rows, stick);
}
