/* A step: the islands are solved, ODE is given their forces and steps, and contact histories are carried on. */
#include "ode_state.h"

#include "contacts/contact_buffer.h"
#include "contacts/contact_joints.h"
#include "contacts/pairs.h"
#include "islands/island_life.h"
#include "joints/island_joints.h"
#include "ode_internal.h"

#include <math.h>

static void keep_larger(double *kept, double value)
{
    if (!(*kept > value)) *kept = value;
}

/* Looks at what all islands depend on. */
static void watch_world(pinch_ode *p, double h)
{
    dWorldID world = p->context.world;
    double now[8];
    dWorldGetGravity(world, now);
    now[3] = dWorldGetERP(world), now[4] = dWorldGetCFM(world);
    now[5] = dWorldGetContactMaxCorrectingVel(world), now[6] = dWorldGetContactSurfaceLayer(world);
    p->context.h = h;
    p->context.h_before = p->last_h;
    p->context.same_world = h == p->last_h && memcmp(now, p->world_values, sizeof p->world_values) == 0;
    memcpy(p->context.gravity, now, sizeof p->context.gravity);
    p->context.values = (pinch_world_values){now[3], now[4], now[5], now[6]};
    memcpy(p->world_values, now, sizeof p->world_values);
}

/* ---- passes over the islands ---- */

/* What a pass does with one island. The worker's number tells which thread does it. */
typedef void island_work(pinch_ode *p, int worker, pinch_island *island);

typedef struct island_pass {
    pinch_ode *p;
    island_work *work;
    bool reads_ode;               /* it reads most of what ODE has of each island */
    void (*by_one)(pinch_ode *p); /* what the caller's thread begins with, beside the pass; NULL: nothing */
} island_pass;

/* Asks ahead for Pinch's own records of bodies and joints, which tell where ODE has them. Of what ODE has skipped, only
 * bodies are looked at. */
static void prefetch_records(const pinch_ode *p, const pinch_island *island)
{
    bool skipped = island->skipped_by_ode;
    for (int k = 0; k < island->bodies.count; k++)
        pinch_prefetch(pinch_island_body(&p->graph.bodies, island->bodies, k),
                       skipped ? PINCH_STEP_BODY_LINKS : PINCH_STEP_BODY_AT_REST);
    for (int k = 0; k < island->joints.range.count && !skipped; k++)
        pinch_prefetch(pinch_island_joint(&p->joints, &island->joints, k), PINCH_STEP_JOINT_AT_REST);
}

/* Asks ahead for what a pass reads that islands have outside of the lists in which they follow each other. Of what has
 * been at rest, bodies and joints are compared; of what moves, bodies are written, too, and contacts. What ODE has
 * skipped is enabled again, and no more. */
static void prefetch_island(const pinch_ode *p, const pinch_island *island)
{
    if (island->skipped_by_ode) {
        for (int k = 0; k < island->bodies.count; k++)
            pinch_prefetch_to_enable(pinch_island_body(&p->graph.bodies, island->bodies, k)->body);
        return;
    }
    bool rests = island->phase >= PINCH_ISLAND_RESTING;
    for (int k = 0; k < island->bodies.count; k++) {
        dBodyID body = pinch_island_body(&p->graph.bodies, island->bodies, k)->body;
        if (rests)
            pinch_prefetch_body(body);
        else
            pinch_prefetch_to_write(body, PINCH_BODY_BYTES);
    }
    for (int k = 0; k < island->joints.range.count; k++)
        pinch_prefetch_joint(pinch_island_joint(&p->joints, &island->joints, k)->joint);
    for (int i = 0; i < island->pairs.count && !rests; i++) {
        const pinch_pair *pair = pinch_island_pair(&p->contacts, island->pairs, i);
        pinch_prefetch_points(pair);
        pinch_prefetch_results(&p->contacts, pair);
    }
    for (int k = 0; k < island->kinematic.count && !rests; k++)
        pinch_prefetch_to_write(pinch_kinematic_body_of(&p->graph, island, k)->body, PINCH_BODY_BYTES);
}

/* The data of fewer islands, and of fewer bodies, fit into the caches. */
enum { MANY = 64, MANY_BODIES = 256 };

