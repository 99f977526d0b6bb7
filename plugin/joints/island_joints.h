/*
 * The joints of one island in a step: their rows before its solve, whether these held after it, and their forces.
 *
 * Where every row that acts on an island's bodies is known in full, its multipliers are what ODE would have to find
 * once more. The joints' forces then go to the bodies with the contact forces, the joints are disabled while ODE steps,
 * and ODE integrates. The program finds its joints as it left them, with the forces where it asked for them
 * (dJointSetFeedback).
 */
#ifndef PINCH_JOINTS_ISLAND_JOINTS_H
#define PINCH_JOINTS_ISLAND_JOINTS_H

#include "joints/joint_rows.h"
#include "joints/joint_store.h"

/* Fills in the rows of the joints. What motors add by themselves goes to the bodies' external forces. */
void pinch_fill_joints(pinch_joint_store *store, const pinch_step_context *context, const pinch_step_bodies *bodies,
                       pinch_island_joints *joints, pinch_problem *problem);
/* joint_loops.c: tells whether joints tie bodies into a loop, the world being one of them; two joints of the same
 * bodies do. Motors alone keep nothing in its place, and so they close none. range: the island's bodies. */
bool pinch_joints_close_loops(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                              pinch_island_joints *joints);
/* joint_loops.c: finds the mechanisms of an island: bodies that joints tie together, directly or by other bodies, but
 * not by the world. pinch_mechanism_of then tells that of a body, by the number of one of them, until another function
 * uses the bodies' `carrier`. */
void pinch_find_mechanisms(const pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                           const pinch_island_joints *joints);
int pinch_mechanism_of(const pinch_step_bodies *bodies, pinch_range range, int local);
/* joint_energy.c: may the row put energy in, as motors and springs do? */
bool pinch_row_may_drive(const pinch_joint_row *row);
/* joint_energy.c: returns what an answer adds to the kinetic energy of an island's bodies (J), but for what their
 * weight and other external forces do as bodies move by v+. range: these bodies. *lag: what is to be added where they
 * are taken to move by the mean of v and v+. */
double pinch_kinetic_gain(const pinch_step_bodies *bodies, pinch_range range, const pinch_problem *problem,
                          double *lag);
/* joint_energy.c: returns the work (J) of contacts by the velocities at the end of a step, but for what their surfaces
 * do that move by themselves. */
double pinch_contact_work(const pinch_problem *problem);
/* joint_energy.c: returns the work (J, < 0) of a motor that drives with all its force and is pushed back all the same,
 * or of a spring that is pushed back; 0 for other rows. */
double pinch_work_taken_by_drive(const pinch_problem *problem, const pinch_joint_row *row);
/* joint_energy.c: returns the work (J) of joints and stops in a step that has been solved and not yet made, as far as
 * it is not that of motors and springs. range: the island's bodies. */
double pinch_joint_work(const pinch_joint_store *store, const pinch_island_joints *joints,
                        const pinch_step_bodies *bodies, pinch_range range, const pinch_problem *problem);
/* joint_energy.c: returns the sum of the weights (N) of a problem's bodies, and of what else presses them from outside.
 */
double pinch_weight_of_all(const pinch_problem *problem);
/* joint_energy.c: tells whether a body is accelerated by more than its weight would in an answer. fall: the velocity
 * that gravity adds in a step, m/s. */
bool pinch_body_is_thrown(dBodyID body, const pinch_body *solved, double fall);
/* joint_energy.c: returns the work (J) that joints may do besides in such a step, as what comes back has to be lifted.
 * fall: the velocity that gravity adds in a step, m/s. */
double pinch_joint_lifting(const pinch_joint_store *store, const pinch_island_joints *joints,
                           const pinch_step_bodies *bodies, const pinch_problem *problem, bool loops, double fall);
