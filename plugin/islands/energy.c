/* The energy that contacts store and lose in a step. */
#include "islands/island_life.h"

#include "contacts/materials.h"

#include <math.h>
#include <string.h>

static double spring(double stiffness, double extension)
{
    return 0.5 * stiffness * extension * extension;
}

/* Returns what the normal spring has taken up at depth d: the integral of clamp(k x, 0, limit). */
static double pressed_in(const pinch_contact *c, double d)
{
    double k = c->stiffness[0], yields = c->max_force / k;
    if (!(d > 0)) return 0;
    return d <= yields ? spring(k, d) : spring(k, yields) + c->max_force * (d - yields);
}

/*
 * The same where the `part` of the depth follows Hertz' law, and k is the secant at the depth of the contact. That part
 * has taken up 2/5 of force times depth by then, a linear spring a half, so that all has taken up F d (1/2 - part/10).
 * From there the force goes along the tangent, whose compliance is (1 - part/3)/k: Hertz' is 2/3 of the secant's.
 */
static double pressed_by_hertz(const pinch_contact *c, double part, double d)
{
    double k = c->stiffness[0], force = k * c->depth, more = d - c->depth;
    if (!(d > 0) || !(c->depth > 0)) return pressed_in(c, d);
    if (force < c->max_force) return force * (c->depth * (0.5 - 0.1 * part) + more) + spring(k / (1 - part / 3), more);
    /* It yields. At the limit, the Hertzian part had less depth by the force to the power of 2/3. */
    double limit = c->max_force, less = limit / force;
    double hertz = part * c->depth * cbrt(less * less), linear = (1 - part) * c->depth * less;
    return limit * (0.4 * hertz + 0.5 * linear + (d - hertz - linear));
}

/*
 * Along the normal the spring is pressed from depth d to d+ = d - h w_n, with the end's force clamp(k d+, 0, limit).
 * Over the motion it takes that force times d+ - d, which exceeds what it stores by the integrator's part; what the
 * contact force has beyond the spring's is the damper's. A yielding finger gives back what it took at its limit.
 */
static void add_normal(const pinch_contact *c, double hertz_part, double h, pinch_ode_energy *e)
{
    double k = c->stiffness[0], w = c->relative_velocity[0], end = c->depth - h * w;
    double pressed = end > 0 ? fmin(k * end, c->max_force) : 0;
    double stored = pressed_in(c, c->depth), left = pressed_in(c, end);
    if (hertz_part > 0) {
        stored = pressed_by_hertz(c, hertz_part, c->depth);
        left = pressed_by_hertz(c, hertz_part, end);
    }
    e->elastic_start += stored;
    e->elastic_end += left;
    e->integrator += stored - left - pressed * h * w;
    e->damping += -h * w * (c->force[0] - pressed);
}

/* Adds one tangential or torsional direction: the spring moves from x to x+, and the rest of the motion is slip. */
static void add_friction(const pinch_contact *c, int i, pinch_ode_energy *e)
{
    double k = c->stiffness[i < 2 ? 1 : 2], r = c->force[1 + i], start = c->elastic[i], end = c->elastic_end[i];
    e->elastic_start += spring(k, start);
    e->elastic_end += spring(k, end);
    if (c->state == PINCH_CONTACT_OPEN) { /* lets go of its shear without a force */
        e->damping += spring(k, start);
        return;
    }
    e->friction += -r * c->slip[i];
    e->damping += (-r - k * end) * (end - start);
    e->integrator += spring(k, end - start);
}

static void add_contact(const pinch_contact *c, double hertz_part, double h, pinch_ode_energy *e)
{
    int rows = c->model == PINCH_CONTACT_ROLLING ? PINCH_CONTACT_SOFT : c->model;
    add_normal(c, hertz_part, h, e);
    for (int i = 0; i < rows - 1; i++) add_friction(c, i, e);
    for (int i = 0; i < rows; i++) e->drives -= h * c->force[i] * c->surface_velocity[i];
}

/* A drive that went as far as it may in the step is held back by a row, which takes up what the contacts do not bear of
 * its force. */
static void add_drive_rows(const pinch_island_graph *graph, const pinch_problem_buffers *kept,
                           const pinch_island *island, double h, pinch_ode_energy *e)
{
    const pinch_step_bodies *bodies = &graph->bodies;
    for (int k = 0; k < island->drive_rows; k++) {
        const pinch_joint_row *row = &kept->rows.items[island->joints.room.first + island->joints.row_count + k];
        const pinch_step_body *b = &bodies->items[bodies->by_island.items[island->bodies.first + row->body1]];
        e->drives += h * row->force * bodies->drives.items[b->drive].speed;
    }
}

static void add_pairs(const pinch_contact_store *store, const pinch_problem_buffers *kept, const pinch_island *island,
                      double h, pinch_ode_energy *e)
{
    const pinch_contact *contacts = kept->contacts.items + island->contacts.first;
    /* Pairs are looked at for Hertz' law alone. They are no longer those of the step where something has been forgotten,
     * and may name geoms that are gone. */
    bool by_pairs = store->laws_follow_poses && store->same_bodies && !store->forgot_pairs;
    for (int i = 0; i < island->contacts.count && !by_pairs; i++) add_contact(&contacts[i], 0, h, e);
    for (int i = 0; i < island->pairs.count && by_pairs; i++) {
        const pinch_pair *pair = pinch_island_pair(store, island->pairs, i);
        double hertz_part = pair->has_material ? pinch_pair_hertz_part(store, pair) : 0;
        for (int k = 0; k < pair->manifold.count; k++)
            add_contact(&contacts[pair->first_in_island + k], hertz_part, h, e);
    }
}

void pinch_contact_energy(const pinch_island_graph *graph, const pinch_contact_store *store,
                          const pinch_problem_buffers *kept, double h, pinch_ode_energy *e)
{
    const pinch_step_bodies *bodies = &graph->bodies;
    memset(e, 0, sizeof *e);
    for (int k = 0; k < graph->count; k++) {
        const pinch_island *island = &graph->items[k];
        if (!pinch_island_is_solved(island)) continue;
        add_pairs(store, kept, island, h, e);
        add_drive_rows(graph, kept, island, h, e);
    }
    for (int i = 0; i < bodies->count; i++) {
        const pinch_step_body *b = &bodies->items[bodies->by_island.items[i]];
        if (b->drive < 0 || !pinch_island_is_solved(&graph->items[b->parent])) continue;
        e->drives += h * bodies->drives.items[b->drive].force * bodies->drives.items[b->drive].speed;
    }
}