static void work_on_islands(void *context, int worker, int first, int end)
{
    island_pass *pass = context;
    pinch_ode *p = pass->p;
    if (worker == 0 && pass->by_one) {
        pass->by_one(p);
        pass->by_one = NULL;
    }
    bool ahead = pass->reads_ode && p->graph.count > MANY;
    for (int k = first; k < end; k++) {
        if (p->graph.items[k].shared) continue;
        if (ahead && k + 2 < end) prefetch_records(p, &p->graph.items[k + 2]);
        if (ahead && k + 1 < end) prefetch_island(p, &p->graph.items[k + 1]);
        pass->work(p, worker, &p->graph.items[k]);
    }
}

enum { FEW_AT_A_TIME = 4, MANY_AT_A_TIME = 16 };

/* Where all is at rest, as a rule, the work is sooner done than shared out. */
static bool little_to_do(const pinch_ode *p)
{
    return p->contacts.unchanged && p->joints.count == 0;
}

/* Of an island with fewer contacts, loops are sooner done than shared out. */
enum { LARGE = 512 };

/* Finds the islands that are more than a thread's share of all: their loops are shared instead. */
static void find_shared_islands(pinch_ode *p)
{
    long all = p->contacts.results.count;
    for (int k = 0; k < p->graph.count; k++) {
        long contacts = p->graph.items[k].contacts.count;
        p->graph.items[k].shared = p->pool.workers && contacts >= LARGE && contacts * p->pool.threads > all;
    }
}

/* Shares the islands out to the threads, behind those whose loops all threads share. */
static void make_pass(island_pass *pass)
{
    pinch_ode *p = pass->p;
    for (int k = 0; k < p->graph.count && p->pool.workers && p->contacts.results.count >= LARGE; k++)
        if (p->graph.items[k].shared) pass->work(p, 0, &p->graph.items[k]);
    pinch_workers_run(little_to_do(p) ? NULL : p->pool.workers, work_on_islands, pass, p->graph.count,
                      p->graph.count > MANY ? MANY_AT_A_TIME : FEW_AT_A_TIME);
    if (pass->by_one) pass->by_one(p);
}

static void for_each_island(pinch_ode *p, island_work *work, bool reads_ode)
{
    make_pass(&(island_pass){p, work, reads_ode, NULL});
}

/* Wakes the threads up for the passes of a step, as far as the last one tells whether there will be any. */
static void call_threads(pinch_ode *p)
{
    bool much = p->graph.count > FEW_AT_A_TIME || p->contacts.results.count >= LARGE;
    if (much && !little_to_do(p)) pinch_workers_call(p->pool.workers);
}

void pinch_expect_step(pinch_ode *p)
{
    int before = p->contacts.buffered_before;
    if (before > MANY && p->contacts.buffer.count == before - before / 4) call_threads(p);
}

/* Goes through the islands in their order, in the caller's thread. */
static void for_each_island_in_order(pinch_ode *p, void (*work)(pinch_ode *p, pinch_island *island))
{
    for (int k = 0; k < p->graph.count; k++) work(p, &p->graph.items[k]);
}

static void solve(pinch_ode *p, int worker, pinch_island *island)
{
    pinch_solve_island(&p->context, &p->contacts, &p->graph, &p->joints, &p->pool, worker, island);
}

static void give_joint_forces(pinch_ode *p, int worker, pinch_island *island)
{
    (void)worker;
    if (pinch_island_is_solved(island))
        pinch_give_joint_forces(&p->joints, &p->context, &p->graph.bodies, island->bodies, &island->joints, NULL);
}

static void set_bodies_aside(pinch_ode *p, int worker, pinch_island *island)
{
    (void)worker;
    pinch_set_bodies_aside(&p->context, &p->graph, island);
}

static void carry_on(pinch_ode *p, int worker, pinch_island *island)
{
    (void)worker;
    const pinch_crew *crew = pinch_crew_of(&p->pool, island);
    pinch_move_bodies(&p->context, &p->graph, island, crew, p->stepped);
    pinch_stop_drives(&p->graph.bodies, island);
    pinch_enable_joints(&p->joints, &island->joints);
    pinch_carry_history(&p->context, &p->contacts, &p->graph.bodies, island, crew);
}

