#ifndef PINCH_STATICS_FLOW_H
#define PINCH_STATICS_FLOW_H

#include "statics/model.h"

/* How the object ends up when it is let go. */
typedef enum pinch_flow_outcome {
    PINCH_FLOW_SETTLED,  /* in equilibrium */
    PINCH_FLOW_ESCAPED,  /* moving on without end */
    PINCH_FLOW_UNDECIDED /* neither within the steps allowed */
} pinch_flow_outcome;

/*
 * R(u) = 0 (model->alpha is set to 0) by the method of the settings, NSNMGK with Newton steps unless another was asked
 * for, in at most `iterations`. On convergence u[freedoms] is the root and true is returned; otherwise u is as it was.
 * Counts are added to `total`, whose residual is that of the last point.
 *
 * A bare method (newton, nsnmgk without its Newton finish) has the settings' own max_iterations instead, and the flow
 * does nothing.
 */
bool pinch_static_newton(pinch_static_model *model, const pinch_solver_settings *settings, int iterations, double *u,
                         pinch_solver_result *total);

/* The same for F with the flow's term as the model has it, to `tolerance`. */
bool pinch_static_newton_with_term(pinch_static_model *model, const pinch_solver_settings *settings, double tolerance,
                                   int iterations, double *u, pinch_solver_result *total);

/* Newton steps that a load step may take before it counts as too long. */
enum { PINCH_STATIC_LOAD_NEWTON_STEPS = 12 };

/*
 * R(u) - tiny (u - start) = 0 by Newton from *at. Where the fingers leave the object free to move, R alone does not say
 * where it is, and Newton's steps there are rounding over nothing; the tiny term says that it stays where it was. A
 * slide that nothing stops would let the term carry what the fingers cannot: while it carries more than the tolerance
 * it is taken anew about the answer, which an equilibrium ends at once, and after some rounds there is none.
 */
bool pinch_static_follow(pinch_static_model *model, const pinch_solver_settings *settings, const double *start,
                         double *at, pinch_solver_result *total);

/* Was a bare method asked for? Then it stands alone, with all the iterations it may have and no flow behind it. */
bool pinch_static_is_bare(const pinch_solver_settings *settings);

/* Finds the softest and the stiffest of the fingers' linear springs. */
void pinch_static_stiffness_range(const pinch_static_model *model, double *least, double *largest);

/*
 * Lets the object go at u with viscosity in place of inertia: implicit steps of  alpha K_ref du/dt = R(u). With
 * `history` the slip of each step is kept (pinch_static_commit), and the flow is what a slow motion does; without, all
 * slip counts from the undeformed state. Where it escapes, u is where it had got to and direction[freedoms] the way it
 * went. shrink in (0, 1): what alpha is multiplied by after a step that was solved.
 */
pinch_flow_outcome pinch_static_flow(pinch_static_model *model, const pinch_solver_settings *settings, bool history,
                                     double shrink, double *u, double *direction, pinch_solver_result *total);

/* A load that grows while the object moves: *factor goes from where it is to goal, by per_step of goal a step. */
typedef struct pinch_static_ramp {
    double *factor;
    double goal, per_step;
    bool whole; /* from nothing: its root grows in this way, and rest counts only once the goal is reached */
} pinch_static_ramp;

/*
 * Lets the object go at u as it would move: implicit steps of  M d2u/dt2 = R(u)  from rest, slip kept, under a load
 * that goes on growing. M is that of a body whose mass is spread as far out as its radius, `mass` times the softest
 * spring over the time step squared: 10 swings, the steps' own damping being all there is, and 0.1 creeps. Settled: at
 * rest again at *factor, the slip of the last bit not committed; escaped: as for the flow.
 */
pinch_flow_outcome pinch_static_motion(pinch_static_model *model, const pinch_solver_settings *settings,
                                       const pinch_static_ramp *ramp, double mass, double *u, double *direction,
                                       pinch_solver_result *total);

/*
 * Settles gently from u by implicit steps of the flow that keep their slip, slowly until the object has all but come to
 * rest, and by Newton for what is left. Where several equilibria could be reached this finds the one a slow motion
 * does. Returns false when it did not settle; u and the contacts' rest are then unspecified.
 */
bool pinch_static_settle(pinch_static_model *model, const pinch_solver_settings *settings, double *u,
                         pinch_solver_result *total);

/*
 * Finds the one-step answer, with everything applied at once from the undeformed state. It tries Newton from u = 0, the
 * flow from u = 0, the flow with other shrink factors, and both from other starts; without `thorough` only the first
 * two.
 */
pinch_flow_outcome pinch_static_one_step(pinch_static_model *model, const pinch_solver_settings *settings, double *u,
                                         bool thorough, double *direction, pinch_solver_result *total);

/*
 * Takes closing and prescribed normal forces from 0 to 1 and then the wrench from 0 to 1, in load steps as long as the
 * settings' path_tolerance allows. *fraction is the part of the wrench that was reached. On success the last load
 * step's slip is not committed yet: u is to be refined and read against the rest it started from.
 */
pinch_flow_outcome pinch_static_path(pinch_static_model *model, const pinch_statics_settings *settings, double *u,
                                     double *fraction, double *direction, pinch_solver_result *total);

/* Is the reduced system in u what is solved, rather than a complementarity problem? */
bool pinch_static_uses_displacements(const pinch_statics_settings *settings);

/*
 * Takes the path or the one step, whichever the settings ask for. The outcome is undecided where
 * model->work_left runs out. *fraction is NaN where one step did not settle.
 */
pinch_flow_outcome pinch_static_search(pinch_static_model *model, const pinch_statics_settings *settings, bool thorough,
                                       double *u, double *fraction, double *escape, pinch_solver_result *total);

#endif
