/*
 * The step of an island with the forces as unknowns, equations (22) to (29), (54) and others of core/README.md: for
 * stiff contacts, where the velocity system fails, and for large islands, whose linear systems are sparse here.
 * README.md of this room says what each file does.
 */
#ifndef PINCH_FORCE_FORCE_SYSTEM_H
#define PINCH_FORCE_FORCE_SYSTEM_H

#include "kinematics/reduced_rows.h"
#include "law/contact_law.h"
#include "support/block_lu.h"
#include "support/double_double.h"
#include "support/loop.h"

/* An island's memory is mostly made of these: what follows from something else in a few operations is not kept. */
typedef struct pinch_force_element {
    pinch_row_block block[2];
    int cluster[2]; /* of the blocks, -1: none */
    int rows;       /* of the law */
    bool conducts;  /* the conductance D is not zero */
    bool symmetric; /* it is; where friction follows the normal force, it is not */
    bool inside;    /* P(z) = z at the point last evaluated */
    const pinch_contact_law *law;
    pinch_contact *contact; /* NULL: a joint row */
    double given_normal;    /* N: the normal force that limits of friction follow while they are given */
    double sinks_at_most;   /* m, by the floor, if answers at two floors have told; INFINITY */
    double *values;         /* pinch_force_value by value, each with one double per row; the last are D, rows x rows */
} pinch_force_element;

typedef enum pinch_force_value {
    PINCH_FORCE_W0,
    PINCH_FORCE_B,
    PINCH_FORCE_COMPLIANCE, /* C as used */
    PINCH_FORCE_RHO,
    PINCH_FORCE_R,           /* N or N m */
    PINCH_FORCE_CHANGE,      /* of r in the Newton step at hand; until dq is known, the part without it, -A^-1 F */
    PINCH_FORCE_CONDUCTANCE, /* D of the linear system of that step, while that is solved; in the same place stand */
    PINCH_FORCE_Z = PINCH_FORCE_CONDUCTANCE, /* z at the point last evaluated, until it has been put into D, and */
    PINCH_FORCE_START,                       /* the force that the search along the step began with */
} pinch_force_value;

/* How many doubles an element with this many rows has. */
static inline int pinch_force_value_count(int rows)
{
    return rows * (PINCH_FORCE_CONDUCTANCE + (rows > 2 ? rows : 2));
}

static inline double *pinch_force_values(const pinch_force_element *e, pinch_force_value value)
{
    return e->values + (int)value * e->rows;
}

/* Does friction have a disc for its cross section, and the same compliance along both tangents? */
static inline bool pinch_force_has_disc(const pinch_force_element *e)
{
    const pinch_contact_law *law = e->law;
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    return law->rows == 3 && law->friction[0] == law->friction[1] && law->limit[0] == law->limit[1] && rho[1] == rho[2];
}

/* The impulse y of a joint row that is hard and not eliminated, or that couples more than two bodies, is an unknown of
 * its own. */
typedef struct pinch_force_multiplier {
    int blocks;
    pinch_row_block *block; /* g / sigma */
    int *cluster;           /* of each block */
    int joint, place;       /* its block in the linear system, and its place there */
    pinch_unit_row unit;
    double y, trial, f, change, start;
    double kappa;  /* of equation (54) */
    double base;   /* what has been put aside of y; bounds and target are of the rest */
    double anchor; /* y in the proximal pass before */
    double missed; /* of what the row asks for, after that pass */
    double first;  /* y after the first pass */
    int bound;     /* -1, 1: taken to be at its lower or upper bound; 0: between them */
} pinch_force_multiplier;

/* Returns how far the row of a multiplier gives way to it by kappa; at a bound it does not. */
static inline double pinch_force_given_way(const pinch_force_multiplier *m)
{
    return m->bound == 0 ? m->kappa * m->base + m->kappa * (m->y - m->anchor) : 0;
}

