#include "law/contact_law.h"

#include <math.h>
#include <string.h>

void pinch_contact_law_of(const pinch_contact *contact, int faces, pinch_contact_law *law)
{
    law->rows = (int)contact->model;
    law->faces = faces;
    law->low = 0;
    law->high = contact->max_force;
    law->friction[0] = contact->friction[0];
    law->friction[1] = contact->friction[1];
    law->friction[2] = contact->torsional_friction;
    law->friction[3] = contact->rolling_friction[0];
    law->friction[4] = contact->rolling_friction[1];
    memcpy(law->limit, contact->friction_limit, sizeof law->limit);
}

void pinch_trial_force_of(const pinch_contact *contact, double step, pinch_trial_force *trial)
{
    const double *k = contact->stiffness, *c = contact->damping;
    trial->a[0] = k[0] * contact->depth;
    trial->g[0] = step * k[0] + c[0];
    for (int i = 1; i < 3; i++) {
        trial->a[i] = -k[1] * contact->elastic[i - 1];
        trial->g[i] = step * k[1] + c[1];
    }
    trial->a[3] = -k[2] * contact->elastic[2];
    trial->g[3] = step * k[2] + c[2];
}

/* Equation (5). An infinite coefficient gives nothing where there is no normal force. */
static double semi_axis(const pinch_contact_law *law, int i, double normal)
{
    return normal > 0 ? law->limit[i] + law->friction[i] * normal : law->limit[i];
}

/* The rows of friction that share an ellipsoid: two or three of them, from `first` on. */
typedef struct ellipsoid_rows {
    int first;
    const double *axis, *friction; /* of these rows */
    const double *metric;          /* of all rows */
    const double *weight;          /* of all rows: multiplies the derivative's columns; NULL: 1 */
} ellipsoid_rows;

/*
 * Projects onto the ellipsoid over the tangents, and torsion where there are four rows; or over the two rolling rows.
 * Its derivative with respect to r_n is exact where all semi-axes grow in proportion; where some are constant it is
 * taken as if all grew as the largest share says, which costs Newton steps and no accuracy.
 */
static bool project_ellipsoid(ellipsoid_rows on, pinch_friction_rows f)
{
    int rows = f.rows, count = rows == 4 ? 3 : 2, first = on.first;
    const double *axis = on.axis, *metric = on.metric + first, *s = f.trial + first;
    double normal = f.force[0], *derivative = f.derivative;
    double bounds[3] = {axis[0], axis[1], count == 3 ? axis[2] : 0},
           scaled[3] = {metric[0], metric[1], count == 3 ? metric[2] : 1};
    double trial[3] = {s[0], s[1], count == 3 ? s[2] : 0}, force[3], by_trial[9], by_scale[3];
    bool stick = pinch_limit_surface_project(bounds, scaled, trial, force, derivative ? by_trial : NULL,
                                             derivative ? by_scale : NULL);
    for (int i = 0; i < count; i++) f.force[first + i] = force[i];
    if (!derivative) return stick;
    double share = 0;
    for (int i = 0; i < count; i++)
        if (axis[i] > 0 && !isinf(axis[i])) share = fmax(share, on.friction[i] * normal / axis[i]);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++)
            derivative[(first + i) * rows + first + j] = by_trial[3 * i + j] * (on.weight ? on.weight[first + j] : 1);
        derivative[(first + i) * rows] = normal > 0 ? by_scale[i] * share / normal * f.normal_slope : 0;
    }
    return stick;
}

/* Holds torsion within a limit of its own. */
static bool project_interval(pinch_friction_rows f, int row, double limit, double friction, double weight)
{
    double z = f.trial[row], *r = &f.force[row];
    bool inside = fabs(z) <= limit;
    *r = inside ? z : copysign(limit, z);
    if (f.derivative && inside) f.derivative[row * f.rows + row] = weight;
    if (f.derivative && !inside) f.derivative[row * f.rows] = copysign(friction, z) * f.normal_slope;
    return inside;
}

/* Projects the two tangents onto the polygon; torsion is clamped by itself. */
static bool project_polygon(const pinch_contact_law *law, pinch_friction_rows f, const double *g)
{
    int rows = f.rows;
    double normal = f.force[0], *tangent = f.derivative, by_trial[4], by_scale[2];
    bool stick = pinch_limit_polygon_project(law->faces, law->friction[0] * normal, f.trial + 1, f.force + 1,
                                             tangent ? by_trial : NULL, tangent ? by_scale : NULL);
    if (tangent) {
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < 2; j++) tangent[(1 + i) * rows + 1 + j] = by_trial[2 * i + j] * g[1 + j];
            tangent[(1 + i) * rows] = by_scale[i] / normal * f.normal_slope;
        }
    }
    if (rows == 4) stick = project_interval(f, 3, law->friction[2] * normal, law->friction[2], g[3]) && stick;
    return stick;
}