/* Each body's geoms are put into ODE's list of those that have moved, in an order of its own. Nothing that carries on
 * reads or writes geoms. */
static void tell_geoms(pinch_ode *p)
{
    pinch_tell_geoms_of_islands(&p->graph, p->graph.count > MANY);
}

static void take_back(pinch_ode *p, pinch_island *island)
{
    pinch_take_back_island_forces(&p->graph.bodies, island);
    pinch_reenable_bodies(&p->graph.bodies, island);
    pinch_enable_joints(&p->joints, &island->joints);
}

/* ---- after the solve ---- */

/* Counts what found the island's answer. A later try is by NSNMGK with Newton's steps, or by these alone. */
static void count_solver(pinch_ode_stats *stats, pinch_solver_settings settings, const pinch_island *island)
{
    if (island->first_solve_failed) settings.solver = PINCH_SOLVER_NSNMGK;
    long *const counters[PINCH_SOLVED_BY_COUNT] = {[PINCH_SOLVED_BY_NEWTON] = &stats->islands_by_newton,
                                                   [PINCH_SOLVED_BY_PROJECTIONS] = &stats->islands_by_projections,
                                                   [PINCH_SOLVED_BY_FLOW] = &stats->islands_by_flow,
                                                   [PINCH_SOLVED_BY_LCP] = &stats->islands_by_lcp};
    long *counter = counters[pinch_solver_solved_by(&settings, &island->result.solve)];
    if (counter) ++*counter;
}

/* Counts one island's solve. Of one whose answer is reused only the quality counts: its solve was counted when it was
 * done. */
static void count_solve(pinch_ode *p, const pinch_island *island)
{
    pinch_ode_stats *stats = &p->stats;
    const pinch_step_result *result = &island->result;
    keep_larger(&stats->depth_max, island->depth_max);
    keep_larger(&stats->joint_error_max, island->joints.error);
    keep_larger(&stats->joint_error_angle_max, island->joints.error_angle);
    if (island->phase != PINCH_ISLAND_REUSED) {
        stats->retried_islands += island->first_solve_failed;
        stats->iterations += result->solve.iterations;
        stats->projections += result->solve.projections;
        stats->newton_steps += result->solve.newton_steps;
        if (!result->swept) count_solver(stats, p->context.settings.solver, island);
        if (result->solve.iterations > stats->iterations_max) stats->iterations_max = result->solve.iterations;
    }
    keep_larger(&stats->residual_max, result->residual_max);
    keep_larger(&stats->cone, result->cone);
    keep_larger(&stats->complementarity, result->complementarity);
    keep_larger(&stats->slip_direction, result->slip_direction);
    keep_larger(&stats->force_scale, result->force_scale);
    stats->softened_islands += result->floor_depth > 0;
    stats->too_soft_islands += result->too_soft;
    stats->swept_islands += result->swept;
    keep_larger(&stats->floor_residual_max, result->floor_residual);
    stats->drives_at_limit += island->drives_at_limit;
    keep_larger(&stats->floor_depth_max, result->floor_depth);
    if (result->floor_level > stats->floor_level_max) stats->floor_level_max = result->floor_level;
}

/* Counts the solve of an island, and leaves the island to ODE where it has no answer. */
static void conclude_solve(pinch_ode *p, pinch_island *island)
{
    pinch_ode_stats *stats = &p->stats;
    bool reused = island->phase == PINCH_ISLAND_REUSED;
    if (island->phase == PINCH_ISLAND_ASLEEP || island->phase == PINCH_ISLAND_LEFT) {
        stats->contacts_asleep += island->contacts.count;
        return;
    }
    p->unconverged = p->unconverged || (island->first_solve_failed && !reused);
    if (island->phase == PINCH_ISLAND_FALLBACK) {
        pinch_open_fallback_account(&p->context, &p->graph, &p->joints, island);
        p->unconverged = p->unconverged || island->contacts.count > 0; /* left without a try, it has no answer either */
        if (!pinch_solve_island_by_ode(&p->context, &p->contacts, &p->graph, &p->pool, stats, island))
            island->status = PINCH_OUT_OF_MEMORY;
        return;
    }
    bool verified = island->result.solve.status == PINCH_SOLVE_CONVERGED;
    p->unconverged = p->unconverged || island->result.too_soft || !verified;
    stats->islands++;
    stats->contacts_solved += island->contacts.count;
    stats->islands_at_rest += reused;
    if (!reused || p->recount_at_rest) count_solve(p, island);
    if (island->phase == PINCH_ISLAND_RESTING) pinch_stop_bodies(&p->graph.bodies, island);
}

