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

#include <pinch/problem.h>

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

/*
 * The explicit form: r[rows] at w[rows]; tangent (rows x rows, row major, may be NULL) = -dr/dw, an element of the
 * generalized Jacobian. Returns open, stick or slip. Rows 1, 3 or 4, limits 0.
 */
pinch_contact_state pinch_contact_law_evaluate(const pinch_contact_law *law, const pinch_trial_force *trial,
                                               const double *w, double *r, double *tangent);

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