/* Steps in the contacts alone: force_condensed.c. */
typedef struct pinch_force_condensed {
    int rows;         /* of all elements */
    int *first;       /* per element: its first row */
    int *order;       /* the elements in the order of their rows, that of the first row of S that they meet */
    double *delassus; /* h W, rows x rows */
    double *still;    /* per row: w where all forces are zero */
    double *w;        /* per row: at the point last evaluated */
    double *matrix, *rhs, *scratch;
    double *gathered;    /* scratch: of the rows of h W of an element, what belongs to elements that conduct */
    int *pivot, *acting; /* scratch of a step: the elements that conduct */
} pinch_force_condensed;

/* What a chunk of the elements adds to figures of all (support/loop.h). */
typedef struct pinch_force_partial {
    double sum, off, force;
    bool any;       /* it has what was looked for */
    bool symmetric; /* all of it is */
} pinch_force_partial;

typedef struct pinch_force_system {
    double step;
    const pinch_crew *crew;
    pinch_force_partial *partials; /* per chunk of elements: scratch */
    int *meet_first, *meets;       /* with a crew, per cluster: its elements in their order, as 2 k for block 0 of
                                    * element k and 2 k + 1 for block 1; otherwise NULL */
    int *clusters;                 /* with a crew, per element: the two of its blocks, side by side; otherwise NULL */
    const pinch_body *bodies;      /* the problem's; NULL: none move */
    const pinch_mobility *mobility;
    int element_count, contact_count, multiplier_count;
    pinch_force_element *elements;     /* the contacts first, in their order */
    struct pinch_force_before *before; /* per contact, once the answer has been read back: force_result.c */
    double *body_scratch;              /* 12 per body, likewise */
    pinch_arena_mark built;            /* from here on, the arena has what Newton's steps need */
    pinch_force_multiplier *multipliers;
    bool kept_rows;               /* there are multipliers of hard rows */
    bool dependent_rows;          /* these may depend on each other */
    int *element_of_row;          /* per joint row: its element, -1: eliminated, -2 - m: multiplier m */
    double *q;                    /* at the point last evaluated */
    double *base_q;               /* what the multipliers put aside add to it; NULL where no rows are dependent */
    pinch_double_double *exact_q; /* scratch, likewise */
    double scale;      /* of the merit's root: the forces that act or would act if each contact moved alone */
    double off, force; /* N: the largest distance of a force from its law, the largest force, where last evaluated */
    double row_off;    /* likewise the largest part of the scale by which the multiplier of a joint row is off */
    double row_missed; /* and the largest velocity that such a row misses by that, m/s or rad/s */

    bool planned, iterative; /* `lu` is incomplete */
    bool dear;               /* it is complete, and takes more than what an iteration is worth */
    double split_products;   /* what complete factors may take for (74); 0: it is not worth it, or not looked at */
    pinch_arena_mark plan_start, plan_end; /* where the arena has `lu` and `krylov`; what a caller puts behind stays */
    pinch_block_lu lu;
    pinch_block_order_memory *orders; /* from the caller, or NULL */
    int block_count;                  /* the clusters, and behind them the joints, of up to six multipliers each */
    int *block_size, *block_first;    /* per block: its unknowns, and the first of them */
    double *rhs, *rhs_kept, *elements_kept; /* the last two: before multipliers were added */
    double *refined;                        /* where lu.single: the right hand side, and the solution */
    struct pinch_force_bounds *bounds;      /* NULL where no multiplier has any */
    double *krylov;                         /* six vectors and what the split needs, where `iterative` */
    double work, budget;                    /* as pinch_solver_settings.budget: so far, and at most */
    bool given_up;                          /* an approximation is better than what it would go on to */
    bool needs_double;                      /* factors in single precision have failed */
    bool too_large;                         /* a complete factorization is not within the budget */
    bool may_stiffen;                       /* stiffer floors are tried for an answer at that of the last step */
    bool answer_counts;                     /* with the answer at hand no body sinks far */
    bool is_warm_start;                     /* no step has been taken since the warm start */
    double last_merit;                      /* where the last iteration began */
    double exactness_factor;                /* factor by which the tolerance of the linear iteration is tightened */

    struct pinch_force_joints *joints; /* NULL where there is no factor, or not yet */
    pinch_force_condensed *condensed;  /* NULL where steps in the contacts alone are not worth it */
    bool joints_tried;                 /* whether both are there has been found out */
    bool joints_kept;                  /* `joints` outlives the reading back of an answer */
    bool in_contacts;                  /* the rows hold, whatever the forces: y and q are not kept up to date */
} pinch_force_system;

