/*
 * What is done with an island in a step, file by file; README.md has the order. Functions that take an island touch
 * nothing of other islands, so that each island may be handled by a thread of its own, unless they say otherwise.
 */
#ifndef PINCH_ISLANDS_ISLAND_LIFE_H
#define PINCH_ISLANDS_ISLAND_LIFE_H

#include "islands/island_graph.h"
#include "islands/solver_pool.h"

/* Who shares the loops of an island: NULL for nobody. */
static inline const pinch_crew *pinch_crew_of(const pinch_solver_pool *pool, const pinch_island *island)
{
    return island->shared ? &pool->crew : NULL;
}

/* island_solve.c: fills in the island's problem, solves it, checks the answer, reads it out and gives the forces to the
 * bodies; or reuses the answer of the last step. */
void pinch_solve_island(const pinch_step_context *context, pinch_contact_store *contacts, pinch_island_graph *graph,
                        pinch_joint_store *joints, pinch_solver_pool *pool, int worker, pinch_island *island);
/* island_solve.c: takes the forces back in a step that is given up. */
void pinch_take_back_island_forces(const pinch_step_bodies *bodies, const pinch_island *island);

/* island_record.c, before the first solve: keeps the problem as it is where there is a recorder. */
void pinch_begin_recording(const pinch_step_context *context, pinch_solver_thread *thread, const pinch_problem *problem,
                           pinch_problem *before);
/* island_record.c, after that solve: shows the recorder what it asked for. `island` is a number. */
void pinch_end_recording(const pinch_step_context *context, int island, const pinch_solver_settings *solver,
                         const pinch_problem *before, const pinch_problem *after, const pinch_step_result *result);

/* island_contacts.c: fills in the contacts of a problem from the manifolds of the island's pairs. */
void pinch_fill_contacts(const pinch_step_context *context, const pinch_contact_store *contacts,
                         const pinch_step_bodies *bodies, const pinch_island *island, pinch_problem *problem);

/* drive_limits.c: adds rows that bound the speed of driven fingers, of those whose contacts do not bear the force at
 * hand or of all, behind the rows of joints. */
void pinch_limit_drives(const pinch_contact_store *contacts, const pinch_step_bodies *bodies, pinch_island *island,
                        bool all, pinch_problem *problem);
/* drive_limits.c: tells whether a driven finger goes farther in an answer than it, or what it touches, is large, or
 * whether an island with one has no answer. */
bool pinch_drives_run_away(const pinch_contact_store *contacts, const pinch_step_bodies *bodies,
                           const pinch_island *island, const pinch_problem *problem);
/* drive_limits.c: how many of these fingers went as fast as they may, in an answer. */
int pinch_drives_at_limit(const pinch_island *island, const pinch_problem *problem);

/* rest.c, before ODE's step: tells whether nothing has moved in the step but for rounding. To be asked before the
 * answer is read out. */
bool pinch_island_at_rest(const pinch_step_context *context, const pinch_contact_store *contacts,
                          const pinch_step_bodies *bodies, const pinch_island *island, const pinch_problem *problem);
/* rest.c: makes an answer that of rest: all velocities are zero, elastic states stay, and the steps for which floors
 * are to stay do not count. */
void pinch_make_steady(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem);
/* rest.c: gives the bodies, in place of their forces, those that balance gravity, and notes how they rest. */
void pinch_balance_gravity(const pinch_step_context *context, const pinch_step_bodies *bodies,
                           const pinch_island *island);
/* rest.c: sets the bodies' velocities to zero. Only one thread at a time may call this. */
void pinch_stop_bodies(const pinch_step_bodies *bodies, const pinch_island *island);
/* rest.c: tells whether an island that rested in the last step is as it was then. */
bool pinch_island_unchanged(const pinch_step_context *context, const pinch_contact_store *contacts,
                            const pinch_step_bodies *bodies, pinch_joint_store *joints, pinch_problem_buffers *buffers,
                            pinch_island *island);
/* rest.c: gives ODE the answer of the last step again. */
void pinch_reuse_answer(const pinch_step_context *context, const pinch_step_bodies *bodies,
                        const pinch_joint_store *joints, pinch_island *island);
/* rest.c: enables the bodies again that ODE was to skip. */
void pinch_reenable_bodies(const pinch_step_bodies *bodies, pinch_island *island);
/* rest.c, after ODE's step: tells whether all bodies stand still. */
bool pinch_island_stands(const pinch_step_bodies *bodies, const pinch_island *island);
/* rest.c, after ODE's step of a resting island: replaces orientations that rounding would move in every step. Only one
 * thread at a time may call this. */
