/*
 * The friction cone of a contact and every projection onto it.
 *
 * The law of a contact knows its normal force and projects the trial friction onto the cross section of the cone there,
 * the friction limit surface: a disc, an ellipsoid or a polygon, equations (6) to (9) of core/README.md. The question
 * whether any forces can balance a load projects onto the whole cone at once, equation (46).
 */
#ifndef PINCH_LAW_FRICTION_CONE_H
#define PINCH_LAW_FRICTION_CONE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* A contact law while it projects: row 0 is the normal force, rows 1 and 2 are the tangents. */
typedef struct pinch_friction_rows {
    int rows;            /* of the law */
    const double *trial; /* rows */
    double *force;       /* rows, out */
    double *derivative;  /* rows x rows, row major, zero on entry, out; NULL: not wanted */
    double normal_slope; /* the derivative of the normal force */
} pinch_friction_rows;

/*
 * The disc |r_t| <= limit with the same metric along both tangents, equation (7): the closest point is radial,
 * r_t = limit d with d = s/|s|. Where it binds,
 *
 *     dr_t = mu d dr_n + limit/|s| (I - d d^T) ds.
 *
 * The derivative's friction columns are multiplied by `weight`. Returns whether the trial friction was inside.
 */
static inline bool pinch_friction_disc_project(pinch_friction_rows f, double limit, double mu, double weight)
{
    const double *s = f.trial;
    double *r = f.force, *derivative = f.derivative;
    int rows = f.rows;
    double length2 = s[1] * s[1] + s[2] * s[2];
    if (length2 <= limit * limit) {
        r[1] = s[1];
        r[2] = s[2];
        if (derivative) derivative[rows + 1] = derivative[2 * rows + 2] = weight;
        return true;
    }
    double length = sqrt(length2), d1 = s[1] / length, d2 = s[2] / length;
    r[1] = limit * d1;
    r[2] = limit * d2;
    if (derivative) {
        double shrink = limit / length * weight;
        derivative[rows] = mu * d1 * f.normal_slope;
        derivative[2 * rows] = mu * d2 * f.normal_slope;
        derivative[rows + 1] = shrink * d2 * d2;
        derivative[2 * rows + 2] = shrink * d1 * d1;
        derivative[rows + 2] = derivative[2 * rows + 1] = -shrink * d1 * d2;
    }
    return false;
}

/*
 * The limit surface, equation (8): the closest point r to the trial friction s = (t1, t2, tau) (N, N, N m) with
 *
 *     sum_i (r_i / axis_i)^2 <= 1        axis = r_n (mu, mu, mu_tau)   (N, N, N m; each >= 0, infinity allowed)
 *
 * in the compliance metric: r minimizes sum_i (r_i - s_i)^2 / stiffness_i (N/m, N/m, N m/rad; > 0). An axis of zero
 * length carries nothing: r_i = 0.
 *
 * dr_ds[9] (row-major) and dr_dscale[3] may be NULL. dr_dscale is the derivative with respect to a common factor on all
 * axes, at 1: dr/dr_n = dr_dscale / r_n. On the surface itself they are those of sticking.
 *
 * Returns whether s was inside or on the surface: the contact sticks and r = s.
 */
bool pinch_limit_surface_project(const double axis[3], const double stiffness[3], const double s[3], double r[3],
                                 double dr_ds[9], double dr_dscale[3]);

/*
 * The polygon, equation (9), the linearized counterpart of the disc: projects the trial friction s (N, N) onto the
 * regular polygon whose facet k has the outward normal at angle 2 pi k/faces and the distance `apothem` (N, >= 0) from
 * the centre. faces = 2 is the strip |r_1| <= apothem.
 *
 * dr_ds[4] (row-major) and dr_dscale[2], with respect to a common factor on the polygon at 1, may be NULL.
 * Returns whether s was inside: r = s.
 */
bool pinch_limit_polygon_project(int faces, double apothem, const double s[2], double r[2], double dr_ds[4],
                                 double dr_dscale[2]);

/*
 * The whole cone, in units in which friction is 1: the closest point y = (r_n, r_t1/mu, r_t2/mu, r_tau/mu_tau) to x
 * with
 *
 *     |(y_1, y_2, y_3)| <= y_0                                         faces = 0, the exact cone
 *     (y_1, y_2) in the polygon of apothem y_0,  |y_3| <= y_0          otherwise
 *
 * and low <= y_0 <= high (0 <= low; low = high prescribes the normal force; high may be INFINITY).
 * dy_dx[16] is the symmetric derivative.
 */
void pinch_friction_cone_project(int faces, double low, double high, const double x[4], double y[4], double dy_dx[16]);

#endif
