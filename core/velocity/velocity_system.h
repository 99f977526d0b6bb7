/*
 * The step of an island with the end velocities as unknowns: equations (17) and (18) of core/README.md, in the reduced
 * coordinates of the island's mobility. Elements e are contacts and compliant joint rows, whose forces are explicit
 * functions of their velocity; multipliers b are hard one-sided joint rows (stops, motors of limited force), whose
 * impulses are unknowns. All of F is divided by one scale, the size of the impulses that act at the start of the solve.
 */
#ifndef PINCH_VELOCITY_VELOCITY_SYSTEM_H
#define PINCH_VELOCITY_VELOCITY_SYSTEM_H

#include "kinematics/reduced_rows.h"
#include "law/contact_law.h"
#include "support/sparse_lu.h"

#include <stdint.h>

/* Systems of at most so many unknowns are factored as dense ones: to find their zeros would take longer. */
enum { PINCH_FEW_UNKNOWNS = 12 };

/* Of two clusters, each in up to two stretches. */
enum { PINCH_ELEMENT_BLOCKS = 4 };

typedef struct pinch_element {
    int blocks;
    pinch_row_block block[PINCH_ELEMENT_BLOCKS]; /* without columns of zeros */
    double w0[4];
    pinch_contact_law law;
    pinch_trial_force trial;
    double w[4], r[4]; /* at the point last evaluated */
    pinch_contact_state state;
    int multiplier; /* index of y_b among the unknowns, -1: an explicit force */
} pinch_element;

/* What an element with a multiplier has instead of a law. */
typedef struct pinch_multiplier {
    pinch_unit_row unit;
    double trial; /* y_b - (w_b - c_b) / sigma_b at the point last evaluated: what the bounds clamp */
} pinch_multiplier;

/*
 * A row along the rate of one joint, which is the unknown x: w = w0 + g x. Its force is clamp(a - gain g x, low, high),
 * or with a multiplier y = clamp(y - (g x - a), low, high), whose unit is that of impulses over the length of its row.
 */
typedef struct pinch_rate_row {
    int unknown;
    int multiplier; /* index of y among the unknowns, -1: an explicit force */
    double g;
    double a, gain; /* N, N s/m (N m, N m s); of a multiplier what is asked for of g x, and the length of its row */
    double low, high;
    double trial; /* at the point last evaluated: what the bounds clamp; at first the force that the row had */
} pinch_rate_row;

/*
 * What is kept of an island from step to step: the factors of its last Jacobian. While bodies, contacts and their
 * states stay as they were, these are nearly right for the next step, and one step with them replaces an assembly and a
 * factorization.
 */
struct pinch_step_memory {
    uint64_t tag;
    int unknowns, element_count; /* 0: nothing remembered */
    double *lu;                  /* of the Jacobian of F times its scale */
    int *pivot;
    unsigned char *states; /* per element */
    int unknown_room, element_room;
    size_t filled; /* numbers in lu: behind them all is zero */
};

