#ifndef PINCH_PROBLEM_H
#define PINCH_PROBLEM_H

#include <pinch/solver.h>
#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * One implicit step of one island of bodies in compliant frictional contact.
 *
 * Over a step h the end velocities v+ and the contact forces r satisfy
 *
 *     M (v+ - v*) = h (G^T r + J^T lambda),   v* = v + h M^-1 f_ext
 *     r_n   = clamp(kn (depth - h w_n) - cn w_n, 0, max_force)
 *     r_t   = the friction limit surface's point closest to  -kt (e + h w_t) - ct w_t
 *
 * with w = G v+ the velocity of body 1 relative to body 2 in the contact frame. SI units, world frame.
 */

enum { PINCH_STATIC_BODY = -1 }; /* the other side of a contact or joint row does not move by itself */

typedef enum pinch_contact_model {
    PINCH_CONTACT_FRICTIONLESS = 1, /* normal force only */
    PINCH_CONTACT_HARD = 3,         /* point contact with friction */
    PINCH_CONTACT_SOFT = 4,         /* hard, and torsional friction about the normal */
    PINCH_CONTACT_ROLLING = 6 /* hard, with torsional and rolling friction; each of the two has a limit of its own */
} pinch_contact_model;

typedef enum pinch_contact_state {
    PINCH_CONTACT_OPEN = 0, /* no normal force */
    PINCH_CONTACT_STICK,    /* inside the limit surface, or no friction to slip against */
    PINCH_CONTACT_SLIP,     /* on the limit surface */
    PINCH_CONTACT_YIELD     /* the normal force is at max_force */
} pinch_contact_state;

/* "open", "stick", "slip", "yield" */
PINCH_API const char *pinch_contact_state_text(pinch_contact_state state);

/* A body that moves, or a massless drive. */
typedef struct pinch_body {
    double mass;          /* kg, > 0; 0 makes a massless drive, below */
    double inertia[9];    /* kg m^2, about the centre of mass, world axes, row major, symmetric, positive definite */
    double position[3];   /* centre of mass, m */
    double velocity[6];   /* v*: linear m/s, angular rad/s; of a massless drive: a guess of its velocity */
    double external[6];   /* f_ext that is already in v*, N and N m: only the scale of the residual */
    double radius;        /* m, > 0: what torques are divided by when residuals are reported */
    double drive_axis[3]; /* massless drive: the unit direction it can move along, world */
    double drive_force; /* massless drive: the force that pushes it along drive_axis, N; the contact forces on it add up
                         * to minus this exactly */
    double velocity_end[6]; /* out: v+ */
} pinch_body;

