/* The stations of a step: solve, hand the forces to ODE, let it step, carry the contact histories on. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Keeps the statistics of one island's solve; of one at rest, whose solve was counted when it was done, its quality. */
static void count_solve(pinch_ode_stats *stats, const pinch_island *island)
{
    const pinch_step_result *result = &island->result;
    stats->depth_max = larger(stats->depth_max, island->depth_max);
    if (!island->again) {
        stats->retried_islands += !island->first_try;
        stats->iterations += result->solve.iterations;
        stats->projections += result->solve.projections;
        stats->newton_steps += result->solve.newton_steps;
        if (result->solve.iterations > stats->iterations_max) stats->iterations_max = result->solve.iterations;
    }
    stats->residual_max = larger(stats->residual_max, result->residual_max);
    stats->cone = larger(stats->cone, result->cone);
    stats->complementarity = larger(stats->complementarity, result->complementarity);
    stats->slip_direction = larger(stats->slip_direction, result->slip_direction);
    stats->force_scale = larger(stats->force_scale, result->force_scale);
    stats->softened_islands += result->floor_depth > 0;
    stats->floor_depth_max = larger(stats->floor_depth_max, result->floor_depth);
    if (result->floor_level > stats->floor_level_max) stats->floor_level_max = result->floor_level;
}

/* A step that does not come to be: contacts that were left to ODE, and those handed over, are for no other. */
static pinch_status abandon(pinch_ode *p, pinch_status status)
{
    dJointGroupEmpty(p->left);
    for (int k = 0; k < p->islands.count; k++) {
        pinch_take_back_forces(p, &p->islands.items[k]);
        pinch_take_in(p, &p->islands.items[k]);
        pinch_enable_joints(p, &p->islands.items[k]);
    }
    pinch_handed_enable(p);
    p->islands.count = 0;
    for (int i = 0; i < p->pairs.count; i++) p->pairs.items[i].handed_over = -1;
    p->taken.count = p->directions.count = 0;
    pinch_expect_nothing(p);
    return status;
}

static void tie(pinch_ode *p, dBodyID body1, dBodyID body2)
{
    if (body1 && body2) dJointAttach(dJointCreateNull(p->world, p->left), body1, body2);
}

/*
 * ODE wakes a disabled body that a joint ties to an enabled one, and lets bodies go to sleep only together. Contacts
 * that it does not see any more, and joints that Pinch has solved, must tie them all the same: joints without rows,
 * where anything sleeps or may.
 */
static void link_touching(pinch_ode *p)
{
    for (int i = 0; i < p->pairs.count && p->sleepers; i++) {
        const pinch_pair *pair = &p->pairs.items[i];
        if (pair->manifold.count == 0) continue;
        const pinch_island *island = &p->islands.items[pair->island];
        if (island->may_sleep && island->solved) tie(p, pair->body[0], pair->body[1]);
    }
}

static void link_jointed(pinch_ode *p)
{
    for (int k = 0; k < p->islands.count && p->sleepers; k++) {
        const pinch_island *island = &p->islands.items[k];
        for (int j = 0; j < island->joint_count && island->may_sleep && island->takes_joints; j++) {
            dJointID joint = pinch_island_joint(p, island, j)->joint;
            tie(p, dJointGetBody(joint, 0), dJointGetBody(joint, 1));
        }
    }
}

/* One thread's share of the islands. */
typedef void island_work(pinch_ode *p, int worker, pinch_island *island, double h);

typedef struct island_task {
    pinch_ode *p;
    island_work *work;
    double h;
} island_task;

static void work_on_islands(void *context, int worker, int first, int end)
{
    const island_task *task = context;
    for (int k = first; k < end; k++) task->work(task->p, worker, &task->p->islands.items[k], task->h);
}

static void for_islands(pinch_ode *p, island_work *work, double h)
{
    enum { ISLANDS_AT_A_TIME = 4 };
    island_task task = {p, work, h};
    bool little = p->unchanged && p->joints.count == 0; /* all at rest, as a rule: sooner done than handed round */
    pinch_workers_run(little ? NULL : p->workers, work_on_islands, &task, p->islands.count, ISLANDS_AT_A_TIME);
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
            p->stats.islands++;
            p->stats.contacts_solved += island->contact_count;
            p->stats.islands_at_rest += island->again;
            if (!island->again || p->recount) count_solve(&p->stats, island);
            if (island->rests && !island->again) pinch_brake(p, island);
        } else if (!pinch_leave_island(p, island, h)) {
            return PINCH_OUT_OF_MEMORY;
        }
        all_first = all_first && (island->first_try || island->again);
    }
    p->stats.unconverged_steps += !all_first;
    p->recount = false;
    return PINCH_OK;
}