typedef struct pinch_velocity_system {
    double step;
    int unknowns, freedoms;
    double scale; /* 0 until the first evaluation sets it */
    const pinch_mobility *mobility;
    int element_count;
    pinch_element *elements; /* the contacts first, in their order, then the joint rows that are not eliminated */
    int rate_count;
    pinch_rate_row *rates;         /* the joint rows along one rate each, which are no elements */
    pinch_multiplier *multipliers; /* in the order of their unknowns, which are the last */
    double *inertia;               /* d, per freedom */
    double *drive;                 /* h U^T f_drive - U^T M (v0 - v*), per freedom */
    bool listed;                   /* the next three are there: pinch_velocity_list_touching */
    int *touching_start;           /* per unknown's cluster: its elements */
    int *touching;
    int *cluster_of_unknown;
    int *part_of_row;                      /* per row that the mobility leaves: its rate row, or ~ its element */
    double *x, *start;                     /* unknowns each: the point, and the warm start to come back to */
    double *solver_scratch, *body_scratch; /* body_scratch: 12 per body */
    double *size;                          /* per unknown, sums of magnitudes for the scale */
    double *evaluated;                     /* the point that the elements were last evaluated at */
    bool has_drive;

    pinch_step_memory *memory; /* NULL: none */
    uint64_t tag;
    unsigned char *states;  /* per element, then per rate row, where the Jacobian was assembled */
    double *frozen;         /* the point of the last linearize */
    bool assembled, scaled; /* the Jacobian there is in `jacobian`; divided by F's scale */
    bool factored, factor_good;
    bool softened;      /* the factors are those with multipliers that give way */
    double *bounded;    /* the right hand side of such a step, which ends at their bounds */
    size_t factor_size; /* numbers in `lu` */
    bool remembered;    /* `solve` uses the memory's factors: good for the first step only */
    int linearized;     /* times */
    double *jacobian;   /* unknowns^2, row major */
    double *lu;
    int *pivot;
    double *lu_scratch;
    int *order;  /* the unknowns in the order of elimination, but for multipliers at a bound; NULL: as they come */
    int ordered; /* how many */
    int *held;   /* rate rows whose multipliers are inside their bounds and hold an unknown each; neither is in order */
    int held_count;
    int *row_of_first; /* scratch: freedoms + elements */
    pinch_sparse_lu sparse;
    double *permuted;
    pinch_row_segment segment;

    bool in_flow;
    double pull;          /* of the implicit flow (velocity_flow.c): F + pull H (x - anchor); 0 outside it */
    double *anchor;       /* unknowns */
    double *sticking;     /* H: the Jacobian with every contact closed and sticking, unknowns^2; NULL until needed */
    double *flow_scratch; /* unknowns */
} pinch_velocity_system;

/* Returns NULL where the element's force is an explicit function of its velocity. */
static inline pinch_multiplier *pinch_multiplier_of(const pinch_velocity_system *vs, const pinch_element *element)
{
    return element->multiplier < 0 ? NULL : &vs->multipliers[element->multiplier - vs->freedoms];
}

/*
 * Builds the system of `problem`, with the warm start from the forces that it carries in x. Element k belongs to
 * contact k, the others to the joint rows that are not eliminated. Returns false when memory ran out.
 */
bool pinch_velocity_system_build(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                                 pinch_velocity_system *vs);

/*
 * Solves from the warm start, in x, with the solver asked for; result->status says how it ended. Returns
 * PINCH_UNSUPPORTED or PINCH_OUT_OF_MEMORY where there is no solve at all.
 */
pinch_status pinch_velocity_solve(pinch_arena *arena, pinch_velocity_system *vs, const pinch_solver_settings *settings,
                                  pinch_solver_result *result);

/* Writes everything the problem asks for, from x. */
void pinch_velocity_read_back(pinch_velocity_system *vs, pinch_problem *problem);

/* Puts the system behind the solvers' interface; `vs` must outlive it. */
pinch_system pinch_velocity_system_interface(pinch_velocity_system *vs);

/* Measures F anew, by what acts and moves at x: where the forces of the start have all but gone, it was measured too
 * coarsely. */
void pinch_velocity_system_rescale(pinch_velocity_system *vs);

/* F at x, all of it and one row: the interface's own. vs is a pinch_velocity_system. */
void pinch_velocity_residual(void *vs, const double *x, double *f);
double pinch_velocity_residual_row(void *vs, const double *x, int row);

/* Evaluates all elements at x: w, r, state, trial. */
void pinch_velocity_system_evaluate(pinch_velocity_system *vs, const double *x);

/*
 * Follows the implicit flow, equation (20), from x, and leaves the answer there. a is halved where a step succeeds and
 * multiplied by 4 where it fails. Returns false when memory ran out; how the solve ended is in result, whose counts are
 * added to.
 */
bool pinch_velocity_flow(pinch_arena *arena, pinch_velocity_system *vs, const pinch_solver_settings *settings,
                         pinch_solver_result *result);

/*
 * Solves the linear complementarity problem of the step with the linearized friction cone, equation (21), with
 * `settings->solver`, a method that needs a matrix. PINCH_UNSUPPORTED for one-sided joint rows and massless drives,
 * whose laws are not of this form; PINCH_OUT_OF_MEMORY.
 */