/* Has any chunk of the elements what the last loop looked for? */
static inline bool pinch_force_any(const pinch_force_system *s)
{
    bool any = false;
    for (int k = 0; k < pinch_chunk_count(s->element_count); k++) any = any || s->partials[k].any;
    return any;
}

/* force_floors.c: the room's face */

typedef enum pinch_force_way {
    PINCH_FORCE_BY_NEWTON = 0, /* Newton's method and Gauss-Seidel sweeps, from floor level to floor level */
    PINCH_FORCE_BY_PATH,       /* for islands of moderate size that these leave: a path of solutions, then Newton's */
    PINCH_FORCE_BY_SWEEPS      /* settings->sweeps of Gauss-Seidel: an approximation, for free bodies */
} pinch_force_way;

/*
 * Solves with as little softening as it takes and writes velocities, contact and row results into the problem.
 * result->solve says how it ended; sweeps always end with something that counts as converged until it is checked.
 * `system` comes with `orders` and serves pinch_force_undo; where it converged, it has scratch for the check.
 * Returns false when memory ran out.
 */
bool pinch_force_solve(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                       const pinch_solver_settings *settings, pinch_force_way way, pinch_force_system *system,
                       pinch_step_result *result);

/* force_build.c: builds everything but `orders`, which is there, compliance, rho, b and the start, which follow with a
 * floor. The contacts stay as they came until the answer is read back. Returns false when memory ran out. */
bool pinch_force_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_force_system *system);

/* force_approximation.c */

/* Where a floor begins, as a part of h W, and by what factor a higher one is lowered in a quiet step. */
#define PINCH_FORCE_FIRST_FLOOR 1e-4
#define PINCH_FORCE_LOWERED     0.95

/*
 * Approximates the forces of free bodies from those of the last step, by system->split_products with (74), and with
 * settings->sweeps sweeps. *floor, that of the last step, becomes the floor that they are for. result->swept tells
 * whether they are no more than an approximation. Returns false when memory ran out.
 */
bool pinch_force_approximate(pinch_arena *arena, pinch_force_system *system, const pinch_problem *problem,
                             const pinch_solver_settings *settings, double *floor, pinch_step_result *result);

/* force_system.c */

/* An answer put aside: the forces, and the multipliers with what their passes have made of them. */
typedef struct pinch_force_answer {
    double *r, *base_q;
    pinch_force_multiplier *multipliers;
} pinch_force_answer;

/* Makes room for an answer. Returns false when memory ran out. */
bool pinch_force_make_room(pinch_arena *arena, const pinch_force_system *system, pinch_force_answer *answer);

/* Puts the answer aside, or brings it `back`. */
void pinch_force_keep(pinch_force_system *system, pinch_force_answer *answer, bool back);

/* The part of the largest force that a floor may falsify, equation (60), which is about the floor itself. */
#define PINCH_FORCE_MOST_MISSED 1e-2

/* Puts some more of a multiplier aside, or with by < 0 less. */
void pinch_force_shift_base(pinch_force_multiplier *multiplier, double by);

/* Sets r and y from the forces that the problem carries. */
void pinch_force_warm_start(pinch_force_system *system, const pinch_problem *problem);

/*
 * Sets compliances with a floor, equation (25): C = max(prescribed, floor h W) for contacts that may soften, W the
 * largest along any tangent for both. Where that is less than in the last step, the elastic state shrinks with it, so
 * that the force stays, equation (29). It also sets b and rho, and the scale.
 */
