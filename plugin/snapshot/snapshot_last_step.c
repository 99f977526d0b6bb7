/*
 * The last step: contacts as they were handed over, islands and their answers. Where nothing has changed, the next step
 * goes on with all of it instead of solving anew.
 */
#include "contacts/contact_buffer.h"
#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

#include <stddef.h>

/* Bytes that an archive has at least for one of each. */
enum {
    BUFFERED_BYTES = 70,
    DIRECTION_BYTES = 24,
    RESULT_BYTES = 100,
    ISLAND_BYTES = 100,
    BODY_BYTES = 100,
    STEP_JOINT_BYTES = 100,
    HANDLE_BYTES = 4
};

static void archive_range(pinch_archive *a, pinch_range *range, int end)
{
    pinch_archive_count(a, &range->first, 1, end);
    pinch_archive_count(a, &range->count, 1, end - range->first);
}

/* A list of places, whose count its own list does not keep. */
static void archive_places(pinch_archive *a, void **items, int *room, int count, int end)
{
    if (a->reading && !pinch_list_reserve(items, room, count + 1, sizeof(int)))
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    for (int i = 0; i < count && a->status == PINCH_OK; i++) pinch_archive_place(a, (int *)*items + i, end, false);
}
#define ARCHIVE_PLACES(a, list, count, end) archive_places((a), (void **)&(list).items, &(list).room, (count), (end))

/* ---- contacts ---- */

static void archive_buffered(pinch_archive *a, const pinch_contact_store *store, pinch_buffered_contact *c)
{
    PINCH_ARCHIVE(a, c->found);
    pinch_archive_place(a, &c->pair, store->pairs.count, false);
    pinch_archive_place(a, &c->surface, store->surfaces.count, true);
    pinch_archive_place(a, &c->direction, store->directions_before, true);
    pinch_archive_flag(a, &c->swapped);
    if (a->reading) c->next = c->joint = -1; /* of this step when it is handed over again */
}

/* Each pair finds its contacts of the last step, in their order. */
static void link_buffered(pinch_contact_store *store)
{
    for (int i = 0; i < store->pairs.count; i++) store->pairs.items[i].first_buffered = -1;
    pinch_chain_contacts(store, store->buffered_before);
}

/* The buffer is empty between steps, and its items are still those of the last one, if their number is known. */
static void archive_buffer(pinch_archive *a, pinch_contact_store *store)
{
    bool known = store->buffered_before >= 0;
    pinch_archive_flag(a, &known);
    if (a->reading) store->same_places = store->same_bodies = store->unchanged = true; /* as after a step */
    if (!known) return;
    if (a->reading) store->buffered_before = store->directions_before = 0;
    pinch_archive_count(a, &store->buffered_before, BUFFERED_BYTES, 1 << 28);
    pinch_archive_count(a, &store->directions_before, DIRECTION_BYTES, 1 << 28);
    if (a->reading && !(PINCH_RESERVE(store->buffer, store->buffered_before) &&
                        PINCH_RESERVE(store->directions, store->directions_before)))
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    for (int i = 0; i < store->buffered_before && a->status == PINCH_OK; i++)
        archive_buffered(a, store, &store->buffer.items[i]);
    for (int i = 0; i < store->directions_before && a->status == PINCH_OK; i++)
        PINCH_ARCHIVE(a, store->directions.items[i].tangent);
    if (a->reading && a->status == PINCH_OK) link_buffered(store);
}

static void archive_result(pinch_archive *a, pinch_ode_contact *c)
{
    size_t numbers = offsetof(pinch_ode_contact, position);
    pinch_archive_geom(a, &c->geom1, true);
    pinch_archive_geom(a, &c->geom2, true);
    pinch_archive_body(a, &c->body1, true);
    pinch_archive_body(a, &c->body2, true);
    pinch_archive_bytes(a, (unsigned char *)c + numbers, offsetof(pinch_ode_contact, state) - numbers);
    PINCH_ARCHIVE(a, c->state);
}

static void archive_whether_it_moves(pinch_archive *a, int *step_body)
{
    bool moves = *step_body >= 0;
    pinch_archive_flag(a, &moves);
    if (a->reading) *step_body = moves ? 0 : PINCH_NOT_A_STEP_BODY;
}

