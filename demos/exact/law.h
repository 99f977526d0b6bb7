#ifndef PINCH_EXACT_LAW_H
#define PINCH_EXACT_LAW_H

#include <pinch/problem.h>

/*
 * The contact law as a function of the end velocity w = (normal, tangential 1 and 2, torsional), in long double:
 * mechanics in the order of <pinch/problem.h>.
 */
typedef struct exact_law {
    int rows;                      /* 1, 3 or 4 */
    long double start[4], rate[4]; /* trial force = start - rate w */
    long double friction[3];       /* limit over normal force: coefficients, m; may be infinite */
    long double most;              /* N */
} exact_law;

void exact_law_of(const pinch_contact *contact, double step, exact_law *law);

/*
 * r = law(w), and its derivative dr/dw (4 x 4, row major). `limit`: the normal force that friction is measured by, in
 * place of r[0] (frozen: its derivative is left out); < 0: r[0] itself.
 */
void exact_law_force(const exact_law *law, const long double w[4], long double limit, long double r[4],
                     long double slope[16]);

#endif