void pinch_force_set_floor(pinch_force_system *system, double floor);

/* Sets the scale from r, w0 and y. */
void pinch_force_set_scale(pinch_force_system *system);

/* Returns the force (N or N m) of a joint row; 0 where it is no part of the system, or acts on nothing that moves. */
double pinch_force_of_row(const pinch_force_system *system, int row);

/* Returns the compliance 1/(h k + c) that a contact as it came prescribes for one row. */
double pinch_force_prescribed(const pinch_contact *contact, double step, int row);

/* Writes the elastic state (tangent1, tangent2, torsion, rolling) that the element's contact starts from at its
 * compliance. */
void pinch_force_elastic(const pinch_force_element *element, double elastic[5]);

/* Adds h G^T x to `to`, x being that value of all elements, whose order gives the sums their bits. With a crew, the
 * clusters gather what is theirs. */
void pinch_force_add_impulses(const pinch_force_system *system, pinch_force_value value, double *to);

/* Evaluates q = h G^T r + J^T y. */
void pinch_force_move(pinch_force_system *system);

/* Evaluates q, z and F_b from r and y. Returns the merit's root, equation (28). */
double pinch_force_evaluate(pinch_force_system *system);

/* w_e from q */
void pinch_force_element_velocity(const pinch_force_element *element, const double *q, double *w);
/* z[rows] at q, and r as it is */
void pinch_force_trial(const pinch_force_element *element, const double *q, double *z);

/* q += factor G_e^T x */
void pinch_force_add_impulse(const pinch_force_element *element, double factor, const double *x, double *q);

/* force_sweeps.c */

/* Makes `count` sweeps of projected Gauss-Seidel, contact by contact and row by row. */
void pinch_force_sweeps(pinch_force_system *system, int count);

/* Does the same for free bodies without joint rows, in an order that suits heaps. *merit: as pinch_force_evaluate
 * afterwards. Returns false when memory ran out. */
bool pinch_force_sweep_alone(pinch_arena *arena, pinch_force_system *system, int count, double *merit);

/* Returns over how many contacts the farthest body hangs together with what does not move; 0 where none does, or memory
 * ran out. */
int pinch_force_height(pinch_arena *arena, const pinch_force_system *system);

/* force_splitting.c */

/*
 * Finds out whether (74) serves better than that many sweeps alone: where bodies are farther from what does not move
 * than these take a load, and complete factors take not much more than the sweeps. They are planned then. It sets
 * system->split_products. Returns false when memory ran out.
 */
bool pinch_force_may_split(pinch_arena *arena, pinch_force_system *system, int sweeps);

/*
 * Brings the forces of free bodies, from where they are, near their laws by steps of (74), all with the same complete
 * factors, where there may be such. *done tells whether these were found. Returns false when memory ran out.
 */
bool pinch_force_split(pinch_arena *arena, pinch_force_system *system, bool *done);

/* force_tresca.c */

/* Tells whether forces have a potential (73) where limits of friction are given, which they have where there are no
 * multipliers, and whether the budget has room for all its steps and what may follow, if they take as long as the
 * `steps` so far. Where they have not, sweeps take over. */
bool pinch_force_may_give_limits(const pinch_force_system *system, const pinch_solver_settings *settings, int steps);

/*
 * Minimizes it, with limits of friction that follow the normal forces from time to time, and leaves the forces there in
 * r. Returns whether these are likely to be a start from which Newton's method converges. It takes at most `limit`
 * steps, by which *steps is raised.
 */
bool pinch_force_tresca(pinch_arena *arena, pinch_force_system *system, int limit, int *steps);

/* force_newton.c */

/*
 * Runs Newton's method with line search from r and y as they are, at most `limit` steps. It sets result->status,
 * iterations, newton_steps and residual (the merit's root), and r lies in the friction cones to the last bit. Returns
 * false when memory ran out.
 */
