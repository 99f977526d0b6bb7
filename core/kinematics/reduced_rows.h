/* Brings the rows of contacts and joints into the reduced coordinates of the mobility. */
#ifndef PINCH_KINEMATICS_REDUCED_ROWS_H
#define PINCH_KINEMATICS_REDUCED_ROWS_H

#include "kinematics/mobility.h"

/* The columns of some rows of G that belong to one cluster. */
typedef struct pinch_row_block {
    int first;       /* first unknown */
    int size;        /* number of unknowns, 0: no such block */
    const double *g; /* rows x size, row major */
} pinch_row_block;

/*
 * A contact's rows of G for one body as body 1 of the contact: normal, tangent1, tangent2, spin about the normal, about
 * tangent1, about tangent2; jacobian is rows x 6.
 */
void pinch_contact_jacobian(const pinch_contact *contact, const pinch_body *body, int rows, double *jacobian);

/*
 * Rows of G times the bodies' directions U, in one or two blocks; bodies of one cluster share a block. Times the
 * bodies' v0 they are added to w0[rows]. cluster[2]: those of the blocks, -1: no such block. Returns false when memory
 * ran out.
 *
 * pinch_contact_rows reduces all rows of the contact's model, pinch_joint_row_reduce one row of a joint.
 * pinch_coupling_reduce reduces a row made of `parts` rows, with a block for each cluster. It returns how many there
 * are, -1 when memory ran out; block and cluster have room for two a part.
 */
bool pinch_contact_rows(pinch_arena *arena, const pinch_mobility *mobility, const pinch_body *bodies,
                        const pinch_contact *contact, pinch_row_block block[2], int cluster[2], double *w0);

/* Where all clusters are single bodies without joints, a contact's rows can be placed in a room of so many doubles, and
 * then be filled, by any thread. */
bool pinch_all_clusters_single(const pinch_mobility *mobility);
int pinch_contact_rows_room(const pinch_mobility *mobility, const pinch_contact *contact);
void pinch_contact_rows_place(const pinch_mobility *mobility, const pinch_contact *contact, double *room,
                              pinch_row_block block[2], int cluster[2]);
void pinch_contact_rows_fill(const pinch_mobility *mobility, const pinch_body *bodies, const pinch_contact *contact,
                             const pinch_row_block block[2], double *w0);

bool pinch_joint_row_reduce(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row,
                            pinch_row_block block[2], int cluster[2], double *w0);
int pinch_coupling_reduce(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row, int parts,
                          pinch_row_block *block, int *cluster, double *w0);

/*
 * A joint row whose force is a multiplier, scaled so that what it moves and its compliance add up to one: its
 * multiplier y = h sigma lambda has the units of q, equation (18) of core/README.md.
 */
typedef struct pinch_unit_row {
    double sigma;      /* length of the reduced row; with compliance, the root of its square and cfm/h */
    double compliance; /* cfm / (h sigma^2) */
    double target;     /* (rhs - w0) / sigma */
    double low, high;  /* bounds of y */
} pinch_unit_row;

/* Divides the row's blocks by sigma. Returns false, with blocks and *unit as they were but for sigma = 0, where
 * the row acts on nothing that can move. */
bool pinch_unit_row_make(const pinch_joint_row *row, double step, double w0, pinch_row_block *block, int blocks,
                         pinch_unit_row *unit);

/* The square of one row's length: of a contact, W_ii in (m/s)/(N s) or (rad/s)/(N m s). */
static inline double pinch_blocks_norm2(const pinch_row_block block[2], int row)
{
    enum { BODY = 6 };
    double sum = 0;
    for (int b = 0; b < 2; b++) {
        int size = block[b].size;
        const double *g = block[b].g + row * size;
        if (size == BODY) /* whose loop the compiler unrolls */
            for (int k = 0; k < BODY; k++) sum += g[k] * g[k];
        else
            for (int k = 0; k < size; k++) sum += g[k] * g[k];
    }
    return sum;
}

/* The product of two rows of an element in the same sense. */
static inline double pinch_blocks_dot(const pinch_row_block block[2], int row1, int row2)
{
    double sum = 0;
    for (int b = 0; b < 2; b++) {
        const double *g1 = block[b].g + row1 * block[b].size, *g2 = block[b].g + row2 * block[b].size;
        for (int k = 0; k < block[b].size; k++) sum += g1[k] * g2[k];
    }
    return sum;
}

#endif
