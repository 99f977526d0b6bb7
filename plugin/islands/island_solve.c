/* The solve of one island: its problem is filled in, solved, checked and read out. */
#include "islands/island_life.h"

#include "joints/island_joints.h"

#include "support/extremes.h"
#include "support/loop.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Lays out the island's problem, still empty, in the thread's buffers or where it has to stay. Returns false when
 * memory runs out. */
static bool lay_out(const pinch_step_context *context, const pinch_island_graph *graph, pinch_solver_pool *pool,
                    int worker, const pinch_island *island, pinch_problem *problem)
{
    bool keep = context->settings.keep_islands;
    pinch_problem_buffers *buffers = keep ? &pool->kept : &pool->thread[worker].buffers;
    if (!keep &&
        !pinch_reserve_problem(buffers, island->bodies.count, island->contacts.count, island->joints.room.count))
        return false;
    *problem = (pinch_problem){
        .step = context->h,
        .faces = context->settings.faces,
        .memory = context->settings.cold_start ? NULL : graph->memories.items[island - graph->items],
        .crew = pinch_crew_of(pool, island),
        .keep_trial = keep || context->settings.recorder,
        .tag = (uint64_t)(uintptr_t)pinch_island_body(&graph->bodies, island->bodies, 0)->body,
        .body_count = island->bodies.count,
        .contact_count = island->contacts.count,
        .bodies = buffers->bodies.items + (keep ? island->bodies.first : 0),
        .contacts = buffers->contacts.items + (keep ? island->contacts.first : 0),
        .rows = buffers->rows.items + (keep ? island->joints.room.first : 0),
    };
    return true;
}

typedef struct fill_task {
    const pinch_step_context *context;
    const pinch_step_bodies *bodies;
    const pinch_island *island;
    pinch_problem *problem;
} fill_task;

static void fill_bodies(void *argument, int first, int end)
{
    enum { AHEAD = 8 };
    const fill_task *task = argument;
    const pinch_range bodies = task->island->bodies;
    for (int k = first; k < end; k++) {
        if (k + AHEAD < end) pinch_prefetch_body(pinch_island_body(task->bodies, bodies, k + AHEAD)->body);
        pinch_fill_step_body(task->context, &task->bodies->drives, pinch_island_body(task->bodies, bodies, k),
                             &task->problem->bodies[k]);
    }
}

static void fill(const pinch_step_context *context, const pinch_contact_store *contacts,
                 const pinch_step_bodies *bodies, pinch_joint_store *joints, pinch_island *island,
                 pinch_problem *problem)
{
    fill_task task = {context, bodies, island, problem};
    pinch_loop(problem->crew, problem->body_count, fill_bodies, &task);
    pinch_fill_joints(joints, context, bodies, &island->joints, problem);
    for (int k = 0; k < problem->body_count; k++) pinch_apply_external(&problem->bodies[k], context->h);
    pinch_fill_contacts(context, contacts, bodies, island, problem);
    pinch_limit_drives(contacts, bodies, island, false, problem);
}

/* Rows that contradict each other have forces in proportion to what they miss. Where they are to miss less, they start
 * from none. */
static void forget_row_forces(pinch_problem *problem)
{
    for (int k = 0; k < problem->row_count; k++) problem->rows[k].force = 0;
}

static void forget_warm_start(pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) {
        memset(problem->contacts[k].force, 0, sizeof problem->contacts[k].force);
        memset(problem->contacts[k].rolling_moment, 0, sizeof problem->contacts[k].rolling_moment);
    }
    forget_row_forces(problem);
}

/* Tells whether velocities are so large that no body has them, and that their squares soon are no numbers. */
static bool overflows(const pinch_problem *problem)
{
    static const double LARGEST = 1e100;
    for (int b = 0; b < problem->body_count; b++)
        for (int i = 0; i < 6; i++)
            if (!(fabs(problem->bodies[b].velocity_end[i]) < LARGEST)) return true;
    return false;
}

/* The settings of an attempt: the solver asked for, then NSNMGK with Newton's steps, then Newton alone. */
static pinch_solver_settings settings_of(const pinch_step_context *context, const pinch_island_graph *graph,
                                         const pinch_island *island, int attempt)
{
    pinch_solver_settings settings = context->settings.solver;
    if (settings.budget == 0)
        settings.budget = pinch_budget_of(context, island, pinch_went_wrong_lately(context, graph, island));
    if (!pinch_island_may_be_swept(context, island))
        settings.sweeps = 0;
    else if (settings.sweeps == 0)
        settings.sweeps = dWorldGetQuickStepNumIterations(context->world);
    settings.sweeps_alone = island->sweeps_alone;
    if (attempt == 1) settings.newton_finish = true;
    if (attempt > 0) settings.solver = attempt == 1 ? PINCH_SOLVER_NSNMGK : PINCH_SOLVER_NEWTON;
    return settings;
}