/* What a pair has of the step: where its points are in the lists. */
static void archive_pair_of_step(pinch_archive *a, pinch_pair *pair, const pinch_island_graph *graph, int results)
{
    PINCH_ARCHIVE(a, pair->buffered_count);
    PINCH_ARCHIVE(a, pair->points_when_built);
    PINCH_ARCHIVE(a, pair->watched);
    int points = pair->manifold.count;
    if (points < PINCH_MANIFOLD_POINTS && pair->watched >> points) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (pair->manifold.count == 0) { /* it belongs to no island, and has had no bodies in this step */
        for (int side = 0; side < 2; side++) archive_whether_it_moves(a, &pair->step_body[side]);
        return;
    }
    for (int side = 0; side < 2; side++) pinch_archive_place(a, &pair->step_body[side], graph->bodies.count, true);
    pinch_archive_place(a, &pair->island, graph->count, false);
    pinch_archive_count(a, &pair->first_result, 1, results - pair->manifold.count);
    pinch_archive_count(a, &pair->first_in_island, 1, results - pair->manifold.count);
}

static void archive_contacts_of_step(pinch_archive *a, pinch_contact_store *store, const pinch_island_graph *graph)
{
    int with_points = 0;
    archive_buffer(a, store);
    for (int i = 0; i < store->results.count; i++) archive_result(a, &store->results.items[i]);
    for (int i = 0; i < store->pairs.count && a->status == PINCH_OK; i++) {
        archive_pair_of_step(a, &store->pairs.items[i], graph, store->results.count);
        with_points += store->pairs.items[i].manifold.count > 0;
    }
    ARCHIVE_PLACES(a, store->pairs_by_island, with_points, store->pairs.count);
}

/* ---- joints ---- */

static void archive_forces(pinch_archive *a, pinch_step_joint *j)
{
    pinch_archive_count(a, &j->forces.count, sizeof(double), PINCH_JOINT_MAX_ROWS);
    for (int k = 0; k < j->forces.count; k++) PINCH_ARCHIVE(a, j->forces.force[k]);
    if (a->reading) j->forces.joint = j->joint;
}

void pinch_archive_row_forces(pinch_archive *a, pinch_joint_store *store)
{
    PINCH_ARCHIVE_LIST(a, *store, HANDLE_BYTES);
    for (int i = 0; i < store->count && a->status == PINCH_OK; i++) {
        pinch_archive_old_joint(a, &store->items[i].joint);
        archive_forces(a, &store->items[i]);
    }
}

static void archive_step_joint(pinch_archive *a, pinch_step_joint *j, const pinch_joint_store *store, int bodies)
{
    pinch_archive_joint(a, &j->joint);
    for (int side = 0; side < 2; side++) pinch_archive_place(a, &j->body[side], bodies, true);
    pinch_archive_place(a, &j->reference, store->references.count, true);
    pinch_archive_flag(a, &j->exact);
    pinch_archive_flag(a, &j->found);
    archive_range(a, &j->rows, store->row_room);
    PINCH_ARCHIVE(a, j->closing);
    archive_forces(a, j);
    pinch_archive_count(a, &j->servo_rows, 1, PINCH_JOINT_AXES);
    pinch_archive_flag(a, &j->motors_add_wrench);
    PINCH_ARCHIVE(a, j->wrench);
    PINCH_ARCHIVE(a, j->given);
}

/* How many joints and couplings the islands have. */
static void count_ranges(const pinch_island_graph *graph, int *joints, int *couplings)
{
    *joints = *couplings = 0;
    for (int k = 0; k < graph->count; k++) {
        *joints += graph->items[k].joints.range.count;
        *couplings += graph->items[k].joints.couplings.count;
    }
}

