/*
 * The law of one contact over one step, equations (3) to (11) of core/README.md: the normal force is a clamped spring
 * and damper, and friction is the trial force of a spring and damper projected onto the friction cone. It is written
 * in the two forms that the two systems of unknowns need:
 *
 *     explicit     r = P(a - g w)       the force follows from the relative velocity        pinch_contact_law_evaluate
 *     projection   r = P(z)             z depends on the force itself                       pinch_contact_law_project
 *
 * A compliant joint row obeys the same law with a normal row alone.
 */
#ifndef PINCH_LAW_CONTACT_LAW_H
#define PINCH_LAW_CONTACT_LAW_H

#include "law/friction_cone.h"

#include <pinch/problem.h>
#include <string.h>

/* Rows of a contact: normal; tangent1, tangent2; torsion about the normal; rolling about tangent1, tangent2. */
enum { PINCH_CONTACT_ROWS_MAX = 6 };

typedef struct pinch_contact_law {
    int rows;  /* 1, 3, 4 (torsion shares the ellipsoid with the tangents) or 6 (torsion and rolling on their own) */
    int faces; /* of the polygon that replaces the disc, row 3 then has a limit of its own; 0: the exact cone */
    double low, high;             /* bounds of the normal force */
    double friction[5], limit[5]; /* semi-axis i of the limit surface: limit + friction r_n; N, N, N m, N m, N m */
} pinch_contact_law;

/* The trial force a - g w of a contact without torsion and rolling on their own, row by row. */
typedef struct pinch_trial_force {
    double a[4]; /* the force at w = 0, N or N m */
    double g[4]; /* h k + c: stiffness times step, plus damping */
} pinch_trial_force;

/* The law of `contact`, with `faces` facets of friction (0: the cone). It has no padding, and equal contacts have laws
 * that are equal to the bit. */
void pinch_contact_law_of(const pinch_contact *contact, int faces, pinch_contact_law *law);
void pinch_trial_force_of(const pinch_contact *contact, double step, pinch_trial_force *trial);

/* The clamped normal force of equation (3). Returns whether it lies between its bounds. */
static inline bool pinch_contact_law_clamp_normal(const pinch_contact_law *law, double trial, double *r)
{
    *r = trial;
    if (!(trial > law->low))
        *r = law->low;
    else if (trial >= law->high)
        *r = law->high;
    else
        return true;
    return false;
}

/* Projects onto a cross section of the cone that is no plain disc, in the metric 1/g. Returns whether it sticks. */
bool pinch_contact_law_project_general(const pinch_contact_law *law, pinch_friction_rows f, const double *g);

/* Tells whether friction of a contact with torsion lies inside its limit surface, none of whose semi-axes is zero. */
static inline bool pinch_contact_law_sticks(const double *friction, double normal, const double *s)
{
    double reach = 0;
    for (int i = 0; i < 3; i++) {
        double axis = friction[i] * normal;
        if (!(axis > 0)) return false;
        double part = s[1 + i] / axis;
        reach += part * part;
    }
    return reach <= 1;
}

/*
 * The explicit form: r[rows] at w[rows]; tangent (rows x rows, row major, may be NULL) = -dr/dw, an element of the
 * generalized Jacobian. Returns open, stick or slip. rows: those of the law, 1, 3 or 4; limits 0.
 */
static inline pinch_contact_state pinch_contact_law_evaluate_rows(const pinch_contact_law *law, int rows,
                                                                  const pinch_trial_force *trial, const double *w,
                                                                  double *r, double *tangent)
{
    double s[4] = {0};
    const double *g = trial->g, *friction = law->friction;
    for (int i = 0; i < rows; i++) s[i] = trial->a[i] - g[i] * w[i];

    double normal_slope = pinch_contact_law_clamp_normal(law, s[0], &r[0]) ? g[0] : 0;
    if (tangent) {
        memset(tangent, 0, sizeof(double) * (size_t)(rows * rows));
        tangent[0] = normal_slope;
    }
    if (rows == 1) return s[0] > law->low ? PINCH_CONTACT_STICK : PINCH_CONTACT_OPEN;
    if (r[0] == 0) {
        for (int i = 1; i < rows; i++) r[i] = 0;
        return PINCH_CONTACT_OPEN;
    }
    if (rows == 4 && law->faces == 0 && pinch_contact_law_sticks(friction, r[0], s)) {
        for (int i = 1; i < 4; i++) {
            r[i] = s[i];
            if (tangent) tangent[5 * i] = g[i];
        }
        return PINCH_CONTACT_STICK;
    }
    bool disc = rows == 3 && law->faces == 0 && friction[0] == friction[1] && g[1] == g[2];
    pinch_friction_rows f = {rows, s, r, tangent, normal_slope};
    bool stick = disc ? pinch_friction_disc_project(f, friction[0] * r[0], friction[0], g[1])
                      : pinch_contact_law_project_general(law, f, g);
    return stick ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
}

static inline pinch_contact_state pinch_contact_law_evaluate(const pinch_contact_law *law,
                                                             const pinch_trial_force *trial, const double *w, double *r,
                                                             double *tangent)
{
    return pinch_contact_law_evaluate_rows(law, law->rows, trial, w, r, tangent);
}

/*
 * The projection form, equation (11), exact cone only: r[rows] = P(z) in the metric sum (r - z)^2 / rho; derivative
 * (rows x rows, row major; may be NULL) = dP/dz, an element of the generalized Jacobian.
 */
pinch_contact_state pinch_contact_law_project(const pinch_contact_law *law, const double *rho, const double *z,
                                              double *r, double *derivative);

/* How a step ends at a contact. */
typedef struct pinch_contact_end {
    int rows;
    pinch_contact_state state;
    const double *force, *velocity; /* rows each */
    unsigned sticking;              /* bit i: friction row i sticks */
    bool exact_velocity; /* the velocities are the unknowns, and a row that sticks moves its spring by h w to the bit;
                          * otherwise the forces are, and the spring follows from them */
} pinch_contact_end;

/* Writes the contact's results: force, relative velocity, elastic state by equation (10), slip and state. */
void pinch_contact_law_finish(const pinch_contact_end *end, double step, pinch_contact *contact);

#endif
