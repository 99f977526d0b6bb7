#include "law/contact_law.h"

#include "law/limit_polygon.h"
#include "law/limit_surface.h"

#include <math.h>
#include <string.h>

void pinch_law_of_contact(const pinch_contact *contact, double step, int faces, pinch_law *law)
{
    const double *k = contact->stiffness, *c = contact->damping;
    law->rows = (int)contact->model;
    law->a[0] = k[0] * contact->depth;
    law->g[0] = step * k[0] + c[0];
    for (int i = 1; i < 3; i++) {
        law->a[i] = -k[1] * contact->elastic[i - 1];
        law->g[i] = step * k[1] + c[1];
    }
    law->a[3] = -k[2] * contact->elastic[2];
    law->g[3] = step * k[2] + c[2];
    law->faces = faces;
    law->low = 0;
    law->high = contact->max_force;
    law->friction[0] = contact->friction[0];
    law->friction[1] = contact->friction[1];
    law->friction[2] = contact->model == PINCH_CONTACT_SOFT ? contact->torsional_friction : 0;
}

/*
 * Where the friction disc |r_t| <= mu r_0 binds, r_t = mu r_0 d with d = s/|s|, so
 *     dr_t = mu d dr_0 + mu r_0/|s| (I - d d^T) ds,   ds = -g dw,   dr_0 = -g_0 dw_0 inside the clamp.
 */
static pinch_contact_state project_disc(const pinch_law *law, double normal_slope, const double *s, double *r,
                                        double *tangent)
{
    double limit = law->friction[0] * r[0], g = law->g[1];
    double length2 = s[1] * s[1] + s[2] * s[2];
    if (length2 <= limit * limit) {
        r[1] = s[1];
        r[2] = s[2];
        if (tangent) tangent[4] = tangent[8] = g;
        return PINCH_CONTACT_STICK;
    }
    double length = sqrt(length2), d1 = s[1] / length, d2 = s[2] / length;
    r[1] = limit * d1;
    r[2] = limit * d2;
    if (tangent) {
        double shrink = limit / length * g, mu = law->friction[0];
        tangent[3] = mu * d1 * normal_slope;
        tangent[6] = mu * d2 * normal_slope;
        tangent[4] = shrink * d2 * d2;
        tangent[8] = shrink * d1 * d1;
        tangent[5] = tangent[7] = -shrink * d1 * d2;
    }
    return PINCH_CONTACT_SLIP;
}

static pinch_contact_state project_surface(const pinch_law *law, double normal_slope, const double *s, double *r,
                                           double *tangent)
{
    int rows = law->rows;
    double axis[3], trial[3] = {s[1], s[2], rows == 4 ? s[3] : 0}, force[3], by_trial[9], by_scale[3];
    for (int i = 0; i < 3; i++) axis[i] = law->friction[i] * r[0];
    bool stick = pinch_limit_surface_project(axis, law->g + 1, trial, force, tangent ? by_trial : NULL,
                                             tangent ? by_scale : NULL);
    for (int i = 1; i < rows; i++) r[i] = force[i - 1];
    if (tangent) {
        for (int i = 1; i < rows; i++) {
            for (int j = 1; j < rows; j++) tangent[i * rows + j] = by_trial[3 * (i - 1) + j - 1] * law->g[j];
            tangent[i * rows] = by_scale[i - 1] / r[0] * normal_slope;
        }
    }
    return stick ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
}

/* The polygon for the two tangents; torsion is clamped by itself. */
static pinch_contact_state project_polygon(const pinch_law *law, double normal_slope, const double *s, double *r,
                                           double *tangent)
{
    int rows = law->rows;
    double by_trial[4], by_scale[2];
    bool stick = pinch_limit_polygon_project(law->faces, law->friction[0] * r[0], s + 1, r + 1,
                                             tangent ? by_trial : NULL, tangent ? by_scale : NULL);
    if (tangent) {
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < 2; j++) tangent[(1 + i) * rows + 1 + j] = by_trial[2 * i + j] * law->g[1 + j];
            tangent[(1 + i) * rows] = by_scale[i] / r[0] * normal_slope;
        }
    }
    if (rows == 4) {
        double limit = law->friction[2] * r[0];
        bool inside = fabs(s[3]) <= limit;
        r[3] = inside ? s[3] : copysign(limit, s[3]);
        stick = stick && inside;
        if (tangent && inside) tangent[15] = law->g[3];
        if (tangent && !inside) tangent[12] = copysign(law->friction[2], s[3]) * normal_slope;
    }
    return stick ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
}

pinch_contact_state pinch_law_evaluate(const pinch_law *law, const double *w, double *r, double *tangent)
{
    int rows = law->rows;
    double s[4];
    for (int i = 0; i < rows; i++) s[i] = law->a[i] - law->g[i] * w[i];

    pinch_contact_state state = PINCH_CONTACT_STICK;
    double normal_slope = law->g[0];
    r[0] = s[0];
    if (!(s[0] > law->low)) {
        r[0] = law->low;
        normal_slope = 0;
        state = PINCH_CONTACT_OPEN;
    } else if (s[0] >= law->high) {
        r[0] = law->high;
        normal_slope = 0;
    }
    if (tangent) {
        memset(tangent, 0, sizeof(double) * (size_t)(rows * rows));
        tangent[0] = normal_slope;
    }
    if (rows == 1) return state;
    if (r[0] == 0) {
        for (int i = 1; i < rows; i++) r[i] = 0;
        return PINCH_CONTACT_OPEN;
    }
    if (law->faces) return project_polygon(law, normal_slope, s, r, tangent);
    bool disc = rows == 3 && law->friction[0] == law->friction[1] && law->g[1] == law->g[2];
    return disc ? project_disc(law, normal_slope, s, r, tangent) : project_surface(law, normal_slope, s, r, tangent);
}
