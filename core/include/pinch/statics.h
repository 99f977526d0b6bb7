#ifndef PINCH_STATICS_H
#define PINCH_STATICS_H

#include <pinch/lcp.h>
#include <pinch/problem.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The static grasp: one rigid object held by compliant fingertips under a constant wrench. SI units, world axes;
 * points, moments, displacements are about the object's centre of mass. Small displacements u (translation, rotation)
 * of the object from the pose in which every fingertip just touches:
 *
 *     r_n = clamp(kn (closing - w_n), 0, max_force)    or r_n = min(normal_force, max_force) (force control)
 *     r_t = -kt (w_t - slip), r_tau = -ktau (w_tau - slip_tau), inside the friction limit
 *     sum W r + wrench = 0
 *
 * where w = W^T u is the object's displacement at the contact along normal and tangents.
 */

typedef struct pinch_finger {
    double point[3];           /* m, contact relative to the centre of mass */
    double normal[3];          /* unit, into the object */
    double tangent1[3];        /* unit, perpendicular to normal; the second tangent is normal x tangent1 */
    pinch_contact_model model; /* in the plane, soft means hard */
    double stiffness[3];       /* normal, tangential N/m, torsional N m/rad; > 0 where the model has them */
    double friction;           /* mu, >= 0; unused when frictionless */
    double torsional_friction; /* m, torque limit per newton of normal force, >= 0; soft only */
    bool force_controlled;     /* normal_force instead of closing; then the base follows along the normal */
    double closing;            /* m, how far the base has moved along the normal */
    double normal_force;       /* N, >= 0 */
    double max_force;          /* N, > 0: the finger yields there; INFINITY for none */
} pinch_finger;

/* Fingers on an object under a wrench. */
typedef struct pinch_grasp {
    int finger_count;            /* >= 1 */
    const pinch_finger *fingers; /* finger_count of them */
    double wrench[6];            /* N and N m on the object: gravity, applied force and torque */
    double radius; /* m, > 0: the object's bounding radius, which makes torques and rotations comparable */
    double
        origin[3]; /* m, relative to the centre of mass: where `faithful` takes moments and displacements, since the
                    * paper's iteration counts depend on it; default 0. Results are about the centre of mass always. */
    bool planar;   /* moves in x, y and about z only; the wrench, normals and tangents must lie in the plane */
} pinch_grasp;

typedef enum pinch_formulation {
    PINCH_FORMULATION_COULOMB = 0, /* the exact friction cone, or the soft finger's ellipsoid */
    PINCH_FORMULATION_LCP          /* the linearized cone */
} pinch_formulation;

/* How a static grasp is solved. */
typedef struct pinch_statics_settings {
    pinch_solver_settings solver;  /* goal is used as it is; tolerance holds for the non-dimensional system */
    pinch_formulation formulation; /* default coulomb */
    /* Facets of the friction pyramid, facet k at angle 2 pi k/faces from tangent1; 3 to 4096, default 8; 2 (+-tangent1)
     * in the plane whatever it says. A soft finger's polytope is the prism of this polygon and |r_tau| <= mu_tau r_n.
     */
    int faces;
    bool inscribed; /* default false: the polytope touches the limit surface from outside, as in the paper; true: it
                     * lies inside, a prism scaled by 1/sqrt(2) as well */
    bool one_step;  /* coulomb: default false, closing and normal_force first, then the wrench, with the elastic state
                     * carried; true, everything at once from the undeformed state. lcp is always one step. */
    int path_steps; /* fewest load steps for closing and again for the wrench; >= 1, default 8 */
    /* Load steps are halved until one step and two halves agree to this part of the force scale in the tangential
     * springs' forces; > 0, default 1e-4; INFINITY: path_steps equal steps. */
    double path_tolerance;
    /* The paper's own procedure on its own complementarity problem (lcp only): start at 0, ||F|| <= 1e-4, 20000
     * iterations, no Newton finish; verified, but the status does not depend on it. Default false. */
    bool faithful;
    bool unit; /* with `faithful`: make the problem non-dimensional first; default false */
} pinch_statics_settings;

PINCH_API pinch_statics_settings pinch_default_statics_settings(void);