void pinch_steady_orientations(const pinch_step_context *context, const pinch_step_bodies *bodies,
                               const pinch_island *island);

/* budget.c: the budget of a solve of the island, for pinch_solver_settings; it depends on what ODE takes, and where
 * sweeps can take over is smaller when the island went wrong not long ago. */
double pinch_budget_of(const pinch_step_context *context, const pinch_island *island, bool again);
/* budget.c: tells whether sweeps take over where a solve goes over its budget: the program steps by dWorldQuickStep,
 * and all bodies are free. */
bool pinch_island_may_be_swept(const pinch_step_context *context, const pinch_island *island);
/* budget.c, after a solve: tells whether sweeps would have done as well in less time. */
bool pinch_solve_was_dear(const pinch_step_context *context, const pinch_island *island);

/* backoff.c: tells whether the island is swept, or goes to ODE, without a try, because it went wrong not long ago. */
bool pinch_backoff_holds(const pinch_step_context *context, const pinch_island_graph *graph,
                         const pinch_island *island);
/* backoff.c: tells whether the island, or one with bodies of it, went wrong not long ago. */
bool pinch_went_wrong_lately(const pinch_step_context *context, const pinch_island_graph *graph,
                             const pinch_island *island);
/* backoff.c, after ODE's step: has an island that went wrong be swept or left to ODE for a while. Only one thread at a
 * time may call this. */
void pinch_judge_fallback(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island,
                          pinch_ode_stats *stats);

/* energy_account.c, before the first solve: sets what the island's joints may put in, and the pace of their closing. */
void pinch_open_account(const pinch_step_context *context, const pinch_island_graph *graph,
                        const pinch_joint_store *joints, const pinch_problem *problem, pinch_island *island);
/* energy_account.c, after a solve in which contacts gave way to joints: these have no more than was in the account. */
void pinch_close_overdraft(pinch_island_joints *joints);
/* energy_account.c: returns the energy (J) that an island's joints may put in in this step. */
double pinch_joints_may_put_in(const pinch_island_joints *joints);
/* energy_account.c: tells whether joints may take all errors of their position back at once, as ODE does, because next
 * to no energy comes of it. */
bool pinch_errors_are_small(const pinch_step_context *context, const pinch_joint_store *joints,
                            const pinch_island *island, const pinch_problem *problem);
/* energy_account.c, of an island that goes to ODE: sets the pace at which ODE may take errors of its joints back. */
void pinch_open_fallback_account(const pinch_step_context *context, const pinch_island_graph *graph,
                                 const pinch_joint_store *joints, pinch_island *island);
/* energy_account.c, after ODE's step: keeps what is left of it. Only one thread at a time may call this. */
void pinch_keep_account(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island);

/* energy_account.c: finds what hard contacts may put into the island's bodies because they have taken it out, and the
 * pace that is known of the last step, where they had to be slowed; 1: they had not. */
void pinch_read_push(const pinch_step_context *context, const pinch_island_graph *graph, pinch_island *island);

/* push_out.c, before the first solve: sets how much energy hard contacts may put in as they push bodies out of each
 * other, and finds how fast each pushes. Returns false where there are none, and where memory runs out, which is the
 * island's status then. */
bool pinch_open_push(const pinch_step_context *context, const pinch_contact_store *contacts,
                     const pinch_island_graph *graph, const pinch_problem *problem, pinch_rise *rise,
                     pinch_island *island);
/* push_out.c, after a solve: finds out how much they have put in. */
void pinch_judge_push(const pinch_step_context *context, const pinch_contact_store *contacts,
                      const pinch_joint_store *joints, const pinch_step_bodies *bodies, const pinch_problem *problem,
                      pinch_rise *rise, pinch_island *island);
/* push_out.c, after the last solve, with contacts at this pace: sets what is left, and the next pace. */
void pinch_close_push(const pinch_step_context *context, const pinch_problem *problem, double pace,
                      pinch_island *island);
/* read_out.c: writes the results of an island's contacts, and adds them up for the bodies. */
void pinch_read_out_contacts(const pinch_contact_store *contacts, const pinch_step_bodies *bodies, pinch_island *island,
                             const pinch_problem *problem);
/* read_out.c: leaves an island without an answer: its results say whose points they are, and no force. */
void pinch_leave_unsolved(pinch_contact_store *contacts, pinch_island *island);

/* rise.c: finds the acceleration that presses the bodies down, and the direction against it: gravity, or where the
 * world has none, what acts on all of them. */
