/* Solves the problem of a file. */
#ifndef PINCH_FRICTION_FRICTION_SOLVE_H
#define PINCH_FRICTION_FRICTION_SOLVE_H

#include "problem_file.h"

#include <pinch/friction.h>

/* rows.c: the same in coordinates in which the inertia is one. */
typedef struct friction_rows {
    pinch_friction_problem problem;
    double *storage; /* of all rows */
    int *freedoms;
} friction_rows;

/* A local problem becomes one body whose freedoms are the rank of W; a global one has a body for each part of M that is
 * not coupled with others. On failure the reason is in error (512 bytes), and nothing is to be released. */
command_status friction_rows_make(const friction_file *file, friction_rows *rows, char *error);
void friction_rows_free(friction_rows *rows);

typedef struct friction_answer {
    pinch_solve_status status;        /* only PINCH_SOLVE_CONVERGED is an answer */
    pinch_friction_contact *contacts; /* impulses and velocities; in two dimensions the second tangent's are 0 */
    double error;                     /* pinch_friction_missed, with velocities by the file's own matrices */
    double compliance;                /* with which it was found, as a part of the diagonal of W */
    int iterations;
    int corrections; /* solves after the first, where the W of a file is not symmetric */
} friction_answer;

/*
 * Solves to the tolerance. A local problem gets its rows from W = L L^T, the symmetric part of W. Where W itself is not
 * that, because the inertia of its simulation was not symmetric or its digits were cut, the rest is put into q with the
 * impulses of the solve before, until these stay.
 * On failure the reason is in error (512 bytes). COMMAND_DONE also where no answer was found.
 */
command_status friction_solve(const friction_file *file, double tolerance, int max_iterations, friction_answer *answer,
                              char *error);
void friction_answer_free(friction_answer *answer);

#endif
