#ifndef PINCH_EXACT_SYSTEM_H
#define PINCH_EXACT_SYSTEM_H

#include <pinch/problem.h>

#include <stdbool.h>

/* law.c */

/* The contact law as a function of the end velocity w = (normal, tangential 1 and 2, torsional), in long double. */
typedef struct exact_law {
    int rows;                      /* 1, 3 or 4 */
    long double start[4], rate[4]; /* trial force = start - rate w */
    long double friction[3];       /* limit over normal force: coefficients, m; may be infinite */
    long double most;              /* N */
} exact_law;

void exact_law_of(const pinch_contact *contact, double step, exact_law *law);

/* r = law(w) and its derivative dr/dw (4 x 4, row-major). Where `limit` is >= 0, friction is measured by this normal
 * force in place of r[0], and its derivative is left out. */
void exact_law_force(const exact_law *law, const long double w[4], long double limit, long double r[4],
                     long double slope[16]);

/* system.c */

/*
 * The step as equations F(z) = 0 in the forces. z: the contacts' forces (law.rows each), then the joint rows' forces,
 * then the massless drives' speeds. What they do to the motion is linear,
 *
 *     motion = free + A z,   A_ij = h sum over bodies of g_i M^-1 g_j,
 *
 * where row i of g says how a body's velocity shows in contact velocity or joint row i, and what a unit of force i
 * does to the body; a massless drive has no M, its speed is an unknown that shows in motion directly.
 */
typedef struct exact_system {
    const pinch_problem *problem;
    int unknowns, contact_unknowns, drive_count;
    int *first;      /* per contact: the place of its first unknown */
    exact_law *laws; /* per contact */
    int *drive_of;   /* per body: the number of its drive, -1: none */
    int (*body)[2];  /* per force unknown: the bodies it acts on, -1 for none */
    long double *g;  /* 2 x 6 per force unknown */
    long double *a;  /* A, unknowns x unknowns; a drive's row is its balance of forces */
    long double *free;
    long double *inverse; /* 36 per body: M^-1 */
    long double *measure; /* per unknown: the divisor that makes its equation's error a force: 1, or a lever in m */
    long double scale;    /* N: the force that would stop the bodies in one step; its rounding is in every force */
} exact_system;

/* Returns false when memory runs out. Free it in either case. */
bool exact_system_build(exact_system *system, const pinch_problem *problem);
void exact_system_free(exact_system *system);

/* F(z) and its Jacobian (unknowns x unknowns). `limit` holds the limit of each contact, see exact_law_force; NULL for
 * none. */
void exact_system_evaluate(const exact_system *system, const long double *z, const long double *limit, long double *f,
                           long double *jacobian);

/* |F| in newtons: the largest of its parts, each divided by its measure. */
long double exact_system_error(const exact_system *system, const long double *f);
/* N: the largest force in z. */
long double exact_system_force(const exact_system *system, const long double *z);

/* v+ of a body. */
void exact_system_velocity(const exact_system *system, const long double *z, int body, double velocity[6]);

#endif