static void archive_joints_of_step(pinch_archive *a, pinch_joint_store *store, const pinch_island_graph *graph)
{
    int joints, couplings;
    count_ranges(graph, &joints, &couplings);
    for (int i = 0; i < store->count; i++) archive_step_joint(a, &store->items[i], store, graph->bodies.count);
    pinch_archive_index(a, &store->index, PINCH_ITEM_KEYS(*store, pinch_step_joint, joint), store->count);
    if (joints > store->count || couplings > store->couplings.count) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    ARCHIVE_PLACES(a, store->by_island, joints, store->count);
    ARCHIVE_PLACES(a, store->couplings.by_island, couplings, store->couplings.count);
    for (int i = 0; i < store->attached.count; i++) /* compared; contact joints of the step are gone */
        pinch_archive_old_joint(a, &store->attached.items[i].joint);
    pinch_archive_flag(a, &store->all_modelled);
    for (int k = 0; k < store->couplings.count && a->status == PINCH_OK; k++) {
        pinch_coupling *c = &store->couplings.items[k];
        pinch_archive_flag(a, &c->acts);
        pinch_archive_place(a, &c->body, graph->bodies.count, true);
        archive_range(a, &c->rows, store->row_room);
    }
    if (a->reading) store->couplings.changed = false;
}

/* ---- islands ---- */

static void archive_body(pinch_archive *a, pinch_step_body *b, const pinch_island_graph *graph,
                         const pinch_joint_store *joints)
{
    pinch_archive_body(a, &b->body, false);
    pinch_archive_place(a, &b->drive, graph->bodies.drives.count, true);
    pinch_archive_place(a, &b->parent, graph->count, false);
    pinch_archive_place(a, &b->local, graph->bodies.count, false);
    pinch_archive_count(a, &b->first_joint, 1, joints->attached.count);
    pinch_archive_count(a, &b->joint_count, 1, joints->attached.count - b->first_joint);
    PINCH_ARCHIVE(a, b->position);
    PINCH_ARCHIVE(a, b->wrench);
    PINCH_ARCHIVE(a, b->velocity);
    PINCH_ARCHIVE(a, b->rest_bits);
}

static void archive_result_of_solve(pinch_archive *a, pinch_step_result *r)
{
    PINCH_ARCHIVE(a, r->solve.status);
    PINCH_ARCHIVE(a, r->solve.iterations);
    PINCH_ARCHIVE(a, r->solve.projections);
    PINCH_ARCHIVE(a, r->solve.newton_steps);
    PINCH_ARCHIVE(a, r->solve.residual);
    PINCH_ARCHIVE(a, r->unknowns);
    pinch_archive_flag(a, &r->over_budget);
    pinch_archive_flag(a, &r->swept);
    PINCH_ARCHIVE(a, r->dependent_rows);
    PINCH_ARCHIVE(a, r->residual_max);
    PINCH_ARCHIVE(a, r->cone);
    PINCH_ARCHIVE(a, r->complementarity);
    PINCH_ARCHIVE(a, r->slip_direction);
    PINCH_ARCHIVE(a, r->row_velocity);
    PINCH_ARCHIVE(a, r->row_force);
    PINCH_ARCHIVE(a, r->force_scale);
    PINCH_ARCHIVE(a, r->floor_level);
    PINCH_ARCHIVE(a, r->floor_depth);
    PINCH_ARCHIVE(a, r->floor_residual);
    pinch_archive_flag(a, &r->too_soft);
}

static void archive_island_joints(pinch_archive *a, pinch_island_joints *j, const pinch_joint_store *store)
{
    archive_range(a, &j->range, store->count);
    archive_range(a, &j->couplings, store->couplings.count);
    archive_range(a, &j->room, store->row_room);
    pinch_archive_count(a, &j->row_count, 1, j->room.count);
    pinch_archive_count(a, &j->joint_rows, 1, j->room.count);
    pinch_archive_flag(a, &j->includes_couplings);
    pinch_archive_flag(a, &j->rows_hold);
    pinch_archive_flag(a, &j->put_energy_in);
    pinch_archive_flag(a, &j->by_pinch);
    PINCH_ARCHIVE(a, j->error);
    PINCH_ARCHIVE(a, j->error_angle);
    PINCH_ARCHIVE(a, j->applied_bits);
    PINCH_ARCHIVE(a, j->rest_bits);
    if (a->reading) j->inputs_known = j->loops_known = false;
}

