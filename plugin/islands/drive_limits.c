/*
 * Bounds for the speed of fingers under force control.
 *
 * A drive without inertia is where its contacts push back with its force. There may be no such place: a contact whose
 * normal has turned away from the drive's axis presses the less, the farther the finger goes, and two drives that press
 * on each other with different forces go on together. Or the place is far away: a normal across the axis pushes the
 * finger back by many times its depth. What the finger does then is to move on until its contacts bear the force, or
 * until it touches nothing. The contacts of a step's start tell nothing of what comes farther away than a part of the
 * geoms' size, so this is as far as the finger goes in the step. The bounds are one-sided rows of the problem, solved
 * and verified like the stops of a joint. With them the step has a solution (core/README.md, section 6).
 *
 * Where contacts bear the force within that distance, no rows are needed, and none are added.
 */
#include "islands/island_life.h"

#include "support/vec3.h"

#include <math.h>

static const double PART_OF_SIZE = 0.25; /* over which a normal turns by 15 degrees on a ball */

/* Returns how far the finger may go in the step, m; infinity where it touches nothing. */
static double reach_of(const pinch_contact_store *contacts, const pinch_island *island, int step_body)
{
    double least = INFINITY;
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, island->pairs, i);
        if (pair->step_body[0] == step_body || pair->step_body[1] == step_body)
            least = fmin(least, PART_OF_SIZE * pinch_pair_size(contacts, pair));
    }
    return least;
}

/* Returns the force against the drive (N) with which a contact's normal law answers to a speed along the axis. */
static double pushes_back(const pinch_problem *problem, const pinch_contact *c, int body, double speed)
{
    double along = pinch_v3_dot(c->normal, problem->bodies[body].drive_axis) * (c->body1 == body ? -1 : 1);
    double w = c->surface_velocity[0] - along * speed;
    double force = c->stiffness[0] * (c->depth - problem->step * w) - c->damping[0] * w;
    return along * fmax(fmin(force, c->max_force), 0);
}

/* Returns what the contact's other side bears (N) with that speed: what it has of inertia. Turning takes away from
 * that, by a factor of less than four for common shapes. */
static double partner_bears(const pinch_problem *problem, const pinch_contact *c, int body, double speed)
{
    static const double TURNING = 0.25;
    int other = c->body1 == body ? c->body2 : c->body1;
    return other < 0 ? INFINITY : TURNING * problem->bodies[other].mass * speed / problem->step;
}

/* Tells whether the contacts balance the drive at some speed within the bounds. */
static bool contacts_bear(const pinch_problem *problem, int body, double speed)
{
    double ahead = 0, behind = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        if (c->body1 != body && c->body2 != body) continue;
        ahead += fmax(fmin(pushes_back(problem, c, body, speed), partner_bears(problem, c, body, speed)), 0);
        behind += fmax(pushes_back(problem, c, body, -speed), 0);
    }
    return ahead > problem->bodies[body].drive_force && behind < problem->bodies[body].drive_force;
}

static void add_rows(pinch_problem *problem, int body, double speed)
{
    for (int way = 0; way < PINCH_DRIVE_ROWS; way++) {
        pinch_joint_row *row = &problem->rows[problem->row_count++];
        *row = (pinch_joint_row){.body1 = body,
                                 .body2 = PINCH_STATIC_BODY,
                                 .rhs = way ? -speed : speed,
                                 .low = way ? 0 : -INFINITY,
                                 .high = way ? INFINITY : 0};
        pinch_v3_copy(row->j1, problem->bodies[body].drive_axis);
    }
}

void pinch_limit_drives(const pinch_contact_store *contacts, const pinch_step_bodies *bodies, pinch_island *island,
                        bool all, pinch_problem *problem)
{
    if (bodies->drives.count == 0) return;
    problem->row_count = island->joints.row_count;
    for (int body = 0; body < problem->body_count; body++) {
        if (problem->bodies[body].mass > 0) continue;
        double reach = reach_of(contacts, island, bodies->by_island.items[island->bodies.first + body]);
        double speed = reach / problem->step;
        if (reach < INFINITY && (all || !contacts_bear(problem, body, speed))) add_rows(problem, body, speed);
    }
    island->drive_rows = problem->row_count - island->joints.row_count;
}

bool pinch_drives_run_away(const pinch_contact_store *contacts, const pinch_step_bodies *bodies,
                           const pinch_island *island, const pinch_problem *problem)
{
    bool answered = island->result.solve.status == PINCH_SOLVE_CONVERGED;
    for (int body = 0; body < problem->body_count && bodies->drives.count > 0; body++) {
        const pinch_body *b = &problem->bodies[body];
        if (b->mass > 0) continue;
        double reach = reach_of(contacts, island, bodies->by_island.items[island->bodies.first + body]);
        double way = problem->step * fabs(pinch_v3_dot(b->velocity_end, b->drive_axis));
        if (!answered || PART_OF_SIZE * way > reach) return true;
    }
    return false;
}

int pinch_drives_at_limit(const pinch_island *island, const pinch_problem *problem)
{
    int count = 0;
    for (int k = island->joints.row_count; k < problem->row_count; k++) count += problem->rows[k].force != 0;
    return count;
}