bool pinch_force_newton(pinch_arena *arena, pinch_force_system *system, const pinch_solver_settings *settings,
                        int limit, pinch_solver_result *result);

/* Does the same within the iterations that settings->max_iterations leaves to those of *total, to which it adds its
 * own. */
bool pinch_force_newton_within(pinch_arena *arena, pinch_force_system *system, const pinch_solver_settings *settings,
                               int limit, pinch_solver_result *total, pinch_solver_result *result);

/* force_proximal.c */

/* In heaps where Newton's method fails, forces are led to this floor by (75), if it is not higher than the last:
 * answers at it count as a rule, and those at lower ones take longer. */
#define PINCH_FORCE_FLOOR_OF_HEAPS 1e-3

/* A way to forces at a floor by (75). */
typedef struct pinch_force_proximal {
    double floor;
    double ease;                /* the first further compliance, as a part of 1/rho */
    int sweeps;                 /* before it begins */
    pinch_force_answer *center; /* room for the forces about which contacts are compliant */
} pinch_force_proximal;

/* Tells whether an island has as many contacts as this serves, between free bodies. */
bool pinch_force_may_approach(const pinch_force_system *system);

/* Goes that way from the forces as they are. *total and *result: as pinch_force_newton_within; where it does not
 * arrive, the forces are the last that it found. Returns false when memory ran out. */
bool pinch_force_approach(pinch_arena *arena, pinch_force_system *system, const pinch_solver_settings *settings,
                          pinch_force_proximal way, pinch_solver_result *total, pinch_solver_result *result);

/*
 * Begins with a heap, at way->floor from the forces of the last step: by Newton's method in at most `limit` steps, or
 * where much has changed since and some sweeps do not take it up, by (75) from where these have come to. Newton's
 * method fails there as a rule, and takes many steps to find that out. From no forces at all, as those of a pile that
 * was just built, it does not. way->floor becomes the floor that was tried. Otherwise as pinch_force_approach.
 */
bool pinch_force_begin_heap(pinch_arena *arena, pinch_force_system *system, const pinch_solver_settings *settings,
                            pinch_force_proximal *way, int limit, pinch_solver_result *total,
                            pinch_solver_result *part);

/*
 * force_explicit.c: follows a path of solutions, equation (56), to the compliances as they are, with at most *steps
 * factorizations; *steps becomes their number. Where it has *arrived, r and y are near a solution. Returns false when
 * memory ran out.
 */
bool pinch_force_follow_path(pinch_arena *arena, pinch_force_system *system, int *steps, bool *arrived);

/* force_passes.c */

typedef struct pinch_force_passes {
    double missed;        /* the most, of a row, after the pass before */
    int count, put_aside; /* passes, and how many of them began with large multipliers put aside */
    bool begun, ended;    /* a second has begun; the answer is that of the first */
    bool approach;        /* the first pass need only come within PINCH_FORCE_APPROACHED times the tolerance */
    bool rough;           /* the pass before the last was but approached, and what it missed tells too little */
} pinch_force_passes;

enum { PINCH_FORCE_APPROACHED = 10000 };

typedef enum pinch_force_pass_kind {
    PINCH_FORCE_NO_PASS,
    PINCH_FORCE_FIRST_PASS,  /* that of zero anchors (again) */
    PINCH_FORCE_SAME_PASS,   /* the one before was but approached, and is to be solved */
    PINCH_FORCE_FURTHER_PASS /* from the anchors that the one before has found */
} pinch_force_pass_kind;

/* Prepares the next proximal pass from where the one before has come to. */
pinch_force_pass_kind pinch_force_next_pass(pinch_force_system *system, double merit, double tolerance,
                                            pinch_force_passes *passes);
/* Returns the least that the merit's root can come to beside multipliers of the size that they have. */
double pinch_force_rounding(const pinch_force_system *system);
/* Returns the least that it can come to beside the velocities that contacts are made of: bodies that move together
 * press each other with next to nothing, and the rounding of their momentum may be more than a tolerance of that. */
