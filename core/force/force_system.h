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
#ifndef PINCH_FORCE_FORCE_SYSTEM_H
#define PINCH_FORCE_FORCE_SYSTEM_H

#include "kinematics/reduced_rows.h"
#include "force/force_law.h"
#include "support/block_lu.h"

/* What an island's memory is mostly made of: what follows from something else in a few operations is not kept. */
typedef struct pinch_force_element {
    pinch_row_block block[2];
    int cluster[2]; /* of the blocks, -1: none */
    int rows;       /* of the law */
    bool conducts;     /* D is not zero */
    bool inside;    /* P(z) = z at the point last evaluated */
    const pinch_force_law *law;
    pinch_contact *contact; /* NULL: a joint row */
    double *values;         /* pinch_force_value by value, each with one double per row; the last are D, rows x rows */
} pinch_force_element;

typedef enum pinch_force_value {
    PINCH_FORCE_W0,
    PINCH_FORCE_B,
    PINCH_FORCE_COMPLIANCE, /* C as used */
    PINCH_FORCE_RHO,
    PINCH_FORCE_R,      /* N or N m */
    PINCH_FORCE_CHANGE, /* of r in the Newton step at hand; until dq is known, the part without it, -A^-1 F */
    PINCH_FORCE_CONDUCTANCE,  /* D of the linear system of that step, from its making to its solution; in the same place */
    PINCH_FORCE_Z = PINCH_FORCE_CONDUCTANCE, /* at the point last evaluated, until it has been put into D, and */
    PINCH_FORCE_START,                 /* the force that the search along the step began with */
} pinch_force_value;

/* How many doubles an element with this many rows has. */
static inline int pinch_force_value_count(int rows)
{
    return rows * (PINCH_FORCE_CONDUCTANCE + (rows > 2 ? rows : 2));
}

static inline double *pinch_force_values(const pinch_force_element *e, pinch_force_value value)
{
    return e->values + (int)value * e->rows;
}

typedef struct pinch_force_multiplier {
    pinch_row_block block[2]; /* g / sigma */
    int cluster[2];
    int row;                  /* of the problem */
    int unknown;              /* its place among the unknowns of the linear system */
    double sigma;             /* length of the row: y = h sigma lambda */
    double target, low, high; /* (c - w0) / sigma; bounds of y */
    double y, trial, f, change, start;
} pinch_force_multiplier;

typedef struct pinch_force_system {
    double step;
    const pinch_mobility *mobility;
    int element_count, contact_count, multiplier_count;
    pinch_force_element *elements;     /* the contacts first, in their order */
    struct pinch_force_before *before; /* per contact, once the answer has been read back: stiff_result.c */
    double *scratch;                   /* 12 per body, likewise */
    pinch_arena_mark built;            /* from here on, the arena has what Newton's steps need */
    pinch_force_multiplier *multipliers;
    int *element_of_row; /* per joint row: its element, -1: eliminated, -2 - m: multiplier m */
    double *q;           /* at the point last evaluated */
    double scale;        /* of the merit's root: the forces that act or would act if each contact moved alone */
    double off, force;   /* N: the largest distance of a force from its law, the largest force, where last evaluated */

    bool planned, iterative;   /* `lu` is incomplete */
    pinch_arena_mark laid_out; /* from here on, the arena has `lu` and `krylov` */
    pinch_block_lu lu;
    int *block_size, *block_first; /* per cluster: its freedoms and multipliers */
    double *rhs;
    double *krylov;             /* six vectors and what the split needs, where `iterative` */
    double last_merit, sharper; /* where the last iteration began; how much more exact than usual they need be */
} pinch_force_system;

/* Everything but compliance, rho, b and the start, which the ladder sets; the contacts stay as they came until the
 * answer is read back. False when memory ran out. */
bool pinch_force_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_force_system *system);

/* r and y from the forces that the problem carries. */
void pinch_force_warm_start(pinch_force_system *system, const pinch_problem *problem);

/*
 * Compliances with a floor: C = max(prescribed, floor h W) for contacts that may soften, W the larger of the two
 * tangents' for both. Where that is less than in the last step, the elastic state shrinks with it, so that the force
 * stays. Sets b and rho, and from r, w0 and y the scale.
 */
void pinch_force_set_floor(pinch_force_system *system, double floor);

/* The compliance 1/(h k + c) of one row that a contact as it came prescribes. */
double pinch_force_prescribed(const pinch_contact *contact, double step, int row);

/* The elastic state (tangent1, tangent2, torsion, rolling) that the element's contact starts from at its compliance. */
void pinch_force_elastic(const pinch_force_element *element, double elastic[5]);

/* q, z and F_b from r and y; returns the merit's root, sqrt(sum h (C + h W) F^2 + sum F_b^2) / scale. */
double pinch_force_evaluate(pinch_force_system *system);

/* w_e from q */
void pinch_force_element_velocity(const pinch_force_element *element, const double *q, double *w);
/* z[rows] at q, and r as it is */
void pinch_force_trial(const pinch_force_element *element, const double *q, double *z);

/* q += factor G_e^T x */
void pinch_force_add_impulse(const pinch_force_element *element, double factor, const double *x, double *q);

/*
 * The linear system of a Newton step from where the merit's root is `merit`: the farther from the answer, the less
 * exactly it need be solved. False: memory ran out, or (singular) it has no solution. z is no longer there afterwards.
 */
bool pinch_force_solve_linear(pinch_arena *arena, pinch_force_system *system, double merit, bool *singular);

#endif