pinch_status pinch_velocity_lcp_solve(pinch_arena *arena, pinch_velocity_system *vs,
                                      const pinch_solver_settings *settings, pinch_solver_result *result);

/* Writes the Jacobian of the point of the last linearize into `jacobian`, not divided by the scale. */
void pinch_velocity_assemble(pinch_velocity_system *vs);

/* Lists which elements touch which cluster, so that a single row of F costs no more than its own; most steps need none.
 */
void pinch_velocity_list_touching(pinch_velocity_system *vs);

/* w_e at x */
void pinch_element_velocity(const pinch_element *element, const double *x, double *w);

/* f += sign h G_e^T r_e with the element's present force; a multiplier's impulse is its unknown in x */
void pinch_element_add_impulse(const pinch_velocity_system *vs, const pinch_element *element, const double *x,
                               double sign, double *f);

/* lambda of a multiplier element at x, N or N m */
double pinch_element_multiplier(const pinch_velocity_system *vs, const pinch_element *element, const double *x);

/* jacobian (unknowns^2, zeroed) += d + h sum G_e^T D_e G_e with D_e of a closed and sticking contact, unit multipliers
 */
void pinch_velocity_sticking(pinch_velocity_system *vs, double *jacobian);

/* ---- velocity_rates.c: rows along rates ---- */

/* Fills in a row whose g is set. One without compliance has the multiplier. */
void pinch_rate_row_make(const pinch_joint_row *from, double step, double w0, int unknown, int multiplier,
                         pinch_rate_row *row);
void pinch_rates_evaluate(pinch_velocity_system *vs, const double *x);
/* Evaluates all at x, takes their impulses from f and writes the rows of their multipliers. */
void pinch_rates_residual(pinch_velocity_system *vs, const double *x, double *f);
/* Evaluates those that the row of an unknown depends on, and returns what they add to it. */
double pinch_rates_residual_row(pinch_velocity_system *vs, const double *x, int unknown);
/* f += g^T times their impulses at the point last evaluated, and size += |g^T impulse| */
void pinch_rates_add_impulses(const pinch_velocity_system *vs, const double *x, double *f);
void pinch_rates_add_size(const pinch_velocity_system *vs, const double *x, double *size);
/* Adds what they have in the Jacobian; sticking: with none at a bound and unit multipliers, as in
 * pinch_velocity_sticking. */
void pinch_rates_add_jacobian(const pinch_velocity_system *vs, bool sticking, double *jacobian);
unsigned char pinch_rate_row_state(const pinch_velocity_system *vs, const pinch_rate_row *row);
/* lambda at the point last evaluated, N or N m */
double pinch_rate_row_force(const pinch_velocity_system *vs, const pinch_rate_row *row);

/* ---- single_body.c: one free body ---- */

/*
 * Solves a problem of one body with mass and massless drives that touch nothing else, whose contacts have the cone and
 * no limits of friction of their own, and of no rows. Full Newton steps from the forces of the last step are all it
 * takes: where these do not converge, result->status says so, and only outputs have been written to, or nothing.
 */
pinch_status pinch_single_body_solve(pinch_arena *arena, pinch_problem *problem, const pinch_solver_settings *settings,
                                     pinch_solver_result *result);

/* What an element does, as far as factors depend on it: the state of a contact, or of a multiplier or rate row one of
 * these. */
enum { PINCH_VELOCITY_AT_BOUND = 8, PINCH_VELOCITY_INSIDE };

/* velocity_memory.c: one of them, and all, of elements and rate rows */
unsigned char pinch_velocity_state_of(const pinch_velocity_system *vs, const pinch_element *element);
void pinch_velocity_states(const pinch_velocity_system *vs, unsigned char *states);
/* Are the remembered factors those of a system like this one? */
bool pinch_velocity_memory_fits(const pinch_velocity_system *vs);
/* Keeps the factors for the next step, when they are those of the system at x and `good`. */
void pinch_velocity_remember(pinch_velocity_system *vs, bool good);

static inline bool pinch_multiplier_inside(const pinch_multiplier *multiplier)
{
    return multiplier->trial > multiplier->unit.low && multiplier->trial < multiplier->unit.high;
}

#endif