/* Returns the status of the first island that has failed. */
static pinch_status first_failure(const pinch_ode *p)
{
    for (int k = 0; k < p->graph.count; k++)
        if (p->graph.items[k].status != PINCH_OK) return p->graph.items[k].status;
    return PINCH_OK;
}

/* Solves all islands. What is counted does not depend on who solved them. */
static pinch_status solve_islands(pinch_ode *p)
{
    p->graph.fallback_contacts.count = 0;
    find_shared_islands(p);
    for_each_island(p, solve, true);
    pinch_status status = first_failure(p);
    if (status != PINCH_OK) return status;
    p->unconverged = false;
    for_each_island_in_order(p, conclude_solve);
    status = first_failure(p);
    if (status != PINCH_OK) return status;
    p->stats.unconverged_steps += p->unconverged;
    p->recount_at_rest = false;
    return PINCH_OK;
}

static void link_bodies(const pinch_step_context *context, dBodyID body1, dBodyID body2)
{
    if (body1 && body2) dJointAttach(dJointCreateNull(context->world, context->joint_group), body1, body2);
}

/*
 * ODE wakes a disabled body that a joint ties to an enabled one, and lets bodies go to sleep only together. Where
 * anything sleeps or may sleep, joints without rows stand for the contacts and joints that Pinch has solved and ODE
 * does not see any more.
 */
static void link_jointed(pinch_ode *p, pinch_island *island)
{
    for (int j = 0; j < island->joints.range.count && island->may_sleep && island->joints.by_pinch; j++) {
        dJointID joint = pinch_island_joint(&p->joints, &island->joints, j)->joint;
        link_bodies(&p->context, dJointGetBody(joint, 0), dJointGetBody(joint, 1));
    }
}

/* Tells the pairs of solved islands so: the contact joints that the program made get their feedback, and where anything
 * sleeps the bodies are linked. The joints of other pairs are left to ODE. */
static void conclude_pairs(pinch_ode *p)
{
    bool sleepers = p->graph.sleepers, joints = p->contacts.contact_joints.count > 0;
    for (int i = 0; i < p->contacts.pairs.count && (sleepers || joints); i++) {
        const pinch_pair *pair = &p->contacts.pairs.items[i];
        const pinch_island *island = pair->manifold.count > 0 ? &p->graph.items[pair->island] : NULL;
        bool solved = island && pinch_island_is_solved(island);
        if (solved && island->may_sleep) link_bodies(&p->context, pair->body[0], pair->body[1]);
        if (joints) pinch_answer_contact_joints(&p->contacts, pair, solved);
    }
}

/* Gives a step up. Contacts that were left to ODE, and those handed over, are for no other step. */
static pinch_status abandon(pinch_ode *p, pinch_status status)
{
    pinch_workers_dismiss(p->pool.workers);
    dJointGroupEmpty(p->context.joint_group);
    for_each_island_in_order(p, take_back);
    p->graph.count = p->graph.handed.count = 0;
    pinch_abandon_contacts(&p->contacts);
    return status;
}

void pinch_drop_forgotten(pinch_ode *p)
{
    pinch_joint_poses_drop_forgotten(p->joints.poses);
    if (!p->contacts.forgot_pairs) return;
    pinch_forget_memories(&p->graph, &p->contacts.forgotten_bodies);
    pinch_hinge_references_forget_bodies(&p->joints.references, &p->contacts.forgotten_bodies);
    pinch_drop_forgotten_pairs(&p->contacts, p->context.number);
}