/* joint_energy.c: returns the work (J) by which errors of position are taken back in a step as ODE asks for, against
 * the weight of all bodies, or against the forces of an answer where these are more; not where `jammed`, as forces may
 * cancel each other there. 0 where rows contradict each other. */
double pinch_work_of_closing(const pinch_joint_store *store, const pinch_island_joints *joints,
                             const pinch_problem *problem, bool jammed);
/* joint_energy.c: returns the kinetic energy (J) that the bodies of a problem have beside their common motion, before
 * forces of rows and contacts act. */
double pinch_energy_in_motion(const pinch_problem *problem);
/* joint_energy.c: returns the energy (J) of bodies that move as the errors of their joints ask for, each by itself. */
double pinch_energy_of_errors(const pinch_joint_store *store, const pinch_island_joints *joints,
                              const pinch_problem *problem);
/* joint_energy.c: changes the pace at which errors of position are taken back, from one multiple of what ODE asks for
 * to another. */
void pinch_set_closing_pace(const pinch_joint_store *store, const pinch_island_joints *joints, pinch_problem *problem,
                            double from, double to);
/* joint_pace.c, before ODE's step: has ODE take errors of these joints back at their pace, where they have an ERP of
 * their own; the others have the world's. */
void pinch_slow_ode_joints(const pinch_joint_store *store, const pinch_island_joints *joints);
/* joint_pace.c: gives them their ERP back after that step. */
void pinch_restore_ode_joints(const pinch_joint_store *store, const pinch_island_joints *joints);
/* Sums up the forces of each joint of an island that has been solved and verified. Where ODE decides how rows that
 * depend on each other share what they carry, the rows do not hold for it, and there are no sums. */
void pinch_read_joints(pinch_joint_store *store, pinch_island_joints *joints, const pinch_problem *problem);
/*
 * Where rows contradict each other, or bodies are jammed, forces are huge and cancel, and their rounding would move the
 * bodies. This gives each body what all its joints exert together, from the velocity solved for, with the first of
 * them. Where contacts_round, bodies without joints get what their contacts exert in the same way. To be called when
 * the bodies' wrenches are those of the contacts. range: the island's bodies.
 */
void pinch_share_joint_forces(pinch_joint_store *store, const pinch_step_bodies *bodies, pinch_range range,
                              pinch_island_joints *joints, const pinch_problem *problem, bool contacts_round);
/* Returns a checksum of what the joints demand: their rows, and what motors apply that run into their stops. */
uint64_t pinch_joint_bits(const pinch_island_joints *joints, const pinch_problem *problem);
/* joint_inputs.c: computes a checksum of all that the joints' rows depend on, beside the world's values and the poses
 * of the island's bodies, whose velocities are zero, and finds out whether the joints are `apart`. Returns false where
 * that cannot be told. */
bool pinch_joint_inputs(pinch_joint_store *store, pinch_island_joints *joints, uint64_t *sum);
/* joint_inputs.c: keeps it of an island whose rows have just been filled in, in rest_inputs. */
void pinch_remember_joint_inputs(pinch_joint_store *store, pinch_island_joints *joints);

/* Gives the forces of the joints of a solved island to its bodies, where all of them are known. range: its bodies.
 * `problem` is that of the island with its solution; NULL where it is no longer there: rows of couplings are computed
 * again then. */
void pinch_give_joint_forces(pinch_joint_store *store, const pinch_step_context *context,
                             const pinch_step_bodies *bodies, pinch_range range, pinch_island_joints *joints,
                             const pinch_problem *problem);
/* Gives the feedback of an island whose answer is reused, and disables its joints. Where its bodies are disabled, ODE
 * comes to a joint from a kinematic body alone: others need not be disabled then. */
void pinch_reuse_joints(const pinch_joint_store *store, pinch_island_joints *joints, bool bodies_disabled);
/* Enables the joints again after ODE's step. */
void pinch_enable_joints(const pinch_joint_store *store, const pinch_island_joints *joints);

#endif
