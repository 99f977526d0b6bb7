/*
 * What a step depends on, archived store by store. Each function walks through one store, or one part of the world, for
 * writing and for reading alike (archive.h).
 */
#ifndef PINCH_SNAPSHOT_SNAPSHOT_H
#define PINCH_SNAPSHOT_SNAPSHOT_H

#include "contacts/near_pairs.h"
#include "islands/island_graph.h"
#include "islands/solver_pool.h"
#include "snapshot/archive.h"

/* snapshot_bodies.c: where the bodies and geoms of the parts are, and how they move. */
typedef struct pinch_world_state pinch_world_state;
/* Reading replaces *state, NULL at first, by a new one; writing takes no state, and reads the world. */
void pinch_archive_world(pinch_archive *a, pinch_world_state **state);
/* Puts all bodies and geoms of the parts into the state that was read. */
void pinch_restore_world(const pinch_ode_parts *parts, const pinch_world_state *state);
/* Has the spaces of the parts look at all geoms that have moved, in the world that was saved. */
void pinch_clean_spaces(const pinch_ode_parts *parts);
void pinch_world_state_free(pinch_world_state *state);

/* snapshot_contacts.c: geoms, materials, pairs with their manifolds, surfaces. For reading, the store has just been
 * initialized. `number` is that of the next step. */
void pinch_archive_contacts(pinch_archive *a, pinch_contact_store *store, long number);

/* snapshot_joints.c: what is known of joints beyond ODE's getters, servos, couplings. For reading,
 * both are all 0. */
void pinch_archive_joints(pinch_archive *a, pinch_joint_store *store, pinch_joint_poses *poses);

/* snapshot_last_step.c, behind the three others: the last step's contacts, islands and answers. */
void pinch_archive_last_step(pinch_archive *a, pinch_contact_store *contacts, pinch_island_graph *graph,
                             pinch_joint_store *joints, pinch_problem_buffers *kept);

/* snapshot_last_step.c, where nothing else is known of the last step: the forces that rows of joints begin with. */
void pinch_archive_row_forces(pinch_archive *a, pinch_joint_store *store);

/* snapshot_near.c: the order of geoms in the spaces of pinch_ode_each_pair. For reading, *near is all 0. */
void pinch_archive_near(pinch_archive *a, pinch_near_pairs *near);

/* snapshot_islands.c: drives, memories, spans of back-off. For reading, the graph is all 0. */
void pinch_archive_islands(pinch_archive *a, pinch_island_graph *graph);

#endif