double pinch_force_rounding_of_motion(const pinch_force_system *system);

/* force_conductance.c */

/* f[rows] = F at the point last evaluated. */
void pinch_force_residual(const pinch_force_element *element, double *f);

/* Writes the conductance D = A^-1 J rho, and minus the shift A^-1 F where the change goes. first: this is the first
 * step from a warm start, in which what slipped slips on. Returns false where A is singular. */
bool pinch_force_eliminate(pinch_force_element *element, bool first);

/* force_condensed.c: steps in the contacts alone, where system->joints is there */

/* Sets system->condensed where that is worth it. Returns false when memory ran out. */
bool pinch_force_condense(pinch_arena *arena, pinch_force_system *system);

/* From here on until in_contacts is false again, pinch_force_evaluate and pinch_force_solve_linear work in the contacts
 * alone. The rows are those of the multipliers' targets and anchors as they are. */
void pinch_force_enter_contacts(pinch_force_system *system);

/* Goes on there to a next proximal pass, whose anchors are the multipliers of the one before. */
void pinch_force_advance_contacts(pinch_force_system *system);

/* Finds the changes of all forces in a Newton step. Returns false where there are none (singular). z is no longer there
 * afterwards. */
bool pinch_force_condensed_step(pinch_force_system *system);

/* force_bounds.c: the bounds of multipliers within a Newton step */

enum { PINCH_FORCE_MOST_CHANGED = 48 };

/* The multipliers that have a bound, in numbers of their own, and how they answer to changes of bounds. */
typedef struct pinch_force_bounds {
    int count;
    int *multiplier; /* per number, ascending */
    int *base;       /* the bound of each that the factors in system->lu are for */
    int *column;     /* its column of the answers, -1: none yet */
    double *value;   /* its y where `base` is 0, otherwise its row's error: after the step with these factors, */
    double *changed; /* and with other bounds */
    double *answer;  /* MOST_CHANGED columns: what a unit of the other of the two adds to all values */
    double *amount;  /* per column: that other of the two */
    double *matrix, *scratch, *rhs;
    int *of, *active, *pivot; /* per column: whose it is; scratch */
} pinch_force_bounds;

typedef enum pinch_force_bounds_end {
    PINCH_FORCE_BOUNDS_RIGHT, /* those that the factors are for are right */
    PINCH_FORCE_BOUNDS_NEW,   /* others should be: to be factored anew, and looked at again */
    PINCH_FORCE_BOUNDS_LAST   /* none are right; these are the last to be tried */
} pinch_force_bounds_end;

/* Sets system->bounds, and NULL where no multiplier can leave or reach a bound. To be called once system->rhs is there.
 * Returns false when memory ran out. */
bool pinch_force_plan_bounds(pinch_arena *arena, pinch_force_system *system);

/* Finds the bounds that hold after a step, from that with the bounds as they are: its factors are in system->lu and its
 * solution is in system->rhs. Sets each multiplier's `bound`. */
pinch_force_bounds_end pinch_force_settle_bounds(pinch_force_system *system);

/* Where the multiplier stands in the right hand side, and in the solution. */
static inline double *pinch_force_unknown_of(const pinch_force_system *s, const pinch_force_multiplier *m, double *x)
{
    return &x[s->block_first[m->joint] + m->place];
}

/* force_linear.c */

/*
 * Begins with rows that hold: finds the multipliers that satisfy the rows of joints while contacts keep the forces that
 * they have. A Newton step from rows that do not hold would begin with contacts that are moved by it. Returns false
 * when memory ran out.
 */
bool pinch_force_begin_rows(pinch_arena *arena, pinch_force_system *system);

/*
 * Solves the linear system of a Newton step from where the merit's root is `merit`: the farther from the answer, the
 * less exactly it need be solved. Returns false when it has no solution (singular) or memory ran out. z is no longer
 * there afterwards.
 */