static void archive_island(pinch_archive *a, pinch_island *island, const pinch_island_graph *graph,
                           const pinch_joint_store *joints, const pinch_contact_store *contacts)
{
    archive_range(a, &island->bodies, graph->bodies.count);
    archive_range(a, &island->pairs, contacts->pairs.count);
    archive_range(a, &island->contacts, contacts->results.count);
    archive_island_joints(a, &island->joints, joints);
    PINCH_ARCHIVE(a, island->phase);
    if ((unsigned)island->phase > PINCH_ISLAND_REUSED) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    PINCH_ARCHIVE(a, island->status);
    pinch_archive_flag(a, &island->may_sleep);
    pinch_archive_flag(a, &island->tried);
    pinch_archive_flag(a, &island->first_solve_failed);
    pinch_archive_count(a, &island->drive_rows, 1, island->joints.room.count - island->joints.row_count);
    PINCH_ARCHIVE(a, island->drives_at_limit);
    PINCH_ARCHIVE(a, island->mismatch);
    PINCH_ARCHIVE(a, island->depth_max);
    archive_result_of_solve(a, &island->result);
}

/* The lists' counts come before all else: they are the bounds of the places in them. */
static void archive_counts(pinch_archive *a, pinch_contact_store *contacts, pinch_island_graph *graph,
                           pinch_joint_store *joints)
{
    PINCH_ARCHIVE_LIST(a, contacts->results, RESULT_BYTES);
    PINCH_ARCHIVE_LIST(a, *joints, STEP_JOINT_BYTES);
    PINCH_ARCHIVE_LIST(a, joints->attached, HANDLE_BYTES);
    PINCH_ARCHIVE_LIST(a, graph->bodies, BODY_BYTES);
    PINCH_ARCHIVE_LIST(a, *graph, ISLAND_BYTES);
    PINCH_ARCHIVE_LIST(a, graph->handed_when_built, HANDLE_BYTES);
    pinch_archive_count(a, &joints->row_room, 1, 1 << 28);
}

static void archive_islands(pinch_archive *a, const pinch_contact_store *contacts, pinch_island_graph *graph,
                            const pinch_joint_store *joints)
{
    pinch_step_bodies *bodies = &graph->bodies;
    for (int i = 0; i < bodies->count; i++) archive_body(a, &bodies->items[i], graph, joints);
    pinch_archive_index(a, &bodies->index, PINCH_ITEM_KEYS(*bodies, pinch_step_body, body), bodies->count);
    for (int k = 0; k < graph->count; k++) archive_island(a, &graph->items[k], graph, joints, contacts);
    ARCHIVE_PLACES(a, bodies->by_island, bodies->count, bodies->count);
    for (int i = 0; i < graph->handed_when_built.count; i++)
        pinch_archive_body(a, &graph->handed_when_built.items[i], false);
    pinch_archive_flag(a, &graph->sleepers);
}

/* Problems that stay between steps, where the settings have them stay. */
static void archive_problems(pinch_archive *a, pinch_problem_buffers *kept, const pinch_island_graph *graph,
                             const pinch_contact_store *contacts, int row_room)
{
    bool keeps = kept->bodies.items || kept->contacts.items;
    pinch_archive_flag(a, &keeps);
    if (!keeps) return;
    if (a->reading && !pinch_reserve_problem(kept, graph->bodies.count, contacts->results.count, row_room))
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    for (int k = 0; k < graph->count && a->status == PINCH_OK; k++) {
        const pinch_island *island = &graph->items[k];
        int rows = island->joints.row_count + island->drive_rows;
        pinch_archive_bytes(a, kept->bodies.items + island->bodies.first,
                            (size_t)island->bodies.count * sizeof *kept->bodies.items);
        pinch_archive_bytes(a, kept->contacts.items + island->contacts.first,
                            (size_t)island->contacts.count * sizeof *kept->contacts.items);
        pinch_archive_bytes(a, kept->rows.items + island->joints.room.first, (size_t)rows * sizeof *kept->rows.items);
    }
}

void pinch_archive_last_step(pinch_archive *a, pinch_contact_store *contacts, pinch_island_graph *graph,
                             pinch_joint_store *joints, pinch_problem_buffers *kept)
{
    archive_counts(a, contacts, graph, joints);
    archive_islands(a, contacts, graph, joints);
    archive_contacts_of_step(a, contacts, graph);
    archive_joints_of_step(a, joints, graph);
    archive_problems(a, kept, graph, contacts, joints->row_room);
}