/* Tries solvers in the declared order: the one asked for, from the last forces; NSNMGK with Newton's steps from no
 * forces; Newton alone from none. The island is solved where one of them converged. Driven fingers that run away in an
 * answer are bounded in the next. */
static void try_solvers(const pinch_step_context *context, const pinch_contact_store *contacts,
                        const pinch_island_graph *graph, pinch_solver_thread *thread, pinch_problem *problem,
                        pinch_island *island)
{
    const pinch_step_bodies *bodies = &graph->bodies;
    pinch_step_result *result = &island->result;
    int number = (int)(island - graph->items);
    bool solved = false;
    pinch_problem before;
    island->tried = !island->sweeps_alone;
    result->over_budget = false;
    for (int attempt = 0; attempt < 3 && !solved && !result->over_budget; attempt++) {
        pinch_solver_settings settings = settings_of(context, graph, island, attempt);
        if (attempt > 0) pinch_limit_drives(contacts, bodies, island, true, problem);
        if (attempt > 0 || context->settings.cold_start) forget_warm_start(problem);
        if (attempt == 0) pinch_begin_recording(context, thread, problem, &before);
        island->status = pinch_step_solve(thread->solver, problem, &settings, result);
        if (attempt == 0 && island->status == PINCH_OK)
            pinch_end_recording(context, number, &settings, &before, problem, result);
        if (pinch_drives_run_away(contacts, bodies, island, problem)) {
            pinch_limit_drives(contacts, bodies, island, true, problem);
            forget_warm_start(problem);
            island->status = pinch_step_solve(thread->solver, problem, &settings, result);
        }
        if (island->status == PINCH_UNSUPPORTED) continue; /* the reference methods do not know all laws */
        if (island->status != PINCH_OK) return;
        solved = result->solve.status == PINCH_SOLVE_CONVERGED || result->swept;
        if (solved && attempt == 0) island->first_solve_failed = false;
    }
    /* numbers that overflow in here would do so in ODE's solver, too */
    bool overflow = result->solve.status == PINCH_SOLVE_DIVERGED || (solved && overflows(problem));
    island->status = overflow ? PINCH_INVALID_ARGUMENT : PINCH_OK;
    if (solved && !overflow) island->phase = PINCH_ISLAND_SOLVED;
}

/* Tells whether the island's joints will be those of this solve. */
static bool joints_are_known(const pinch_joint_store *joints, const pinch_island *island)
{
    for (int k = 0; k < island->joints.range.count; k++)
        if (!pinch_island_joint(joints, &island->joints, k)->exact) return false;
    return island->joints.range.count > 0;
}

/*
 * Tells whether ODE solves an island without contacts as well as Pinch. dWorldStep's direct method is exact for joints
 * with their motors and stops, and costs more only where there are many rows, by the third power. But it takes errors
 * of position back whatever energy that puts in (energy_account.c). In loops it may be much, and in trees it is where
 * joints are torn. Quickstep's sweeps are not exact. Joints that are not known in full are ODE's in any case.
 */
static bool ode_does_as_well(const pinch_step_context *context, const pinch_step_bodies *bodies,
                             const pinch_joint_store *joints, pinch_island *island, const pinch_problem *problem)
{
    enum { FEW_ROWS = 60 };
    if (island->contacts.count > 0 || island->joints.couplings.count > 0) return false;
    if (!joints_are_known(joints, island) || context->settings.joints_by_ode) return true;
    return context->settings.stepper == PINCH_ODE_WORLDSTEP && island->joints.row_count <= FEW_ROWS &&
           !pinch_joints_close_loops(joints, bodies, island->bodies, &island->joints) &&
           pinch_errors_are_small(context, joints, island, problem);
}

/*
 * Solves an island with joints that keep their errors of position, after none was found that takes them back. Rows that
 * ask for different things contradict each other no more then, and contacts need not give way to joints that close.
 */