/* A contact between two bodies, or of a body with what does not move by itself. */
typedef struct pinch_contact {
    int body1, body2;           /* indices, or PINCH_STATIC_BODY; not the same */
    pinch_contact_model model;  /* which forces it has */
    pinch_contact_state state;  /* out */
    double position[3];         /* m */
    double normal[3];           /* unit, into body 1 */
    double tangent1[3];         /* unit, perpendicular to normal; the second tangent is normal x tangent1 */
    double surface_velocity[6]; /* m/s; rad/s about the normal, tangent1, tangent2: added to w, the motion of a partner
                                 * that is not in `bodies`; less what is aimed at */
    double depth;               /* penetration depth, m; negative: separation */
    double stiffness[3];        /* normal, tangential N/m, torsional (and rolling) N m/rad; > 0 where the model has
                                 * them; those of a contact that may soften: >= 0 with some damping */
    double damping[3];          /* normal, tangential N s/m, >= 0; torsional N m s/rad, >= 0 */
    double elastic[3];          /* e (m, along tangent1 and tangent2) and theta (rad) at the start of the step */
    double friction[2];         /* coefficients along tangent1 and tangent2, >= 0; with INFINITY what presses sticks,
                                 * and what does not press has no friction all the same */
    double torsional_friction;  /* m (torque limit per newton of normal force), >= 0 when soft or rolling */
    double rolling_friction[2]; /* m, about tangent1 and tangent2, >= 0: semi-axes of an ellipse; rolling only */
    /*
     * Limits that do not depend on the normal force, added to those that do: N along tangent1 and tangent2, N m about
     * the normal, tangent1 and tangent2; >= 0, INFINITY for friction without a limit. Such friction acts on a contact
     * without normal force, too. Not with a linearized cone.
     */
    double friction_limit[5];
    double viscous[2]; /* (m/s)/N, >= 0: tangent i has no spring and damper but gives way at this rate below its limit;
                        * 0: not so. Not with a linearized cone. */
    double max_force;  /* N, > 0; INFINITY for none */
    /*
     * A stiff contact that may be solved softer than its stiffness and damping say, by one common factor along the
     * normal and one for the rest: never with less compliance 1/(h k + c) than a small part of what the bodies' own
     * inertia gives it in a step. Its stiffness and damping then come back as they were used.
     */
    bool may_soften;
    int hold;             /* in and out, 0 at first: steps until a lower floor may be tried */
    int hold_span;        /* in and out, 0 at first: the value of hold when the floor was last raised */
    double floor;         /* in and out, 0 at first: the floor that its island needed last, as a part of the
                           * compliance that the bodies' inertia gives it in a step (core/README.md, (25)) */
    double compliance[3]; /* in and out: (m/s)/N along normal and tangents, (rad/s)/(N m), of the last step; 0 at first.
                           * Where it becomes smaller, the elastic state shrinks with it: the force stays. Where
                           * stiffness, damping or the step change, the caller rescales it (core/README.md, (29)). */
    double rolling_elastic[2], rolling_elastic_end[2]; /* rad about tangent1, tangent2: in, out */
    double rolling_moment[2];                          /* N m about tangent1, tangent2, on body 1: warm start and out */
    /* in: the forces of the last step, from which a solve begins and which say what stuck: of several answers of a step
     * the one in which that goes on sticking is taken; 0 for none. out: r = normal, tangential 1 and 2 (N), torsional
     * (N m), on body 1 */
    double force[4];
    double relative_velocity[4]; /* out: w = G v+ + surface_velocity, m/s, rad/s about the normal */
    double elastic_end[3];       /* out: e+, theta+ */
    double slip[3];              /* out: slip increment of the step, m, m, rad; exactly 0 while sticking, but along a
                                  * viscous tangent, where it is all of the motion */
} pinch_contact;

/*
 * One row of a joint: j1 v1+ + j2 v2+ + cfm lambda = rhs, lambda in [low, high] in ODE's sense: lambda <= high with the
 * left side too small only at high, and so on. Hard two-sided rows (cfm 0, no limits) are
 * eliminated where they are independent of each other: the island is solved in the mobility that they leave. Where they
 * depend on each other, as in many closed loops, and in large mechanisms, they are solved together with the contacts:
 * rows that say the same share what they carry, and rows that contradict each other end in the least violation, both in
 * proportion to their `yield`.
 *
 * A row that couples more than two bodies goes on in the rows behind it that say `continues`, with two bodies each:
 *
 *     sum over the row and those that continue it of (j1 v1+ + j2 v2+)  + cfm lambda = rhs
 *
 * rhs, cfm, yield and the bounds are those of the first. The others come back with its force and pivot. Such rows are
 * solved together with the contacts.
 */
typedef struct pinch_joint_row {
    int body1, body2;    /* indices, or PINCH_STATIC_BODY */
    double j1[6], j2[6]; /* the row on the velocity of body 1 and of body 2: linear, angular */
    bool continues;      /* it is a part of the row before it; not for the first row of a problem */
    double rhs;          /* m/s or rad/s */
    double cfm;          /* (m/s)/N or (rad/s)/(N m), >= 0 */
    double yield;     /* of a hard row that depends on others: the compliance, in the units of cfm, by which they share
                       * what they carry and what they miss; 0: a small one */
    double low, high; /* N or N m; -INFINITY, INFINITY for none */
    double force;     /* in: warm start of rows that are not eliminated; out: lambda */
    double violation; /* out: rhs less the left side of a hard row that contradicts others, m/s or rad/s; otherwise 0 */
    double pivot; /* out, of a hard two-sided row that is eliminated: what is left of it beside those before it in the
                   * elimination, as a part of its length in the metric of the inertia; 0 where it depends on others
                   * and was dropped, with force 0. 1 of a row that was solved together with the contacts, or that
                   * closes a loop and only shares what other rows carry. */
} pinch_joint_row;