bool pinch_force_solve_linear(pinch_arena *arena, pinch_force_system *system, double merit, bool *singular);

/* Plans complete factors that may take system->split_products, where there are none: Newton's method may have gone over
 * to an iteration. *complete tells whether there are such now. Returns false when memory ran out. */
bool pinch_force_plan_for_split(pinch_arena *arena, pinch_force_system *system, bool *complete);

/* Clears the right hand side of a linear system of the bodies, which is in the order of q where there are no
 * multipliers. Returns it, or NULL when memory ran out. */
double *pinch_force_clear_rhs(pinch_arena *arena, pinch_force_system *system);

/* Does without multipliers what pinch_force_solve_linear does, with conductances, which are diagonal, and right hand
 * side as they are, and leaves dq in the place of the latter; `exactness` is the part of that side which may be left.
 * Returns false where there is none. */
bool pinch_force_solve_for_rhs(pinch_arena *arena, pinch_force_system *system, double exactness);

/* Does so for another right-hand side, with the factors of that solve, where it had any, and as exactly as these are:
 * single precision leaves some millionths. */
void pinch_force_solve_again(pinch_force_system *system);

/* Plans complete factors in place of an iteration that has failed. Returns false where these are not within the budget,
 * there was no iteration, or memory ran out. */
bool pinch_force_stop_iterating(pinch_arena *arena, pinch_force_system *system);

/* force_assembly.c */

/* Assembles the matrix from the conductances, but for the multipliers, which are added to it then. */
void pinch_force_assemble_elements(pinch_force_system *system);
void pinch_force_add_multipliers(pinch_force_system *system);

/* Does residual = rhs - A x with the matrix A of free bodies, block by block, not as it was assembled but exactly. */
void pinch_force_find_residual(const pinch_force_system *system, const double *rhs, const double *x, double *residual);

/*
 * force_bicgstab.c: puts x of (I + h sum G^T D G) x = rhs in the place of rhs, from what pinch_block_dilu_split made of
 * system->lu and rhs, until the preconditioned residual is `exactness` of that right hand side. Returns false, with rhs
 * destroyed, where that takes too long.
 */
bool pinch_force_bicgstab(pinch_force_system *system, double exactness);

/* force_joints.c */

/*
 * Newton's steps find forces and multipliers together, and where contacts are stiff and jammed, their rounding leaves
 * joint rows that miss more than the check of an answer lets pass: rows that do not depend on each other have to hold
 * to their own rounding. With the forces as they are, the factor of S finds multipliers with which they do, and what
 * contacts move by that is far below what their laws tell. Tells, until an answer is read back, whether there is such a
 * factor, and no bound that might stop a multiplier on its way.
 */
bool pinch_force_may_hold_rows(const pinch_force_system *system);

/* Finds these multipliers. */
void pinch_force_hold_rows(pinch_force_system *system);

/* force_result.c */

/*
 * Writes velocities, contact and row results into the problem, from the forces of `system`, and elastic state,
 * stiffness and damping as they were used. Sets result->floor_depth, and *share to the largest part of its smaller
 * body's size by which the floor lets a contact sink. Releases what Newton's steps needed of the arena, to keep there
 * what the contacts came with, and scratch. Returns false when memory ran out.
 */
bool pinch_force_read_back(pinch_arena *arena, pinch_problem *problem, pinch_force_system *system,
                           pinch_step_result *result, double *share);

/* Before that: by how much (m) the floor lets each contact sink, and whether contacts or bodies would so far that the
 * answer is too soft. The latter returns false also when memory ran out, which the arena notes. */
void pinch_force_sinks(const pinch_problem *problem, const pinch_force_system *system, double *sinks);
bool pinch_force_sinks_far(pinch_arena *arena, const pinch_problem *problem, const pinch_force_system *system,
                           const double *sinks);

/* Restores the contacts as they came, where they have been written to. */
void pinch_force_undo(const pinch_force_system *system);

#endif
