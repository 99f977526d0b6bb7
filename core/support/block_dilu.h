/*
 * Sparse matrices of blocks whose factors would fill in too much, made ready for iteration. With A = L + D0 + U and, in
 * the order of elimination,
 *
 *     D_k = A_kk - sum of A_ki D_i^-1 A_ik over the earlier i,
 *
 * (D + L) D^-1 (D + U) is nearly A (Meijerink and van der Vorst, "An iterative solution method for linear systems of
 * which the coefficient matrix is a symmetric M-matrix", 1977: nothing but the diagonal changes). Scaled by D^-1 from
 * the left, L and U now standing for D^-1 L and D^-1 U, and C for D^-1 D0 - 2, what is iterated on is
 *
 *     K v = (1 + L)^-1 D^-1 b,    K = (1 + L)^-1 D^-1 A (1 + U)^-1,    x = (1 + U)^-1 v,
 *
 * and as D^-1 A = (1 + L) + (1 + U) + C, a product with K takes no more than one with A (Eisenstat, "Efficient
 * implementation of a class of preconditioned conjugate gradient methods", 1981):
 *
 *     K v = y + (1 + L)^-1 (v + C y),    y = (1 + U)^-1 v.
 */
#ifndef PINCH_SUPPORT_BLOCK_DILU_H
#define PINCH_SUPPORT_BLOCK_DILU_H

#include "support/block_lu.h"

/* Doubles of room that the split needs. */
size_t pinch_block_dilu_room(const pinch_block_lu *lu);

/* Of an incomplete plan: A's blocks become L, C and U, b becomes D^-1 b. Returns false when a pivot is zero to rounding
 * or not finite. */
bool pinch_block_dilu_split(pinch_block_lu *lu, double *b, double *room);

/* x = (1 + L)^-1 x, and x = (1 + U)^-1 x */
void pinch_block_dilu_lower(const pinch_block_lu *lu, double *x);
void pinch_block_dilu_upper(const pinch_block_lu *lu, double *x);

/* kv = K v; y: room for as many unknowns */
void pinch_block_dilu_times(const pinch_block_lu *lu, const double *v, double *kv, double *y);

#endif