/* A solve may remember something of an island for the next step. A memory serves one island, and one thread, at a time;
 * it may be passed from thread to thread between solves. */
typedef struct pinch_step_memory pinch_step_memory;

/* Does items first to end - 1 of a loop. */
typedef void pinch_loop_part(void *argument, int first, int end);

/* Threads of the caller's that share the loops of a large island. The answer does not depend on it, not by a bit. */
typedef struct pinch_crew {
    /* Has `part` done for items 0 to count - 1, cut from the left into ranges of `chunk` items, each range once, in any
     * order and by any thread, and returns when all is done. */
    void (*parallel_for)(void *context, int count, int chunk, pinch_loop_part *part, void *argument);
    void *context; /* is handed to it */
} pinch_crew;

/* An island and its step. */
typedef struct pinch_problem {
    double step; /* h, s, > 0 */
    /*
     * 0: the exact friction cone. 2 to 4096: the linearized one, an outer polygon whose facet k has the outward normal
     * at angle 2 pi k/faces from tangent1 and the distance mu r_n from the centre (2: the strip of plane problems); a
     * soft contact's torsion then has its own limit, |r_tau| <= mu_tau r_n. tangent1's friction counts in all
     * directions.
     */
    int faces;
    pinch_step_memory *memory; /* NULL: none */
    uint64_t tag;              /* which island this is: what was remembered under another tag is not used */
    bool keep_trial;        /* false: what is no answer comes back as NaN. True: as the velocities and forces that the
                             * solver ended with, for programs that look at why it failed */
    const pinch_crew *crew; /* NULL: the solve goes on in the caller's thread alone */
    int body_count, contact_count, row_count; /* lengths of the lists; >= 1, >= 0, >= 0 */
    pinch_body *bodies;                       /* in and out */
    pinch_contact *contacts;                  /* in and out */
    pinch_joint_row *rows;                    /* in and out */
} pinch_problem;

/* How the solve of a step ended, and what the check found that shares nothing with the solver. */
typedef struct pinch_step_result {
    pinch_solver_result solve; /* how the method ended; only converged is an answer */
    int unknowns;              /* of the system actually solved */
    double work;               /* in the forces as unknowns, as pinch_solver_settings.budget */
    bool over_budget;          /* the solve was given up because it takes too long for what it is */
    bool swept; /* the outputs are those of settings.sweeps: bodies move by the forces that are reported, and the fields
                 * below say how far these are from their laws. They are an answer only where solve.status says so */
    int dependent_rows; /* hard joint rows of bodies tied together by rows some of which depend on others: all
                         * share what they carry */
    double
        residual_max; /* over bodies: |R_b| / (h (sum |r| + |f_ext|) + |M (v+ - v*)|), torques over the body's radius */
    double cone;      /* largest excess of friction over its limit, N */
    double complementarity; /* largest distance from the normal law and from the sticking law, N */
    double slip_direction;  /* largest part of a slipping contact's friction that does not oppose the slip, N */
    double row_velocity;    /* largest velocity that a joint row misses although its force is free to correct it, m/s or
                             * rad/s */
    double row_force;       /* largest part of a joint row's force that is beyond its bounds, N or N m */
    double force_scale;     /* largest contact force, N */
    int floor_level;        /* how often the compliance floor was raised fivefold beyond the first; 0: it was not */
    double floor_depth;     /* m: the most that a floor's compliance lets a contact sink beyond what was prescribed */
    double floor_residual; /* N: the most by which a floor's compliance has a normal force miss the law as prescribed */
    bool too_soft;         /* the floor lets a contact sink by more than a hundredth of its smaller body's size, or four
                            * hundredths of a plate's thickness, or a body of a stack by more than a hundredth of its
                            * own size, with all contacts below it, or has a force miss its law by more than a
                            * hundredth of the largest: the answer is exact and verified, but of an island softer than
                            * the one asked for, and does not count as converged */
    bool gave_way; /* an answer was found that is too soft, or was at a floor that often is, whether or not a stiffer
                    * one was found after it */
} pinch_step_result;