static void solve_without_closing(const pinch_step_context *context, const pinch_contact_store *contacts,
                                  const pinch_island_graph *graph, const pinch_joint_store *joints,
                                  pinch_solver_thread *thread, pinch_problem *problem, pinch_island *island)
{
    pinch_island_joints *j = &island->joints;
    pinch_set_closing_pace(joints, j, problem, j->pace, 0);
    j->pace = 0;
    forget_warm_start(problem);
    try_solvers(context, contacts, graph, thread, problem, island);
    island->first_solve_failed = true;
}

/* Returns the part of a pace at which no more than `most` should be put in, after `work` was; no_try_left: 0. Work goes
 * with the pace where forces hold what it moves, and with its square where it is that motion. */
static double slower(double pace, double most, double work, bool no_try_left)
{
    return no_try_left || !(most > 0) ? 0 : 0.5 * pace * sqrt(most / work);
}

/* Tells whether joints have put more energy in than they may. */
static bool joints_put_too_much_in(const pinch_step_context *context, const pinch_joint_store *joints,
                                   const pinch_island_graph *graph, const pinch_problem *problem, pinch_island *island)
{
    pinch_island_joints *j = &island->joints;
    if (j->joint_rows == 0) return false;
    j->work = pinch_joint_work(joints, j, &graph->bodies, island->bodies, problem);
    if ((island->result.too_soft || island->result.gave_way) && !j->torn) pinch_close_overdraft(j);
    j->lifting = 0;
    if (j->work > j->energy) {
        bool loops = pinch_joints_close_loops(joints, &graph->bodies, island->bodies, j);
        double fall = pinch_fall_in_step(context);
        j->lifting = pinch_joint_lifting(joints, j, &graph->bodies, problem, loops, fall);
    }
    j->put_energy_in = !(j->work <= j->energy + j->lifting);
    return j->put_energy_in;
}

/* How contacts push in a try: hard ones at a part of the pace that their overlaps ask for, and where they let go,
 * without springs of friction and surfaces that move along them; those whose partner drives bodies on at a part of its
 * velocity. */
typedef struct push {
    double pace, bounce, partners;
    bool let_go;
} push;

/* Fills in the contacts anew, as they came but for how they push. */
static void push_at(const pinch_step_context *context, const pinch_contact_store *contacts,
                    const pinch_step_bodies *bodies, pinch_problem *problem, pinch_island *island, const push *p)
{
    pinch_fill_contacts(context, contacts, bodies, island, problem);
    pinch_slow_push_out(contacts, island, p->pace, p->bounce, problem);
    if (p->let_go) pinch_let_go(contacts, island, problem);
    if (p->partners < 1) pinch_slow_partners(contacts, island, p->partners, problem);
    forget_row_forces(problem);
    island->phase = PINCH_ISLAND_AWAKE;
}

/*
 * Solves an island with joints or hard contacts. Where joints would put in more energy than they may as they take
 * errors of position back, or hard contacts as they push bodies out of each other, these do it more slowly. Where
 * contacts that push more slowly have no answer, the first one stands: ODE would push as fast.
 */
