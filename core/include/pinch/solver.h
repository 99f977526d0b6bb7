#ifndef PINCH_SOLVER_H
#define PINCH_SOLVER_H

#include <pinch/nonsmooth.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum pinch_solver {
    PINCH_SOLVER_NSNMGK = 0, /* greedy multi-step Kaczmarz: projects onto every candidate row (Ai and Li 2025) */
    PINCH_SOLVER_NSNGRK,     /* greedy randomized Kaczmarz: projects onto one row drawn from the candidates */
    PINCH_SOLVER_NEWTON,     /* semi-smooth Newton with line search */
    PINCH_SOLVER_LEMKE,      /* complementary pivoting, LCP only */
    PINCH_SOLVER_PGS,        /* projected Gauss-Seidel, LCP only */
    PINCH_SOLVER_COUNT
} pinch_solver;

/* The names of the command line: "nsnmgk", "nsngrk", "newton", "lemke", "pgs". */
PINCH_API const char *pinch_solver_name(pinch_solver solver);
/* Returns PINCH_INVALID_ARGUMENT when `name` names no solver. */
PINCH_API pinch_status pinch_solver_from_name(const char *name, pinch_solver *solver);

/* Called once an iteration (iteration 0 is the start) with ||F||_2, in the thread that solves. Slow: off (NULL) by
 * default. */
typedef void (*pinch_progress)(void *context, int iteration, double residual);

/* Which method solves, and how far it goes. */
typedef struct pinch_solver_settings {
    pinch_solver solver; /* default PINCH_SOLVER_NSNMGK */
    double tolerance;    /* an answer has ||F||_2 <= tolerance; > 0, default 1e-10 */
    double goal; /* Newton goes on below `tolerance` while a step still pays, down to this; 0 <= goal <= tolerance,
                  * default 1e-14 */
    int max_iterations; /* >= 1, default 20000 */
    bool newton_finish; /* NSNMGK: try a Newton step before every sweep; default true */
    uint64_t seed;      /* NSNGRK's row draws; default 1 */
    double budget; /* the most work that one solve of an island may take in the forces as unknowns, in products of 6 x 6
                    * blocks (a fifth of a microsecond, or less); factorizations that would not leave room for others
                    * are replaced by an iteration. >= 0; 0 (default): no limit */
    int sweeps;    /* > 0: an island of free bodies that goes over its budget is approximated by as many Gauss-Seidel
                    * sweeps, from the forces that it came with, and by a splitting method before them where it is a pile
                    * that is higher than these reach; 0 (default): it is given up; not negative */
    bool sweeps_alone;       /* where that would be possible, it is done without a try; default false */
    pinch_progress progress; /* default NULL */
    void *progress_context;  /* is handed to it */
} pinch_solver_settings;

PINCH_API pinch_solver_settings pinch_default_solver_settings(void);

/* How a solve ended, and what it took. */
typedef struct pinch_solver_result {
    pinch_solve_status status; /* only converged is an answer */
    int iterations;            /* outer iterations: Newton steps, sweeps, draws or pivots */
    long projections;          /* rows projected onto, or pivots */
    int newton_steps;          /* accepted Newton steps among the iterations */
    double residual;           /* ||F||_2 at the returned x */
    bool by_flow; /* the answer came by an implicit flow or along a path of solutions, where Newton's steps alone
                   * did not get there; their steps are among the newton_steps */
} pinch_solver_result;

/* True for Newton, and for NSNMGK with its Newton finish. */
PINCH_API bool pinch_solver_takes_newton_steps(const pinch_solver_settings *settings);

/* What found the answer of a solve that converged. */
typedef enum pinch_solved_by {
    PINCH_SOLVED_BY_START = 0,   /* where the solve began was the answer */
    PINCH_SOLVED_BY_NEWTON,      /* Newton's steps, or steps of steepest descent where those fail */
    PINCH_SOLVED_BY_PROJECTIONS, /* greedy projections; Newton's steps may have helped */
    PINCH_SOLVED_BY_FLOW,        /* an implicit flow or a path of solutions */
    PINCH_SOLVED_BY_LCP,         /* Lemke's method or projected Gauss-Seidel */
    PINCH_SOLVED_BY_COUNT
} pinch_solved_by;

PINCH_API pinch_solved_by pinch_solver_solved_by(const pinch_solver_settings *settings,
                                                 const pinch_solver_result *result);
/* "start", "newton", "projections", "flow", "lcp". Never NULL. */
PINCH_API const char *pinch_solved_by_name(pinch_solved_by by);

/* Doubles of scratch that pinch_solve_system needs for a system of `size` unknowns with any iterative solver. */
PINCH_API size_t pinch_solver_scratch(int size);

/*
 * Solves F(x) = 0 from the start x[size], in place, with NSNMGK, NSNGRK or Newton.
 * scratch: pinch_solver_scratch(size) doubles. Allocates nothing, prints nothing.
 * Returns PINCH_UNSUPPORTED for the LCP-only solvers, PINCH_INVALID_ARGUMENT for settings out of range; how the solve
 * ended is in result->status: converged; max_iterations, also when Newton finds no step that reduces ||F|| any further;
 * diverged when F is not finite. On anything but convergence x holds the last finite iterate: it is no answer.
 */
PINCH_API pinch_status pinch_solve_system(const pinch_system *system, const pinch_solver_settings *settings,
                                          double *scratch, double *x, pinch_solver_result *result);

#ifdef __cplusplus
}
#endif
#endif
