#ifndef PINCH_FRICTION_H
#define PINCH_FRICTION_H

#include <pinch/solver.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Rigid contacts with Coulomb friction, without bodies' poses or contact frames: what collections of frictional
 * problems hold. With the impulses r = (r_n, r_t) of all contacts, the velocities are
 *
 *     u = G G^T r + q
 *
 * and each contact obeys
 *
 *     0 <= r_n  ⊥  u_n >= 0,     |r_t| <= mu r_n,     |u_t| r_t = -mu r_n u_t .
 *
 * Several impulses may satisfy this, or none. The bodies' inertia is in G: with mass matrix M and rows H of the
 * contacts, G = H M^-1/2. Units are the caller's.
 */
typedef struct pinch_friction_contact {
    int body[2];        /* the bodies that it acts on, two different ones; -1: none */
    const double *g[2]; /* its rows (normal, tangent1, tangent2) for these, 3 x freedoms, row major; NULL for none */
    double free[3];     /* q: its velocity without impulses */
    double friction;    /* mu >= 0, finite */
    double impulse[3];  /* in: where the solve begins; out: r */
    double velocity[3]; /* out: u */
} pinch_friction_contact;

/* Bodies, by their freedoms alone, and their contacts. */
typedef struct pinch_friction_problem {
    int body_count;                   /* >= 0 */
    const int *freedoms;              /* per body, >= 1 */
    int contact_count;                /* >= 0 */
    pinch_friction_contact *contacts; /* contact_count of them */
} pinch_friction_problem;

/* How a solve ended, and what it took. */
typedef struct pinch_friction_result {
    pinch_solver_result solve; /* its status and counts; residual: of the last compliance */
    double error;              /* as pinch_friction_missed says */
    double compliance;         /* with which the answer was found, as a part of the diagonal of G G^T */
} pinch_friction_result;

/*
 * How far are impulses and velocities, as they stand in the contacts, from the laws? Returns
 *
 *     || r - P(r - u - mu |u_t| n) || / || q ||,     P: the projection onto the cones |r_t| <= mu r_n,
 *
 * not divided where q is 0. It is 0 for answers alone, and infinite where something is not finite. The FCLIB collection
 * measures by it.
 */
PINCH_API double pinch_friction_missed(const pinch_friction_contact *contacts, int count);

/*
 * Gives all contacts one compliance, a part of the diagonal of G G^T, solves with the forces as unknowns, and makes it
 * smaller from solve to solve. Then it counts from the forces of the solve before, so that in the end it falsifies
 * nothing, until the rigid laws hold to the tolerance by the measure above, with velocities that code of its own
 * computes from G, q and r. `settings`: tolerance and max_iterations count; the latter bounds the Newton steps and
 * steps along paths of all solves together.
 *
 * result->solve.status is PINCH_SOLVE_CONVERGED only for an answer; otherwise impulses and velocities are those of the
 * least error that was found, and result->error is that error.
 * Returns PINCH_INVALID_ARGUMENT for data outside the ranges above, PINCH_OUT_OF_MEMORY.
 */
PINCH_API pinch_status pinch_friction_solve(pinch_friction_problem *problem, const pinch_solver_settings *settings,
                                            pinch_friction_result *result);

#ifdef __cplusplus
}
#endif
#endif
