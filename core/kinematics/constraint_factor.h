/*
 * The hard joint rows of a cluster of bodies, factored as (J Y)^T = Q R, equation (12) of core/README.md: Householder
 * vectors with column pivoting find rows that depend on others (loops, doubled joints), which then constrain nothing
 * twice.
 */
#ifndef PINCH_KINEMATICS_CONSTRAINT_FACTOR_H
#define PINCH_KINEMATICS_CONSTRAINT_FACTOR_H

#include "support/arena.h"

#include <pinch/problem.h>

/* The root Y of one body's inverse inertia is 1/sqrt(m) for the linear part and L^-T for the angular one, with inertia
 * = L L^T. */
typedef struct pinch_root_inverse {
    double linear;
    double t[6]; /* the upper triangle of L^-T: t00 t01 t02 t11 t12 t22 */
} pinch_root_inverse;

/* Returns false when the inertia is not positive definite. */
bool pinch_root_inverse_of(const pinch_body *body, pinch_root_inverse *w);
/* y = Y x and y = Y^T x for the six components of one body */
void pinch_root_apply(const pinch_root_inverse *w, const double *x, double *y);
void pinch_root_apply_transposed(const pinch_root_inverse *w, const double *x, double *y);

typedef struct pinch_constraint_factor {
    int n;     /* 6 times the bodies */
    int count; /* columns: rows of J that act on the cluster, each scaled to length one */
    double *
        column; /* column k at column + k n: R above the diagonal, Householder vectors from it on (their heads are 1) */
    int *row;   /* the problem's row of each column */
    double *length; /* before scaling */
    double *tau;    /* Householder scales */
    double *diagonal;
    int *order; /* pivoting */
    int rank;
    double *rhs;               /* per column: (c - J v*) / length */
    double *y;                 /* R^-T (c - J v*) */
    pinch_root_inverse *roots; /* per body */
} pinch_constraint_factor;

/* Makes room for `rows` columns on `bodies` bodies. Returns NULL when memory runs out. */
pinch_constraint_factor *pinch_constraint_allocate(pinch_arena *arena, int bodies, int rows);
/* Appends the row of the problem whose jacobian on body `slot[side]` (-1: none of the cluster's) is j[side]. */
void pinch_constraint_add(pinch_constraint_factor *c, int row, const int slot[2], const double *const j[2]);
void pinch_constraint_factorize(pinch_constraint_factor *c);
/* x <- Q x and x <- Q^T x, n components */
void pinch_constraint_apply_q(const pinch_constraint_factor *c, double *x);
void pinch_constraint_apply_q_transposed(const pinch_constraint_factor *c, double *x);
/* y = R^-T rhs */
void pinch_constraint_solve_transposed(pinch_constraint_factor *c);
/* x <- R^-1 x, rank components */
void pinch_constraint_solve(const pinch_constraint_factor *c, double *x);

#endif