static void solve_in_bounds(const pinch_step_context *context, const pinch_contact_store *contacts,
                            const pinch_island_graph *graph, pinch_joint_store *joints, pinch_solver_thread *thread,
                            pinch_problem *problem, pinch_island *island)
{
    enum { TRIES = 4, WITH_PARTNERS = TRIES + 2 }; /* the last two hold back partners that drive bodies on */
    static const double NEARLY = 0.9; /* what they give goes with the square of their pace, if nothing else moves */
    pinch_island_joints *j = &island->joints;
    const pinch_step_bodies *bodies = &graph->bodies;
    bool jointed = j->joint_rows > 0, known = !jointed || joints_are_known(joints, island), last = false;
    bool pushes = pinch_open_push(context, contacts, graph, problem, island);
    if (jointed) pinch_open_account(context, graph, joints, problem, island);
    if (jointed && j->pace < 1) pinch_set_closing_pace(joints, j, problem, 1, j->pace);
    double first_pace = j->pace;
    push p = {pushes ? island->push_pace : 1, 1, 1, false};
    if (p.pace < 1) pinch_slow_push_out(contacts, island, p.pace, 1, problem);
    for (int try = 0;; try++) {
        try_solvers(context, contacts, graph, thread, problem, island);
        bool may_wait = jointed && j->pace > 0 && !island->result.over_budget && known;
        if (island->status == PINCH_OK && !pinch_island_is_solved(island) && may_wait)
            solve_without_closing(context, contacts, graph, joints, thread, problem, island);
        if (island->status == PINCH_OK && !pinch_island_is_solved(island) && p.pace < 1) {
            fill(context, contacts, bodies, joints, island, problem);
            j->pace = first_pace;
            if (jointed && j->pace < 1) pinch_set_closing_pace(joints, j, problem, 1, j->pace);
            try_solvers(context, contacts, graph, thread, problem, island);
            last = try > 0;
            p = (push){1, 1, 1, false};
        }
        if (!pinch_island_is_solved(island)) return;
        bool put_in = joints_put_too_much_in(context, joints, graph, problem, island);
        if (pushes) pinch_judge_push(context, contacts, bodies, problem, island);
        bool pushed_in = pushes && !(island->push_work <= island->push_limit);
        double of_partners = pinch_most_of_partners(island);
        bool runs_away = pushed_in && p.let_go && island->push_work > of_partners;
        if ((!put_in && !pushed_in) || last || try == WITH_PARTNERS || (jointed && !isfinite(j->work)) || !known) break;
        if (try >= TRIES && !runs_away) break;
        p.let_go = p.let_go || (pushed_in && p.pace == 0);
        if (pushed_in) p.bounce = p.pace = slower(p.pace, island->push_limit, island->push_work, try >= TRIES - 2);
        if (try >= TRIES) p.partners = try > TRIES ? 0 : NEARLY * sqrt(of_partners / island->push_work);
        push_at(context, contacts, bodies, problem, island, &p);
        if (!put_in) continue;
        double pace = slower(j->pace, j->energy + j->lifting, j->work, try >= TRIES - 2);
        pinch_set_closing_pace(joints, j, problem, j->pace, pace);
        j->pace = pace;
    }
    if (pushes) pinch_close_push(context, problem, p.pace, island);
}

/* Reading an answer out, and giving it to ODE. */
typedef struct answer_task {
    pinch_step_bodies *bodies;
    pinch_island *island;
    const pinch_problem *problem;
} answer_task;

static void read_bodies(void *argument, int first, int end)
{
    const answer_task *task = argument;
    for (int k = first; k < end; k++) {
        pinch_step_body *b = pinch_island_body(task->bodies, task->island->bodies, k);
        const pinch_body *solved = &task->problem->bodies[k];
        pinch_v3_copy(b->position, solved->position);
        memcpy(b->velocity, solved->velocity_end, sizeof b->velocity);
    }
}

static void give_forces(void *argument, int first, int end)
{
    const answer_task *task = argument;
    pinch_step_bodies *bodies = task->bodies;
    const pinch_range range = task->island->bodies;
    for (int k = first; k < end; k++) pinch_give_contact_forces(&bodies->drives, pinch_island_body(bodies, range, k));
}

/* Clears what the last step's solve has left in an island that is still the same. */
static void clear_answer(const pinch_step_bodies *bodies, const pinch_joint_store *joints, pinch_island *island)
{
    for (int k = 0; k < island->bodies.count; k++) {
        pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        memset(b->wrench, 0, sizeof b->wrench);
    }
    for (int k = 0; k < island->joints.range.count; k++) pinch_island_joint(joints, &island->joints, k)->found = false;
    if (island->phase != PINCH_ISLAND_ASLEEP) island->phase = PINCH_ISLAND_AWAKE;
    island->tried = false;
    island->first_solve_failed = true;
    island->joints.by_pinch = island->joints.put_energy_in = island->pushes = false;
    island->depth_max = island->mismatch[0] = island->mismatch[1] = 0;
    island->drive_rows = island->drives_at_limit = 0;
}

void pinch_take_back_island_forces(const pinch_step_bodies *bodies, const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count && pinch_island_is_solved(island); k++)
        pinch_take_back_contact_forces(&bodies->drives, pinch_island_body(bodies, island->bodies, k));
}

/* Would the rounding of forces show in the velocities that they sum up to? In jams they may be of 1e8 N and cancel.
 * Where it would be a motion that counts, the forces are not to be trusted, and nothing is to hide that. */