/* Makes room for all islands' problems at once, where they have to stay. */
static bool keep_problems(pinch_ode *p)
{
    pinch_problem_buffers *kept = &p->pool.kept;
    if (!p->context.settings.keep_islands) return true;
    kept->bodies.count = kept->contacts.count = kept->rows.count = 0;
    return pinch_reserve_problem(kept, p->graph.bodies.count, p->contacts.results.count, p->joints.row_room);
}

/* Brings contacts and islands up to date. The contact joints are disabled by the time joints are looked at. */
static bool build_islands(pinch_ode *p)
{
    if (!pinch_pairs_update(&p->contacts, &p->context, p->pool.workers)) return false;
    pinch_disable_contact_joints(&p->contacts);
    return pinch_update_islands(&p->graph, &p->contacts, &p->joints, &p->context, &p->stats) && keep_problems(p);
}

pinch_status pinch_ode_solve(pinch_ode *p, double h)
{
    if (!p || !(h > 0) || !isfinite(h) || p->solved) return PINCH_INVALID_ARGUMENT;
    call_threads(p);
    watch_world(p, h);
    pinch_drop_forgotten(p);
    if (!build_islands(p)) {
        p->graph.count = 0; /* none has been solved */
        return abandon(p, PINCH_OUT_OF_MEMORY);
    }
    pinch_status status = solve_islands(p);
    if (status != PINCH_OK) return abandon(p, status);
    pinch_put_to_sleep(&p->graph);
    conclude_pairs(p);
    if (p->contacts.results.count > p->stats.points_high_water) p->stats.points_high_water = p->contacts.results.count;
    p->solved = true;
    if (!p->context.solve_and_advance) pinch_workers_dismiss(p->pool.workers);
    return PINCH_OK;
}

/* ---- after ODE's step ---- */

/* ODE's steps miss what was solved by what the forces are not exact to, the lighter a body the more; stops are met that
 * much early (joints/row_builder.c). What one island misses counts for all joints, and is forgotten in some tens of
 * steps, as it comes and goes with the load. */
static void fade_noise(pinch_ode *p)
{
    static const double LEFT = 0.95;
    for (int i = 0; i < 2; i++) p->context.noise[i] *= LEFT;
}

static void conclude_step(pinch_ode *p, pinch_island *island)
{
    pinch_ode_stats *stats = &p->stats;
    if (island->phase == PINCH_ISLAND_RESTING) pinch_steady_orientations(&p->context, &p->graph.bodies, island);
    pinch_judge_fallback(&p->context, &p->graph, island, stats);
    pinch_keep_account(&p->context, &p->graph, island);
    *(island->joints.by_pinch ? &stats->joints_solved : &stats->joints_left) +=
        pinch_island_is_solved(island) ? island->joints.range.count : 0;
    keep_larger(&stats->step_mismatch, island->mismatch[0]);
    keep_larger(&stats->step_mismatch_angular, island->mismatch[1]);
    for (int i = 0; i < 2 && pinch_island_is_solved(island); i++)
        keep_larger(&p->context.noise[i], island->mismatch[i]);
}

/* From here on, what comes may be as it was in this step. */
static void begin_next_step(pinch_ode *p)
{
    dJointGroupEmpty(p->context.joint_group);
    pinch_finish_contacts(&p->contacts);
    p->graph.handed.count = 0;
    p->solved = p->context.solve_and_advance = false;
    p->last_h = p->context.h;
    p->context.number++;
    p->stats.steps++;
    pinch_trim_solver_pool(&p->pool, p->context.number);
}

static bool slowed_in_ode(const pinch_island *island)
{
    return island->phase == PINCH_ISLAND_FALLBACK && island->joints.slowed && island->joints.pace < 1;
}

/* ODE walks through its lists of all bodies and all joints several times and marks each, whatever there is to do. One
 * after the other, as it meets them, they would have to come from memory; asked for together they come into the cache.
 */
static void prefetch_lists_of_ode(const pinch_ode *p)
{
    for (int i = 0; i < p->graph.bodies.count; i++)
        pinch_prefetch_to_write(p->graph.bodies.items[i].body, PINCH_CACHE_LINE);
    for (int i = 0; i < p->joints.attached.count; i++)
        pinch_prefetch_to_write(p->joints.attached.items[i].joint, PINCH_JOINT_IN_LIST);
    for (int i = 0; i < p->graph.kinematic.count; i++)
        pinch_prefetch_to_write(p->graph.kinematic.items[i].body, PINCH_CACHE_LINE);
}

