/*
 * The contact forces of a step, summed up by pairs of geoms: by ODE's solvers and Pinch, which may share them out to
 * different points, and of the exact answer (exact/exact.h).
 */
#ifndef PINCH_BENCH_PAIR_FORCES_H
#define PINCH_BENCH_PAIR_FORCES_H

#include "world.h"

typedef struct pair_force {
    int geom[2];     /* as they were added to the world, the smaller number first */
    double force[3]; /* N, on the first one's body */
} pair_force;

typedef struct pair_forces {
    pair_force *items;
    int count, room;
    bool complete; /* every force is known */
} pair_forces;

/* Of the step just done, by the world's own solver. `complete` is false where memory runs out. */
void pair_forces_read(const bench_world *w, pair_forces *forces);
/* Of the exact answer of the step that a watched world is in; to be called from its `watch`. `complete` is false also
 * where an island has no exact answer. */
void pair_forces_solve(const bench_world *w, pair_forces *forces);
void pair_forces_free(pair_forces *forces);

/* The largest difference of a pair's forces, N. NAN where one of the two is not complete. */
double pair_forces_difference(const pair_forces *a, const pair_forces *b);
/* The largest force of a pair, N. */
double pair_forces_largest(const pair_forces *forces);

#endif