/* What one finger does. */
typedef struct pinch_finger_result {
    pinch_contact_state state;         /* a frictionless finger that presses slips */
    double r[4];                       /* normal, tangential 1 and 2 (N), torsional (N m): on the object */
    double force[3];                   /* N, world */
    double tangential_force[3];        /* N, world */
    double normal_displacement;        /* m, r_n/kn */
    double tangential_displacement[3]; /* m, world: -r_t/kt */
    double torsional_displacement;     /* rad, -r_tau/ktau */
    double slip[3];                    /* m, world: sum of the slip increments; r_t = -kt (w_t - slip) */
    double torsional_slip;             /* rad */
    double last_slip[3]; /* m, m, rad along tangent1, tangent2, about normal: increment of the last load step */
    double slip_margin;  /* 1 - hypot(|r_t|/mu, r_tau/mu_tau)/r_n; NaN where r_n = 0 or without friction */
} pinch_finger_result;

/* What the independent check of a static answer found. */
typedef struct pinch_static_verification {
    bool passed; /* all of the below within 1e-9 of force_scale (torques over radius) and what rounding u costs */
    double force_error, torque_error; /* N, N m: what is left of sum W r + wrench */
    double cone;                      /* N, largest excess of friction over its limit */
    double complementarity;           /* N, largest distance from the normal law and from the tangential spring */
    double slip_direction;            /* N, largest friction that the slip does not account for */
    double force_scale;               /* N, largest of all contact forces and the wrench */
} pinch_static_verification;

/* How a static solve ended, and what the object does. */
typedef struct pinch_statics_result {
    pinch_solver_result solve; /* residual: non-dimensional; iterations and the rest summed over all load steps */
    int size;                  /* unknowns of the system actually solved */
    double load_fraction;      /* part of the wrench reached; 0 when closing itself fails */
    double translation[3], rotation[3];     /* m, rad */
    pinch_static_verification verification; /* of an answer, or of what was refused as unverified */
    /* unit length in the metric |translation|^2 + radius^2 |rotation|^2; zero where the status has none. infeasible:
     * the twist that proves it, against which the wrench works, so that the object escapes the other way; unstable: how
     * the object escapes. m/m and rad/m. */
    double twist[6];
    double stiffness[36];    /* d(load)/d(displacement), N/m, N, N m: open fingers left out, all others sticking;
                              * row-major; NaN unless converged */
    bool large_displacement; /* the object moves by more than a tenth of its size (2 radius) or turns > 0.1 rad */
} pinch_statics_result;

/*
 * Memory for grasps of up to `fingers` fingers and `faces` facets (the planar two count as 3); opaque. faces = 0 leaves
 * out the complementarity problems: then coulomb and, for lcp, nsnmgk with its Newton finish remain. Each thread needs
 * its own: it serves one call at a time.
 */
typedef struct pinch_statics pinch_statics;
/* PINCH_INVALID_ARGUMENT for no finger, for facets outside of 0 to 4096 and for NULL; PINCH_OUT_OF_MEMORY. */
PINCH_API pinch_status pinch_statics_create(int fingers, int faces, pinch_statics **statics);
PINCH_API void pinch_statics_destroy(pinch_statics *statics);

/*
 * Solves the grasp; fingers[finger_count] receives one result each. On anything but convergence forces and
 * displacements are NaN. Allocates nothing.
 *
 * Where the load path of coulomb comes to an end, the object moves on under the growing load, as a body of that radius
 * would, until it comes to rest in another equilibrium or escapes: unstable is what escapes both creeping and swinging.
 * Which equilibrium such a jump ends in depends on a mass that the statics do not know.
 *
 * result->solve.status: converged (and verified), infeasible (proven by result->twist), unstable, ray, max_iterations
 * (also where the search for an equilibrium comes to the end of the work allowed, some seconds), diverged, unverified.
 * PINCH_INVALID_ARGUMENT: values outside the ranges above, and NULL. PINCH_UNSUPPORTED: coulomb with nsngrk, lemke or
 * pgs; faithful with coulomb.
 */
PINCH_API pinch_status pinch_statics_solve(pinch_statics *statics, const pinch_grasp *grasp,
                                           const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                           pinch_statics_result *result);

/* A grasp ceases to hold at some factor on its friction, on its wrench or on its grip. */
typedef struct pinch_static_limit {
    double holds; /* the factor nearest the limit that was seen to hold: converged and verified */
    double fails; /* the nearest beyond it that was seen not to: infeasible or unstable */
    /* converged: the two are within 1e-6 of each other, relative, or there is no limit to find; max_iterations: the
     * search came to the end of the work allowed, or to factors that neither hold nor fail (max_iterations,
     * unverified), before that */
    pinch_solve_status status;
} pinch_static_limit;