static bool rounding_moves_bodies(const pinch_problem *problem)
{
    static const double SHOWS = 1e-12, COUNTS = 1e-6; /* m/s */
    double largest = 0, lightest = INFINITY;
    for (int k = 0; k < problem->contact_count; k++) largest = pinch_larger(problem->contacts[k].force[0], largest);
    for (int k = 0; k < problem->row_count; k++) largest = pinch_larger(fabs(problem->rows[k].force), largest);
    for (int k = 0; k < problem->body_count; k++)
        if (problem->bodies[k].mass > 0) lightest = fmin(lightest, problem->bodies[k].mass);
    double rounded = DBL_EPSILON * largest * problem->step / lightest;
    return rounded > SHOWS && rounded < COUNTS;
}

/* Reads out the answer and gives it to ODE. Returns false where it cannot be trusted, and nothing is given. */
static bool give_answer(const pinch_step_context *context, pinch_contact_store *contacts, pinch_island_graph *graph,
                        pinch_joint_store *joints, pinch_island *island, const pinch_problem *problem)
{
    pinch_step_bodies *bodies = &graph->bodies;
    answer_task task = {.bodies = bodies, .island = island, .problem = problem};
    pinch_loop(problem->crew, island->bodies.count, read_bodies, &task);
    pinch_read_joints(joints, &island->joints, problem);
    island->drives_at_limit = pinch_drives_at_limit(island, problem);
    pinch_read_out_contacts(contacts, bodies, island, problem);
    bool rounds = rounding_moves_bodies(problem);
    if (island->result.dependent_rows > 0 || rounds)
        pinch_share_joint_forces(joints, bodies, island->bodies, &island->joints, problem, rounds);
    pinch_loop(problem->crew, island->bodies.count, give_forces, &task);
    if (context->solve_and_advance)
        pinch_give_joint_forces(joints, context, bodies, island->bodies, &island->joints, problem);
    if (!pinch_joint_fallback_needed(context, bodies, island)) return true;
    pinch_take_back_island_forces(bodies, island);
    pinch_enable_joints(joints, &island->joints);
    island->joints.by_pinch = false;
    return false;
}

void pinch_solve_island(const pinch_step_context *context, pinch_contact_store *contacts, pinch_island_graph *graph,
                        pinch_joint_store *joints, pinch_solver_pool *pool, int worker, pinch_island *island)
{
    const pinch_step_bodies *bodies = &graph->bodies;
    pinch_solver_thread *thread = &pool->thread[worker];
    pinch_problem problem;
    if (pinch_island_unchanged(context, contacts, bodies, joints, &thread->buffers, island)) {
        pinch_reuse_answer(context, bodies, joints, island);
        return;
    }
    clear_answer(bodies, joints, island);
    if (island->phase == PINCH_ISLAND_ASLEEP && !context->settings.keep_islands) {
        pinch_leave_unsolved(contacts, island);
        return;
    }
    if (!lay_out(context, graph, pool, worker, island, &problem)) {
        island->status = PINCH_OUT_OF_MEMORY;
        return;
    }
    fill(context, contacts, bodies, joints, island, &problem);
    bool awake = island->phase != PINCH_ISLAND_ASLEEP;
    if (awake && ode_does_as_well(context, bodies, joints, island, &problem)) {
        island->phase = PINCH_ISLAND_LEFT;
        island->first_solve_failed = false;
        return;
    }
    bool waits = awake && pinch_backoff_holds(context, graph, island);
    island->sweeps_alone = waits && pinch_island_may_be_swept(context, island);
    if (waits && !island->sweeps_alone) {
        island->first_solve_failed = false; /* none has been tried */
        pinch_leave_unsolved(contacts, island);
        return;
    }
    if (awake && !context->settings.ode_solves)
        solve_in_bounds(context, contacts, graph, joints, thread, &problem, island);
    if (!pinch_island_is_solved(island)) {
        pinch_leave_unsolved(contacts, island);
        return;
    }
    bool jointed = island->joints.range.count > 0;
    bool verified = island->result.solve.status == PINCH_SOLVE_CONVERGED;
    bool rests = verified && (!jointed || context->solve_and_advance) &&
                 pinch_island_at_rest(context, contacts, bodies, island, &problem);
    if (rests) pinch_make_steady(contacts, island, &problem);
    if (!give_answer(context, contacts, graph, joints, island, &problem)) {
        pinch_leave_unsolved(contacts, island);
        return;
    }
    if (!rests || (jointed && !island->joints.by_pinch)) return;
    island->phase = PINCH_ISLAND_RESTING;
    pinch_balance_gravity(context, bodies, island);
    island->joints.rest_bits = pinch_joint_bits(&island->joints, &problem);
    pinch_remember_joint_inputs(joints, &island->joints);
}