/* Memory ran out before any island was solved. */
static pinch_status give_up(pinch_ode *p)
{
    p->islands.count = 0;
    return abandon(p, PINCH_OUT_OF_MEMORY);
}

/* What all islands depend on. */
static void look_at_world(pinch_ode *p, double h)
{
    dVector3 gravity;
    dWorldGetGravity(p->world, gravity);
    double now[7] = {gravity[0],
                     gravity[1],
                     gravity[2],
                     dWorldGetERP(p->world),
                     dWorldGetCFM(p->world),
                     dWorldGetContactMaxCorrectingVel(p->world),
                     dWorldGetContactSurfaceLayer(p->world)};
    p->same_world = h == p->last_h && memcmp(now, p->world_values, sizeof now) == 0;
    memcpy(p->world_values, now, sizeof now);
}

pinch_status pinch_ode_solve(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || p->solved) return PINCH_INVALID_ARGUMENT;
    look_at_world(p, h);
    if (!pinch_pairs_update(p)) return give_up(p);
    pinch_handed_disable(p);
    if (!pinch_layout_holds(p) && !pinch_gather(p)) return give_up(p);
    p->left_contacts.count = 0;
    for_islands(p, pinch_solve_island, h);
    pinch_status status = hand_over(p, h);
    if (status != PINCH_OK) return abandon(p, status);
    link_touching(p);
    pinch_handed_settle(p);
    if (p->contacts.count > p->stats.points_high_water) p->stats.points_high_water = p->contacts.count;
    p->solved = true;
    p->solved_h = h;
    return PINCH_OK;
}

/* The joints of an island, before ODE's step. */
static void give_joint_forces(pinch_ode *p, int worker, pinch_island *island, double h)
{
    (void)worker;
    pinch_give_joint_forces(p, island, h);
}

/* What an island carries on, after ODE's step. */
static void carry_on(pinch_ode *p, int worker, pinch_island *island, double h)
{
    (void)worker;
    pinch_stop_drives(p, island);
    pinch_enable_joints(p, island);
    pinch_carry_history(p, island, h);
}

static void count_carried(pinch_ode *p, double h)
{
    for (int k = 0; k < p->islands.count; k++) {
        const pinch_island *island = &p->islands.items[k];
        if (island->rests && !island->again) pinch_settle_poses(p, island);
        pinch_judge_joints(p, island, h);
        *(island->takes_joints ? &p->stats.joints_solved : &p->stats.joints_left) +=
            island->solved ? island->joint_count : 0;
        p->stats.step_mismatch = larger(p->stats.step_mismatch, island->mismatch[0]);
        p->stats.step_mismatch_angular = larger(p->stats.step_mismatch_angular, island->mismatch[1]);
    }
}

pinch_status pinch_ode_advance(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || !p->solved) return PINCH_INVALID_ARGUMENT;
    if (p->joints.count > 0 && !p->at_once) for_islands(p, give_joint_forces, h);
    link_jointed(p);
    int stepped = p->settings.stepper == PINCH_ODE_QUICKSTEP ? dWorldQuickStep(p->world, h) : dWorldStep(p->world, h);
    pinch_handed_enable(p);
    pinch_read_left_contacts(p);
    for_islands(p, carry_on, h);
    count_carried(p, h);
    dJointGroupEmpty(p->left);
    p->taken.count = p->directions.count = 0;
    p->solved = p->at_once = false;
    p->places = p->layout = p->unchanged = true;
    p->step++;
    p->last_h = h;
    p->stats.steps++;
    pinch_scratch_review(p);
    return stepped ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

pinch_status pinch_solve_at_once(pinch_ode *p, double h)
{
    if (!p) return PINCH_INVALID_ARGUMENT;
    bool was = p->at_once;
    p->at_once = true;
    pinch_status status = pinch_ode_solve(p, h);
    if (status != PINCH_OK) p->at_once = was;
    return status;
}

pinch_status pinch_ode_step(pinch_ode *p, double h)
{
    pinch_status status = pinch_solve_at_once(p, h);
    return status == PINCH_OK ? pinch_ode_advance(p, h) : status;
}