/* Solves islands, any number of them one after the other. Each thread needs its own: a solver serves one call at a
 * time. Which solver solves an island makes no difference to the answer. */
typedef struct pinch_step_solver pinch_step_solver;

/* PINCH_OUT_OF_MEMORY or PINCH_OK. */
PINCH_API pinch_status pinch_step_solver_create(pinch_step_solver **solver);
PINCH_API void pinch_step_solver_destroy(pinch_step_solver *solver);
PINCH_API pinch_status pinch_step_memory_create(pinch_step_memory **memory);
PINCH_API void pinch_step_memory_destroy(pinch_step_memory *memory);
PINCH_API size_t pinch_step_memory_size(const pinch_step_memory *memory); /* bytes held */

/* What a memory holds, for programs that record a problem and solve it again: the factors of the last linear system. */
typedef struct pinch_step_factors {
    uint64_t tag;                /* of the problem that they are from */
    int unknowns, element_count; /* unknowns 0: there are none */
    const double *lu;            /* unknowns^2 */
    const int *pivot;            /* per unknown, 0 to unknowns - 1 */
    const unsigned char *states; /* per element */
} pinch_step_factors;

/* The pointers are into the memory, and good until the next solve with it. */
PINCH_API pinch_step_factors pinch_step_memory_read(const pinch_step_memory *memory);
/* Makes the memory hold a copy. PINCH_INVALID_ARGUMENT for counts and pivots out of range; PINCH_OUT_OF_MEMORY. */
PINCH_API pinch_status pinch_step_memory_write(pinch_step_memory *memory, const pinch_step_factors *factors);
/* Bytes of scratch held, and the most that one solve has needed so far. */
PINCH_API size_t pinch_step_solver_memory(const pinch_step_solver *solver, size_t *high_water);
/* Gives back scratch that no solve since the last call has needed, where that is more than a quarter of it; `least`
 * bytes stay in any case. */
PINCH_API void pinch_step_solver_trim(pinch_step_solver *solver, size_t least);

/*
 * Contacts that may soften, are very stiff (1/(h k + c) below a thousandth of what inertia gives them in a step), roll,
 * have limits of their own or give way, islands with rows that couple more than two bodies without compliance and
 * bounds, or more than two of what hard rows tie together, islands of more than 60 unknowns, and joints without
 * contacts along which nothing acts are solved with their forces as unknowns and a sparse factorization; the others in
 * the velocities, where the methods are those of pinch_solver_settings. What only the first takes needs NSNMGK with its
 * Newton steps or Newton, the exact cone, and no massless drive: PINCH_UNSUPPORTED otherwise.
 *
 * Solves one step of one island in place and checks the answer against the laws above with code that shares nothing
 * with the solution. result->solve.status is PINCH_SOLVE_CONVERGED only for an answer; on anything else the outputs are
 * NaN, or with result->swept an approximation, or with problem->keep_trial what the solver ended with. Returns
 * PINCH_INVALID_ARGUMENT for data outside the documented ranges; PINCH_UNSUPPORTED for Lemke and PGS with the exact
 * cone, with one-sided joint rows or with massless drives; PINCH_OUT_OF_MEMORY. Allocates only while an island is
 * larger than all before it (or all since scratch was given back); Lemke and PGS, which are there for reference,
 * allocate their matrices in every solve.
 *
 * Where contacts let go that stuck by the forces of the last step, up to seven further solves of at most 60 iterations
 * look for an answer in which they go on sticking: the result counts theirs, too, beyond max_iterations, and `progress`
 * begins anew with each.
 */
PINCH_API pinch_status pinch_step_solve(pinch_step_solver *solver, pinch_problem *problem,
                                        const pinch_solver_settings *settings, pinch_step_result *result);

#ifdef __cplusplus
}
#endif
#endif
