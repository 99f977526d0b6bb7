/* The stations of a step: solve, hand the forces to ODE, let it step, carry the contact histories on. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Keeps the statistics of one island's solve. */
static void count_solve(pinch_ode_stats *stats, const pinch_island *island)
{
    const pinch_step_result *result = &island->result;
    stats->islands++;
    stats->retried_islands += !island->first_try;
    stats->contacts_solved += island->contact_count;
    stats->depth_max = larger(stats->depth_max, island->depth_max);
    stats->iterations += result->solve.iterations;
    stats->projections += result->solve.projections;
    stats->newton_steps += result->solve.newton_steps;
    if (result->solve.iterations > stats->iterations_max) stats->iterations_max = result->solve.iterations;
    stats->residual_max = larger(stats->residual_max, result->residual_max);
    stats->cone = larger(stats->cone, result->cone);
    stats->complementarity = larger(stats->complementarity, result->complementarity);
    stats->slip_direction = larger(stats->slip_direction, result->slip_direction);
    stats->force_scale = larger(stats->force_scale, result->force_scale);
    stats->softened_islands += result->floor_depth > 0;
    stats->floor_depth_max = larger(stats->floor_depth_max, result->floor_depth);
    if (result->rung > stats->rung_max) stats->rung_max = result->rung;
}

/* The contacts' forces to the bodies, their velocities to those under force control. */
static void give_forces(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = &p->bodies.items[p->body_of.items[island->first_body + k]];
        if (b->drive < 0) {
            const double *f = b->wrench;
            pinch_v3_copy(b->given, dBodyGetForce(b->body));
            pinch_v3_copy(b->given + 3, dBodyGetTorque(b->body));
            dBodyAddForce(b->body, f[0], f[1], f[2]);
            dBodyAddTorque(b->body, f[3], f[4], f[5]);
            continue;
        }
        pinch_drive *drive = &p->drives.items[b->drive];
        drive->speed = pinch_v3_dot(b->velocity_end, drive->axis);
        const double *v = dBodyGetLinearVel(b->body);
        dBodySetLinearVel(b->body, v[0] + drive->speed * drive->axis[0], v[1] + drive->speed * drive->axis[1],
                          v[2] + drive->speed * drive->axis[2]);
    }
}

/* A step that does not come to be: contacts that were left to ODE, and those handed over, are for no other. */
static pinch_status abandon(pinch_ode *p, pinch_status status)
{
    dJointGroupEmpty(p->left);
    for (int i = 0; i < p->pairs.count; i++) p->pairs.items[i].handed_over = -1;
    p->pool.count = p->surfaces.count = p->handed.count = 0;
    return status;
}

/*
 * ODE wakes a disabled body that a joint ties to an enabled one, and lets bodies go to sleep only together. Contacts
 * that it does not see any more must tie them all the same: joints without rows, where anything sleeps or may.
 */
static void link_sleepers(pinch_ode *p)
{
    for (int i = 0; i < p->pairs.count; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0 || !pair->body[0] || !pair->body[1]) continue;
        const pinch_island *island = &p->islands.items[pair->island];
        if (!island->may_sleep || !island->solved) continue;
        dJointAttach(dJointCreateNull(p->world, p->left), pair->body[0], pair->body[1]);
    }
}

/* One thread's share of the islands. */
typedef struct solve_task {
    pinch_ode *p;
    double h;
} solve_task;

static void solve_islands(void *context, int worker, int first, int end)
{
    const solve_task *task = context;
    for (int k = first; k < end; k++)
        pinch_solve_island(task->p, worker, &task->p->islands.items[k], task->h);
}

/* In the islands' order, whoever solved them. */
static pinch_status hand_over(pinch_ode *p, double h)
{
    bool all_first = true;
    for (int k = 0; k < p->islands.count; k++) {
        const pinch_island *island = &p->islands.items[k];
        if (island->status != PINCH_OK) return island->status;
    }
    for (int k = 0; k < p->islands.count; k++) {
        const pinch_island *island = &p->islands.items[k];
        if (!island->awake) {
            p->stats.contacts_asleep += island->contact_count;
            continue;
        }
        if (island->solved) {
            count_solve(&p->stats, island);
            give_forces(p, island);
        } else if (!pinch_leave_island(p, island, h)) {
            return PINCH_OUT_OF_MEMORY;
        }
        all_first = all_first && island->first_try;
    }
    p->stats.unconverged_steps += !all_first;
    return PINCH_OK;
}

pinch_status pinch_ode_solve(pinch_ode *p, double h)
{
    enum { ISLANDS_AT_A_TIME = 4 };
    if (!p || !(h > 0) || !isfinite(h) || p->solved) return PINCH_INVALID_ARGUMENT;
    if (!pinch_pairs_update(p) || !pinch_gather(p)) return abandon(p, PINCH_OUT_OF_MEMORY);
    p->left_contacts.count = 0;
    solve_task task = {p, h};
    pinch_workers_run(p->workers, solve_islands, &task, p->islands.count, ISLANDS_AT_A_TIME);
    pinch_status status = hand_over(p, h);
    if (status != PINCH_OK) return abandon(p, status);
    link_sleepers(p);
    pinch_handed_disable(p);
    if (p->contacts.count > p->stats.points_high_water) p->stats.points_high_water = p->contacts.count;
    p->solved = true;
    p->solved_h = h;
    return PINCH_OK;
}

pinch_status pinch_ode_advance(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || !p->solved) return PINCH_INVALID_ARGUMENT;
    pinch_joint_forces_give(p);
    int stepped = p->settings.stepper == PINCH_ODE_QUICKSTEP ? dWorldQuickStep(p->world, h) : dWorldStep(p->world, h);
    for (int i = 0; i < p->drives.count; i++) { /* back to the motion its owner prescribed */
        pinch_drive *drive = &p->drives.items[i];
        if (pinch_key_map_get(&p->body_index, (uint64_t)(uintptr_t)drive->body) < 0) continue;
        const double *v = dBodyGetLinearVel(drive->body), s = drive->speed;
        dBodySetLinearVel(drive->body, v[0] - s * drive->axis[0], v[1] - s * drive->axis[1], v[2] - s * drive->axis[2]);
    }
    pinch_joint_forces_end(p);
    pinch_handed_enable(p);
    pinch_quiet_sleepers(p);
    pinch_read_left_contacts(p);
    pinch_measure_mismatch(p);
    pinch_carry_history(p, h);
    dJointGroupEmpty(p->left);
    p->pool.count = p->surfaces.count = 0;
    p->solved = false;
    p->step++;
    p->last_h = h;
    p->stats.steps++;
    return stepped ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

pinch_status pinch_ode_step(pinch_ode *p, double h)
{
    pinch_status status = pinch_ode_solve(p, h);
    return status == PINCH_OK ? pinch_ode_advance(p, h) : status;
}