/* The reserves of a grasp. */
typedef struct pinch_static_limits {
    pinch_static_limit smallest_friction;   /* common factor on all mu and mu_tau, 0 to 1000 */
    pinch_static_limit largest_load_factor; /* on the wrench, closing unchanged, 0 to 1e6 */
} pinch_static_limits;

/*
 * Finds how much is in reserve: with which factors the same solve still converges. It closes in on the limit between a
 * factor that holds and one that does not. `holds` is NaN without friction, where no factor on friction up to 1000
 * holds, and where closing alone fails; it is 0 with fails NaN where no friction is needed, and INFINITY with fails NaN
 * where the load may grow beyond 1e6. fails is NaN as well where nothing was seen to fail. A load that grows on may let
 * go of an object that comes to rest elsewhere if the load stops there; the largest load is then the one where it is
 * let go. Costs ten to forty solves, and at most a second or two per limit. The work is counted, not timed: the same
 * grasp gives the same bits.
 *
 * Status as pinch_statics_solve; PINCH_UNSUPPORTED where that solves a complementarity problem.
 */
PINCH_API pinch_status pinch_statics_limits(pinch_statics *statics, const pinch_grasp *grasp,
                                            const pinch_statics_settings *settings, pinch_static_limits *limits);

/*
 * Finds the least grip that still holds: the smallest common factor, 0 to 1e6, on `closing` and `normal_force` of all
 * fingers, with friction and wrench unchanged. What a finger then closes or presses by is the factor times its own
 * closing or normal force. Each factor is tried by the same path as pinch_statics_limits tries its own; where no
 * finger has a max_force and the wrench is not carried without grip, the least grip is 1/largest_load_factor. `holds`
 * is 0 with fails NaN where the wrench is carried without any grip, and NaN where no finger closes or presses, or where
 * neither 1 nor any of 2, 4, 8, ... up to 1e6 holds. Where the factors that hold make several intervals, it is the end
 * of the one that was found. Costs and returns as pinch_statics_limits does for one of its limits. For the least grip
 * by direction, call it with each wrench in turn.
 */
PINCH_API pinch_status pinch_statics_least_closing(pinch_statics *statics, const pinch_grasp *grasp,
                                                   const pinch_statics_settings *settings, pinch_static_limit *least);

/* Checks an answer from the grasp's own data, in newtons; nothing is shared with the model or the solvers. */
PINCH_API void pinch_statics_verify(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                                    const pinch_finger_result *fingers, const pinch_statics_result *result,
                                    pinch_static_verification *verification);

/*
 * Does the twist prove that no forces inside the (exact or linearized) friction limits balance the wrench? It does when
 * the wrench works against it and no contact force can work along it: true when forces that balanced nevertheless would
 * have to exceed 1e6 times the wrench.
 */
PINCH_API bool pinch_statics_proves_infeasible(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                                               const double twist[6]);

/* The ways to write the linearized grasp, formulation lcp, as a complementarity problem. */
typedef enum pinch_static_form {
    PINCH_FORM_MIXED = 0, /* (r_n, lambda, s, u), u free: exists for every such grasp */
    PINCH_FORM_CONDENSED, /* (r_n, lambda, s), u eliminated: W_t K_t W_t^T must be invertible */
    PINCH_FORM_SPLIT      /* (r_n, lambda, s, u+, u-): likewise; the paper's planar frictionless form */
} pinch_static_form;

/* Returns the number of unknowns of that form; 0 when it does not exist: for formulation coulomb, too, and where
 * pinch_statics_solve refuses the values or `statics` has no room for the facets. */
PINCH_API int pinch_statics_lcp_size(pinch_statics *statics, const pinch_grasp *grasp,
                                     const pinch_statics_settings *settings, pinch_static_form form);
/* Writes M[size^2], q[size], free[size] of that form, raw for `faithful` without `unit` and non-dimensional otherwise.
 * PINCH_INVALID_ARGUMENT where it does not exist. */
PINCH_API pinch_status pinch_statics_lcp(pinch_statics *statics, const pinch_grasp *grasp,
                                         const pinch_statics_settings *settings, pinch_static_form form, double *m,
                                         double *q, bool *free);

#ifdef __cplusplus
}
#endif
#endif