void pinch_find_up(const pinch_step_context *context, const pinch_problem *problem, pinch_rise *rise);
/* rise.c, when it is known how fast each of an island's pairs pushes: finds the paces at which contacts push so that
 * what lies on each other does not come up too fast. */
void pinch_limit_rise(const pinch_problem *problem, int pairs, pinch_rise *rise);
/* push_out.c: scales the velocities at which hard contacts push bodies out, beside their own paces, and bounce. */
void pinch_slow_push_out(const pinch_contact_store *contacts, const pinch_island *island, const pinch_rise *rise,
                         double pace, double bounce, pinch_problem *problem);
/* push_out.c: notes the forces by which contacts bounced in an answer, and tells whether any did. These gave way to
 * them by a floor of compliance, and the bounce fell short by that. */
bool pinch_bounces_fall_short(const pinch_contact_store *contacts, const pinch_island *island,
                              const pinch_problem *problem);
/* push_out.c: lets contacts, as they came, bounce by so much faster as they then gave way more than is prescribed.
 * Returns whether any does. */
bool pinch_bounce_in_full(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem);
/* push_out.c: returns what contacts may put in (J) before partners that drive bodies on are held back. */
double pinch_most_of_partners(const pinch_island *island);
/* push_out.c: lets contacts that drive bodies on, as they came, do so at this part of their velocity. */
void pinch_slow_partners(const pinch_contact_store *contacts, const pinch_island *island, double pace,
                         pinch_problem *problem);
/* push_out.c: hard contacts forget their springs of friction, and surfaces that move along them stand still. */
void pinch_let_go(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem);

/* ode_fallback.c: makes the island's points contact joints of ODE's for this step. Only one thread at a time may call
 * this. Returns false when memory runs out. */
bool pinch_solve_island_by_ode(const pinch_step_context *context, pinch_contact_store *contacts,
                               pinch_island_graph *graph, pinch_solver_pool *pool, pinch_ode_stats *stats,
                               const pinch_island *island);
/* ode_fallback.c, after ODE's step: reads the forces that ODE found for these points. */
void pinch_read_fallback_contacts(pinch_contact_store *contacts, const pinch_island_graph *graph);

/* joint_fallback.c: returns the velocity that gravity adds in a step, or a small one where there is next to none. */
double pinch_fall_in_step(const pinch_step_context *context);
/* joint_fallback.c: tells whether the island has to be left to ODE, because ODE solves its joints too coarsely. To be
 * asked when it has been given its forces. */
bool pinch_joint_fallback_needed(const pinch_step_context *context, const pinch_step_bodies *bodies,
                                 const pinch_island *island);
/* joint_fallback.c, after ODE's step: tells whether the step has shown that the island's joints are better left to ODE
 * for a while. */
bool pinch_joints_went_wrong(const pinch_step_context *context, const pinch_step_bodies *bodies,
                             const pinch_island *island);

/* motion.c, before ODE's step: finds which of the island's bodies, and of the kinematic ones that belong to it, Pinch
 * may move by itself, and disables them until ODE has stepped. */
void pinch_set_bodies_aside(const pinch_step_context *context, pinch_island_graph *graph, pinch_island *island);
/* motion.c, after ODE's step: enables these bodies again and, where `moves`, moves them. */
void pinch_move_bodies(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island,
                       const pinch_crew *crew, bool moves);
/* motion.c: does the same with kinematic bodies that several islands touch. To be called before the islands' threads
 * look at them. */
void pinch_move_shared_bodies(const pinch_step_context *context, const pinch_island_graph *graph, bool moves);
/* motion.c: tells the geoms of all of them; `ahead`: those of the next islands are asked for before they are needed.
 * Only one thread at a time may call this, as geoms share their spaces. */
void pinch_tell_geoms_of_islands(const pinch_island_graph *graph, bool ahead);

/* history.c, after ODE's step: puts driven bodies back to the motion that their owner prescribed. */
void pinch_stop_drives(const pinch_step_bodies *bodies, const pinch_island *island);
/* history.c, after ODE's step: carries bodies and contacts on into the next step. */
void pinch_carry_history(const pinch_step_context *context, pinch_contact_store *contacts,
                         const pinch_step_bodies *bodies, pinch_island *island, const pinch_crew *crew);

/* energy.c: as pinch_ode_contact_energy, for problems that were kept. */
void pinch_contact_energy(const pinch_island_graph *graph, const pinch_contact_store *contacts,
                          const pinch_problem_buffers *kept, double h, pinch_ode_energy *energy);

#endif