/* Would ODE's step do nothing but walk through its lists, because all of its bodies are aside? Where bodies sleep, it
 * may have to wake some. */
static bool nothing_left_to_ode(const pinch_ode *p)
{
    int aside = 0;
    if (p->body_count < 0 || p->graph.sleepers) return false;
    for (int k = 0; k < p->graph.count; k++) aside += p->graph.items[k].aside;
    return aside == p->body_count;
}

/* Has ODE step. The joints of islands that it solves in Pinch's place take errors of position back at their pace; those
 * that have the world's ERP set the pace of all joints that do. */
static int step_ode(pinch_ode *p, double h)
{
    dWorldID world = p->context.world;
    double erp = dWorldGetERP(world), pace = 1;
    for (int k = 0; k < p->graph.count; k++) {
        const pinch_island *island = &p->graph.items[k];
        if (!slowed_in_ode(island)) continue;
        pinch_slow_ode_joints(&p->joints, &island->joints);
        pace = fmin(pace, island->joints.pace);
    }
    if (pace < 1) dWorldSetERP(world, pace * erp);
    if (p->graph.count > MANY || p->graph.bodies.count > MANY_BODIES) prefetch_lists_of_ode(p);
    pinch_hold_sleep_of_ode(&p->graph);
    int stepped = p->context.settings.stepper == PINCH_ODE_QUICKSTEP ? dWorldQuickStep(world, h) : dWorldStep(world, h);
    pinch_release_sleep_of_ode(&p->graph);
    if (pace < 1) dWorldSetERP(world, erp);
    for (int k = 0; k < p->graph.count; k++)
        if (slowed_in_ode(&p->graph.items[k])) pinch_restore_ode_joints(&p->joints, &p->graph.items[k].joints);
    return stepped;
}

/* Has all islands go on from what ODE, or Pinch in its place, makes of their bodies. */
static void go_on(pinch_ode *p)
{
    dWorldGetGravity(p->context.world, p->context.gravity_now);
    pinch_move_shared_bodies(&p->context, &p->graph, p->stepped);
    make_pass(&(island_pass){p, carry_on, true, tell_geoms});
    fade_noise(p);
    for_each_island_in_order(p, conclude_step);
}

pinch_status pinch_ode_advance(pinch_ode *p, double h)
{
    if (!p || !p->solved || h != p->context.h) return PINCH_INVALID_ARGUMENT; /* the forces are those of its step */
    call_threads(p);
    if (p->joints.count > 0 && !p->context.solve_and_advance) for_each_island(p, give_joint_forces, false);
    if (p->graph.sleepers) for_each_island_in_order(p, link_jointed);
    pinch_leave_servos_to_ode(&p->joints.servos, &p->context);
    pinch_leave_couplings_to_ode(&p->joints.couplings, &p->context, &p->graph.bodies);
    for_each_island(p, set_bodies_aside, false);
    p->stepped = nothing_left_to_ode(p) || step_ode(p, h);
    pinch_read_servos_of_ode(&p->joints.servos);
    pinch_couplings_stepped(&p->joints.couplings);
    pinch_read_fallback_contacts(&p->contacts, &p->graph);
    go_on(p);
    pinch_workers_dismiss(p->pool.workers);
    begin_next_step(p);
    return p->stepped ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}

pinch_status pinch_solve_to_advance(pinch_ode *p, double h)
{
    if (!p) return PINCH_INVALID_ARGUMENT;
    bool before = p->context.solve_and_advance;
    p->context.solve_and_advance = true;
    pinch_status status = pinch_ode_solve(p, h);
    if (status != PINCH_OK) p->context.solve_and_advance = before;
    return status;
}

pinch_status pinch_ode_step(pinch_ode *p, double h)
{
    pinch_status status = pinch_solve_to_advance(p, h);
    return status == PINCH_OK ? pinch_ode_advance(p, h) : status;
}
