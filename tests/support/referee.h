#ifndef PINCH_TEST_REFEREE_H
#define PINCH_TEST_REFEREE_H

#include <pinch/problem.h>

/*
 * Judges the answer of one step from the problem's data and outputs alone, in newtons. The laws are written out here
 * once more, from the equations in problem.h; neither the solver's code nor its verification is used.
 */
typedef struct referee_verdict {
    double balance;  /* N: largest |M (v+ - v*)/h - f| of a body; torques divided by its radius */
    double drive;    /* N: largest imbalance of a massless drive along its axis */
    double normal;   /* N: largest distance of a normal force from the normal law */
    double friction; /* N: largest distance of friction from the limit surface's closest point; torques over a length */
    double cone;     /* N: largest excess of friction over its limit */
    double direction; /* N: largest part of a slipping hard contact's friction along its slip */
    double joint;     /* m/s or rad/s: largest error of a hard row */
    double compliant; /* N: largest error of the force of a compliant row */
    double limited;   /* m/s or N: largest violation of a one-sided row */
    double scale;     /* N: the largest force that acts on a body, the inertia's included */
    double rounding;  /* N: what rounding of velocities does to forces: stiffness times step, times speed */
} referee_verdict;

void referee_judge(const pinch_problem *p, referee_verdict *v);

#endif
