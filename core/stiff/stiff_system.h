/*
 * One step of an island with the forces as unknowns: for stiff contacts, where the velocity system (nonsmooth) fails,
 * and for large islands, whose linear systems are solved sparsely here.
 *
 * In the reduced coordinates of the mobility, with elements e (contacts and compliant joint rows, forces r_e) and
 * multipliers b (hard one-sided joint rows, impulses y_b, rows g_b of length one):
 *
 *     q   = h sum_e G_e^T r_e + sum_b g_b^T y_b               w = w0 + G q
 *     F_e = r_e - P_e(z_e) = 0                                z = (1 - rho C) r - rho (w - b)
 *     F_b = y_b - clamp(y_b - (w_b - c_b), low_b, high_b) = 0
 *
 * A Newton step eliminates the forces contact by contact. With J = dP/dz, A = I - J (I - rho C), D = A^-1 J rho:
 *
 *     dr = -A^-1 F - D G dq,    (I + h sum G^T D G) dq - sum g_b^T dy_b = -h sum G^T A^-1 F,    and F_b's own rows,
 *
 * as many unknowns as the bodies have freedoms, coupled where bodies touch: sparse in blocks.
 */
#ifndef PINCH_STIFF_STIFF_SYSTEM_H
#define PINCH_STIFF_STIFF_SYSTEM_H

#include "problem/reduced_rows.h"
#include "stiff/stiff_law.h"
#include "support/block_lu.h"

/* What points to doubles has one per row of the law, which few contacts have all of. */
typedef struct pinch_stiff_element {
    pinch_element_block block[2];
    int cluster[2]; /* of the blocks, -1: none */
    bool gives;     /* D is not zero */
    bool inside;    /* P(z) = z at the point last evaluated */
    pinch_stiff_law law;
    pinch_contact *contact; /* NULL: a joint row */
    /* of the contact as it came */
    double elastic[5]; /* tangent1, tangent2, torsion, rolling */
    double stiffness[3], damping[3], viscous[2];
    double compliance_before[3];
    double *w0, *b;
    double *inertia;    /* W_ii: (m/s)/(N s) or (rad/s)/(N m s) */
    double *prescribed; /* compliance C as the contact says */
    double *compliance; /* C as used */
    double *rho;
    double *r;         /* N or N m */
    double *w, *z, *f; /* at the point last evaluated */
    double *shift;     /* A^-1 F, of the Newton step at hand, */
    double *slope;     /* its D, rows x rows */
    double *change, *start;
} pinch_stiff_element;

typedef struct pinch_stiff_multiplier {
    pinch_element_block block[2]; /* g / sigma */
    int cluster[2];
    int row;                  /* of the problem */
    int unknown;              /* its place among the unknowns of the linear system */
    double sigma;             /* length of the row: y = h sigma lambda */
    double target, low, high; /* (c - w0) / sigma; bounds of y */
    double y, trial, f, change, start;
} pinch_stiff_multiplier;

typedef struct pinch_stiff_system {
    double step;
    const pinch_mobility *mobility;
    int element_count, contact_count, multiplier_count;
    pinch_stiff_element *elements; /* the contacts first, in their order */
    pinch_stiff_multiplier *multipliers;
    int *element_of_row; /* per joint row: its element, -1: eliminated, -2 - m: multiplier m */
    double *q;           /* at the point last evaluated */
    double scale;        /* of the merit's root: the forces that act or would act if each contact moved alone */
    double off, force;   /* N: the largest distance of a force from its law, the largest force, where last evaluated */

    bool planned, iterative; /* `lu` is incomplete, and preconditions */
    pinch_block_lu lu;
    int *block_size, *block_first; /* per cluster: its freedoms and multipliers */
    double *rhs;
    double *krylov;             /* 7 vectors, where `iterative` */
    bool factored;              /* `lu` has factors, of this step or an earlier one */
    int krylov_steps;           /* of the last iteration */
    double last_merit, sharper; /* where the last iteration began; how much more exact than usual they need be */
} pinch_stiff_system;

/* The problem's contacts as they came. */
void pinch_stiff_undo(const pinch_stiff_system *system);

/* Everything but compliance, rho, b and the start, which the ladder sets. False when memory ran out. */
bool pinch_stiff_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_stiff_system *system);

/* r and y from the forces that the problem carries. */
void pinch_stiff_warm_start(pinch_stiff_system *system, const pinch_problem *problem);

/*
 * Compliances with a floor: C = max(prescribed, floor h W) for contacts that may soften, W the larger of the two
 * tangents' for both. Where that is less than in the last step, the elastic state shrinks with it, so that the force
 * stays. Sets b and rho, and from r, w0 and y the scale.
 */
void pinch_stiff_set_floor(pinch_stiff_system *system, double floor);

/* q, w, z and F from r and y; returns the merit's root, sqrt(sum h (C + h W) F^2 + sum F_b^2) / scale. */
double pinch_stiff_evaluate(pinch_stiff_system *system);

/* w_e from q */
void pinch_stiff_element_velocity(const pinch_stiff_element *element, const double *q, double *w);
/* q += factor G_e^T x */
void pinch_stiff_add_impulse(const pinch_stiff_element *element, double factor, const double *x, double *q);

/*
 * The linear system of a Newton step from where the merit's root is `merit`: the farther from the answer, the less
 * exactly it need be solved. False: memory ran out, or (singular) it has no solution.
 */
bool pinch_stiff_step(pinch_arena *arena, pinch_stiff_system *system, double merit, bool *singular);

#endif