bool pinch_contact_law_project_general(const pinch_contact_law *law, pinch_friction_rows f, const double *g)
{
    double axis[3];
    if (law->faces) return project_polygon(law, f, g);
    for (int i = 0; i < 3; i++) axis[i] = law->friction[i] * f.force[0];
    return project_ellipsoid((ellipsoid_rows){1, axis, law->friction, g, g}, f);
}

/* Torsion and rolling of a rolling contact: an interval, and an ellipse that is a circle where rolling is as hard about
 * both tangents. */
static bool project_rolling(const pinch_contact_law *law, pinch_friction_rows f, const double *axis, const double *rho)
{
    bool stick = true;
    f.force[3] = f.force[4] = f.force[5] = 0;
    if (axis[2] > 0) stick = project_interval(f, 3, axis[2], law->friction[2], 1);
    if (axis[3] == 0 && axis[4] == 0) return stick;
    return project_ellipsoid((ellipsoid_rows){4, axis + 3, law->friction + 3, rho, NULL}, f) && stick;
}

/* rows: the law's; the compiler unrolls loops where it is a constant. */
static inline pinch_contact_state project(const pinch_contact_law *law, int rows, const double *rho, const double *z,
                                          double *r, double *derivative)
{
    const double *friction = law->friction;
    if (derivative) memset(derivative, 0, sizeof(double) * (size_t)(rows * rows));
    double slope = pinch_contact_law_clamp_normal(law, z[0], &r[0]) ? 1 : 0, axis[5];
    if (derivative) derivative[0] = slope;
    if (rows == 1) return r[0] == 0 ? PINCH_CONTACT_OPEN : PINCH_CONTACT_STICK;

    for (int i = 0; i < rows - 1; i++) axis[i] = semi_axis(law, i, r[0]);
    pinch_friction_rows f = {rows, z, r, derivative, slope};
    bool stick = true, disc = rows != 4 && axis[0] == axis[1] && friction[0] == friction[1] && rho[1] == rho[2];
    if (disc && axis[0] == 0) /* nothing to slip against */
        r[1] = r[2] = 0;
    else if (disc)
        stick = pinch_friction_disc_project(f, axis[0], friction[0], 1);
    else
        stick = project_ellipsoid((ellipsoid_rows){1, axis, friction, rho, NULL}, f);
    if (rows == 6) stick = project_rolling(law, f, axis, rho) && stick;
    bool open = true;
    for (int i = 0; i < rows; i++) open = open && r[i] == 0;
    return open ? PINCH_CONTACT_OPEN : stick ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
}

pinch_contact_state pinch_contact_law_project(const pinch_contact_law *law, const double *rho, const double *z,
                                              double *r, double *derivative)
{
    return law->rows == 3 ? project(law, 3, rho, z, r, derivative) : project(law, law->rows, rho, z, r, derivative);
}

typedef struct spring {
    double stiffness, damping, elastic;
} spring;

/*
 * Equation (10) for friction row i: the spring and damper that moved from e to e+ pull with r, so
 * e+ = (c e/h - r)/(k + c/h), and what of the motion h w did not go into the spring is slip. A damper alone keeps no
 * displacement.
 */
static inline void finish_row(const pinch_contact_end *end, double h, int i, spring s, double *elastic_end,
                              double *slip)
{
    bool sticks = end->sticking & (1u << i);
    double moved = s.elastic + h * end->velocity[i];
    if (end->exact_velocity && sticks) {
        *elastic_end = moved;
        *slip = 0;
        return;
    }
    double k = s.stiffness, d = s.damping;
    *elastic_end = k == 0 ? 0 : (d * s.elastic / h - end->force[i]) / (k + d / h);
    *slip = sticks && k > 0 ? 0 : moved - *elastic_end;
}

void pinch_contact_law_finish(const pinch_contact_end *end, double step, pinch_contact *c)
{
    bool open = end->state == PINCH_CONTACT_OPEN, rolls = end->rows == 6;
    const double *k = c->stiffness, *d = c->damping;
    for (int i = 0; i < 4; i++) {
        c->force[i] = i < end->rows ? end->force[i] : 0;
        c->relative_velocity[i] = i < end->rows ? end->velocity[i] : 0;
    }
    for (int i = 0; i < 3; i++) {
        c->elastic_end[i] = c->slip[i] = 0;
        if (open || 1 + i >= end->rows) continue;
        bool flows = i < 2 && c->viscous[i] > 0; /* it has no spring */
        spring s = {flows ? 0 : k[i < 2 ? 1 : 2], d[i < 2 ? 1 : 2], c->elastic[i]};
        finish_row(end, step, 1 + i, s, &c->elastic_end[i], &c->slip[i]);
    }
    for (int i = 0; i < 2; i++) {
        double slip; /* rolling slip is nobody's */
        c->rolling_elastic_end[i] = 0;
        c->rolling_moment[i] = rolls ? end->force[4 + i] : 0;
        spring s = {k[2], d[2], c->rolling_elastic[i]};
        if (rolls && !open) finish_row(end, step, 4 + i, s, &c->rolling_elastic_end[i], &slip);
    }
    c->state = end->force[0] >= c->max_force ? PINCH_CONTACT_YIELD : end->state;
}
