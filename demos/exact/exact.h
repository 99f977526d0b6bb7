#ifndef PINCH_EXACT_H
#define PINCH_EXACT_H

#include <pinch/problem.h>

/* The exact answer of one implicit contact step: the laws of <pinch/problem.h>, assembled and solved to the last digits
 * of long double by code that shares nothing with Pinch's. It reads the problem's data and none of its results.  Pinch
 * solves for velocities in the freedoms that the joints leave. Here the unknowns are the forces of the contacts (with
 * the exact friction cone, whatever problem->faces says) and of every joint row, and the speeds of massless drives. It
 * is for tests and comparisons: it is dense and slow, and it allocates. */

typedef enum exact_status {
    EXACT_OK = 0,
    EXACT_NOT_FOUND,   /* no start led to an answer */
    EXACT_UNSUPPORTED, /* a law that is not covered: rolling friction, limits in newtons, viscous slip; rows for more
                        * than two bodies */
    EXACT_NO_MEMORY
} exact_status;

typedef struct exact_answer {
    double *force;    /* 4 per contact: normal, tangential 1 and 2 (N), torsional (N m), on body 1 */
    double *velocity; /* 6 per body: v+, m/s and rad/s */
    double *row;      /* force of each joint row, N or N m */
    double residual;  /* how far the forces are from their laws, over `scale` */
    double scale;     /* N: the largest force of a contact, joint or drive */
    int iterations;   /* Newton steps of the start that led to the answer */
    int start;        /* which start that was; 0: no forces */
} exact_answer;

/* On EXACT_OK the caller gives the answer to exact_free. Otherwise nothing is kept. */
exact_status exact_solve(const pinch_problem *problem, exact_answer *answer);
void exact_free(exact_answer *answer);

#endif
