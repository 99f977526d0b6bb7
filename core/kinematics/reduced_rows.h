/* Rows of contacts and joints, as jacobians of one or two bodies, in the reduced coordinates of the mobility. */
#ifndef PINCH_KINEMATICS_REDUCED_ROWS_H
#define PINCH_KINEMATICS_REDUCED_ROWS_H

#include "kinematics/mobility.h"

enum { PINCH_CONTACT_ROWS_MAX = 6 };

/* the columns of G_e that belong to one cluster */
typedef struct pinch_row_block {
    int first;       /* first unknown */
    int size;        /* number of unknowns, 0: no such block */
    const double *g; /* rows x size, row major */
} pinch_row_block;

/*
 * The first rows of G for one body as body 1 of the contact: normal, tangent1, tangent2, spin about the normal, about
 * tangent1, about tangent2; rows x 6.
 */
void pinch_contact_jacobian(const pinch_contact *contact, const pinch_body *body, int rows, double *jacobian);

/*
 * jacobian[side] (rows x 6) of body[side] (negative: none) times sign[side] and the bodies' directions U into one or
 * two blocks, bodies of one cluster sharing a block; times their v0 added to w0[rows]. cluster[2]: of the blocks, -1:
 * no such block. False when memory ran out.
 */
bool pinch_reduce_rows(pinch_arena *arena, const pinch_mobility *mobility, int rows, const int body[2],
                       const double *const jacobian[2], const double sign[2], pinch_row_block block[2],
                       int cluster[2], double *w0);

/* The same for a contact's first rows, for both its bodies. */
bool pinch_contact_rows(pinch_arena *arena, const pinch_mobility *mobility, const pinch_problem *problem,
                        const pinch_contact *contact, int rows, pinch_row_block block[2], int cluster[2],
                        double *w0);

#endif
