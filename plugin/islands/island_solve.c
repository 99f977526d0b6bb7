/* The solve of one island: its problem is filled in, solved, checked and read out. */
#include "islands/island_life.h"

#include "joints/island_joints.h"

#include "support/extremes.h"
#include "support/loop.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A solve of an island on its way. */
typedef struct island_solve {
    const pinch_step_context *context;
    pinch_contact_store *contacts;
    pinch_island_graph *graph;
    const pinch_step_bodies *bodies; /* the graph's */
    pinch_joint_store *joints;
    pinch_solver_thread *thread;
    pinch_island *island;
    pinch_problem problem;
} island_solve;

/* Lays out the island's problem, still empty, in the thread's buffers or where it has to stay. Returns false when
 * memory runs out. */
static bool lay_out(island_solve *s, pinch_solver_pool *pool)
{
    const pinch_step_context *context = s->context;
    const pinch_island *island = s->island;
    bool keep = context->settings.keep_islands;
    pinch_problem_buffers *buffers = keep ? &pool->kept : &s->thread->buffers;
    if (!keep &&
        !pinch_reserve_problem(buffers, island->bodies.count, island->contacts.count, island->joints.room.count))
        return false;
    s->problem = (pinch_problem){
        .step = context->h,
        .faces = context->settings.faces,
        .memory = context->settings.cold_start ? NULL : s->graph->memories.items[island - s->graph->items],
        .crew = pinch_crew_of(pool, island),
        .keep_trial = keep || context->settings.recorder,
        .tag = (uint64_t)(uintptr_t)pinch_island_body(s->bodies, island->bodies, 0)->body,
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

static void apply_external(void *argument, int first, int end)
{
    const fill_task *task = argument;
    for (int k = first; k < end; k++) pinch_apply_external(&task->problem->bodies[k], task->context->h);
}

static void fill(island_solve *s)
{
    pinch_problem *problem = &s->problem;
    fill_task task = {s->context, s->bodies, s->island, problem};
    pinch_each(problem->crew, problem->body_count, fill_bodies, &task);
    pinch_fill_joints(s->joints, s->context, s->bodies, &s->island->joints, problem);
    pinch_each(problem->crew, problem->body_count, apply_external, &task);
    pinch_fill_contacts(s->context, s->contacts, s->bodies, s->island, problem);
    pinch_limit_drives(s->contacts, s->bodies, s->island, false, problem);
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
static pinch_solver_settings settings_of(const island_solve *s, int attempt)
{
    const pinch_step_context *context = s->context;
    const pinch_island *island = s->island;
    pinch_solver_settings settings = context->settings.solver;
    int iterations = dWorldGetQuickStepNumIterations(context->world);
    if (settings.budget == 0)
        settings.budget = pinch_budget_of(context, island, pinch_went_wrong_lately(context, s->graph, island));
    if (!pinch_island_may_be_swept(context, island))
        settings.sweeps = 0;
    else if (settings.sweeps == 0)
        settings.sweeps = iterations > 0 ? iterations : 0;
    settings.sweeps_alone = island->sweeps_alone;
    if (attempt == 1) settings.newton_finish = true;
    if (attempt > 0) settings.solver = attempt == 1 ? PINCH_SOLVER_NSNMGK : PINCH_SOLVER_NEWTON;
    return settings;
}

/* Tries solvers in the declared order: the one asked for, from the last forces; NSNMGK with Newton's steps from no
 * forces; Newton alone from none. The island is solved where one of them converged. Driven fingers that run away in an
 * answer are bounded in the next. */
static void try_solvers(island_solve *s)
{
    const pinch_step_context *context = s->context;
    pinch_problem *problem = &s->problem;
    pinch_island *island = s->island;
    pinch_step_result *result = &island->result;
    int number = (int)(island - s->graph->items);
    bool solved = false;
    pinch_problem before;
    island->tried = !island->sweeps_alone;
    result->over_budget = false;
    for (int attempt = 0; attempt < 3 && !solved && !result->over_budget; attempt++) {
        pinch_solver_settings settings = settings_of(s, attempt);
        if (attempt > 0) pinch_limit_drives(s->contacts, s->bodies, island, true, problem);
        if (attempt > 0 || context->settings.cold_start) forget_warm_start(problem);
        if (attempt == 0) pinch_begin_recording(context, s->thread, problem, &before);
        island->status = pinch_step_solve(s->thread->solver, problem, &settings, result);
        if (attempt == 0 && island->status == PINCH_OK)
            pinch_end_recording(context, number, &settings, &before, problem, result);
        if (island->status == PINCH_OK && pinch_drives_run_away(s->contacts, s->bodies, island, problem)) {
            pinch_limit_drives(s->contacts, s->bodies, island, true, problem);
            forget_warm_start(problem);
            island->status = pinch_step_solve(s->thread->solver, problem, &settings, result);
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
static bool ode_does_as_well(const island_solve *s)
{
    enum { FEW_ROWS = 60 };
    const pinch_step_context *context = s->context;
    const pinch_joint_store *joints = s->joints;
    pinch_island *island = s->island;
    if (island->contacts.count > 0 || island->joints.couplings.count > 0) return false;
    if (!joints_are_known(joints, island) || context->settings.joints_by_ode) return true;
    return context->settings.stepper == PINCH_ODE_WORLDSTEP && island->joints.row_count <= FEW_ROWS &&
           !pinch_joints_close_loops(joints, s->bodies, island->bodies, &island->joints) &&
           pinch_errors_are_small(context, joints, island, &s->problem);
}

/*
 * Solves an island with joints that keep their errors of position, after none was found that takes them back. Rows that
 * ask for different things contradict each other no more then, and contacts need not give way to joints that close.
 */
static void solve_without_closing(island_solve *s)
{
    pinch_island_joints *j = &s->island->joints;
    pinch_set_closing_pace(s->joints, j, &s->problem, j->pace, 0);
    j->pace = 0;
    forget_warm_start(&s->problem);
    try_solvers(s);
    s->island->first_solve_failed = true;
}

/* Returns the part of a pace at which no more than `most` should be put in, after `work` was; no_try_left: 0. Work goes
 * with the pace where forces hold what it moves, and with its square where it is that motion. */
static double slower(double pace, double most, double work, bool no_try_left)
{
    return no_try_left || !(most > 0) ? 0 : 0.5 * pace * sqrt(most / work);
}

/* Tells whether joints have put more energy in than they may. */
static bool joints_put_too_much_in(island_solve *s)
{
    pinch_island *island = s->island;
    pinch_island_joints *j = &island->joints;
    if (j->joint_rows == 0) return false;
    j->work = pinch_joint_work(s->joints, j, s->bodies, island->bodies, &s->problem);
    if ((island->result.too_soft || island->result.gave_way) && !j->torn) pinch_close_overdraft(j);
    j->lifting = 0;
    bool loops = pinch_joints_close_loops(s->joints, s->bodies, island->bodies, j);
    j->closing_work = pinch_work_of_closing(s->joints, j, &s->problem, loops || island->contacts.count > 0);
    if (j->work > pinch_joints_may_put_in(j)) {
        double fall = pinch_fall_in_step(s->context);
        j->lifting = pinch_joint_lifting(s->joints, j, s->bodies, &s->problem, loops, fall);
    }
    j->put_energy_in = !(j->work <= pinch_joints_may_put_in(j));
    return j->put_energy_in;
}

/* How contacts push in a try: hard ones at a part of the pace that their overlaps ask for, and where they let go,
 * without springs of friction and surfaces that move along them; those whose partner drives bodies on at a part of its
 * velocity. */
typedef struct push {
    double pace, bounce, partners;
    bool let_go;
} push;

static const push AS_THEY_CAME = {1, 1, 1, false};

/*
 * Returns a pace that contacts may be slowed to where all that overlaps ask for is too much, if they were slowed to
 * `last` in the step before. Bodies that come out at a pace need no energy to go on at it, and a little for a little
 * more, as it goes with the square of the pace. If each step began from rest, a pile would sink into contacts that give
 * way under their load, and take more energy to lift the deeper it is.
 */
static double pace_to_go_on(const pinch_island *island, double last)
{
    if (!(last < 1 && island->push_limit > 0)) return 0;
    return fmin(sqrt(last * last + 0.5 * island->push_limit / island->push_work), 0.5 * (last + 1));
}

/* Fills in the contacts anew, as they came but for how they push. */
static void push_at(island_solve *s, const push *p)
{
    pinch_fill_contacts(s->context, s->contacts, s->bodies, s->island, &s->problem);
    pinch_slow_push_out(s->contacts, s->island, &s->thread->rise, p->pace, p->bounce, &s->problem);
    if (p->let_go) pinch_let_go(s->contacts, s->island, &s->problem);
    if (p->partners < 1) pinch_slow_partners(s->contacts, s->island, p->partners, &s->problem);
    forget_row_forces(&s->problem);
    s->island->phase = PINCH_ISLAND_AWAKE;
}

/* Solves with contacts that push as they came, where no answer was found with slower ones: ODE would push as fast. */
static void solve_as_they_came(island_solve *s, double joint_pace)
{
    pinch_island_joints *j = &s->island->joints;
    fill(s);
    j->pace = joint_pace;
    if (j->joint_rows > 0 && j->pace < 1) pinch_set_closing_pace(s->joints, j, &s->problem, 1, j->pace);
    try_solvers(s);
}

/* What went wrong in a try. */
typedef struct verdict {
    bool joints, contacts; /* these put more energy in than they may */
    bool partners;         /* contacts have let go, and still get much from partners that drive bodies on */
} verdict;

static verdict judge(island_solve *s, bool pushes, const push *p)
{
    pinch_island *island = s->island;
    verdict found = {.joints = joints_put_too_much_in(s)};
    if (pushes) pinch_judge_push(s->context, s->contacts, s->joints, s->bodies, &s->problem, &s->thread->rise, island);
    found.contacts = pushes && !(island->push_work <= island->push_limit);
    found.partners = found.contacts && p->let_go && island->push_work > pinch_most_of_partners(island);
    return found;
}

/* Contacts that give way by a raised floor, or in sweeps, are jammed. */
static bool is_soft(const pinch_step_result *result)
{
    return result->swept || result->too_soft || result->floor_level > 0;
}

/* Does an answer put in no more than the first one may, or did? */
static bool puts_in_as_little(const island_solve *s, const pinch_island *first, verdict found)
{
    static const double SAME = 1.01; /* a full bounce off a partner that drives the body on takes a little more */
    const pinch_island *island = s->island;
    bool joints = !found.joints || island->joints.work <= SAME * first->joints.work;
    return joints && (!found.contacts || island->push_work <= SAME * first->push_work);
}

/*
 * Solves once more where contacts bounced, now with what they gave way by: with their compliance alone a ball would
 * lose 1e-4 of its speed and more in each bounce. Where that has no answer as good as the first, the first stands.
 */
static void bounce_in_full(island_solve *s, bool pushes, const push *p)
{
    if (is_soft(&s->island->result) || !pinch_bounces_fall_short(s->contacts, s->island, &s->problem)) return;
    pinch_island first = *s->island;
    pinch_problem answer;
    if (!pinch_copy_problem(&s->problem, &s->thread->first, &answer)) {
        s->island->status = PINCH_OUT_OF_MEMORY;
        s->island->phase = PINCH_ISLAND_AWAKE;
        return;
    }
    push_at(s, p);
    bool differs = pinch_bounce_in_full(s->contacts, s->island, &s->problem);
    if (differs) try_solvers(s);
    bool solved = differs && pinch_island_is_solved(s->island) && !is_soft(&s->island->result);
    if (solved && puts_in_as_little(s, &first, judge(s, pushes, p))) return;
    pinch_copy_items(&answer, &s->problem);
    *s->island = first;
}

enum { TRIES = 4, WITH_PARTNERS = TRIES + 2 }; /* the last two hold back partners that drive bodies on */

/* Prepares the try after this one, in which what put too much in goes more slowly. */
static void slow_down(island_solve *s, int try, verdict v, push *p)
{
    static const double NEARLY = 0.9; /* what they give goes with the square of their pace, if nothing else moves */
    pinch_island *island = s->island;
    pinch_island_joints *j = &island->joints;
    bool no_try_left = try >= TRIES - 2;
    p->let_go = p->let_go || (v.contacts && p->pace == 0);
    if (v.contacts) {
        double pace = slower(p->pace, island->push_limit, island->push_work, no_try_left);
        if (p->pace == 1) pace = fmax(pace, pace_to_go_on(island, island->push_pace));
        p->bounce = p->pace = pace;
    }
    if (try >= TRIES) p->partners = try > TRIES ? 0 : NEARLY * sqrt(pinch_most_of_partners(island) / island->push_work);
    push_at(s, p);
    if (!v.joints) return;
    double pace = slower(j->pace, pinch_joints_may_put_in(j), j->work, no_try_left);
    pinch_set_closing_pace(s->joints, j, &s->problem, j->pace, pace);
    j->pace = pace;
}

/*
 * Solves an island with joints or hard contacts. Where joints would put in more energy than they may as they take
 * errors of position back, or hard contacts as they push bodies out of each other, these do it more slowly. Where
 * contacts that push more slowly have no answer, the first one stands.
 */
static void solve_in_bounds(island_solve *s)
{
    pinch_island *island = s->island;
    pinch_island_joints *j = &island->joints;
    bool jointed = j->joint_rows > 0, known = !jointed || joints_are_known(s->joints, island), last = false;
    pinch_rise *rise = &s->thread->rise;
    bool pushes = pinch_open_push(s->context, s->contacts, s->graph, &s->problem, rise, island);
    if (island->status != PINCH_OK) return;
    if (jointed) pinch_open_account(s->context, s->graph, s->joints, &s->problem, island);
    if (jointed && j->pace < 1) pinch_set_closing_pace(s->joints, j, &s->problem, 1, j->pace);
    double first_pace = j->pace;
    push p = AS_THEY_CAME;
    if (pushes && jointed) p.pace = island->push_pace;
    rise->slows = false;
    if (pushes) pinch_limit_rise(&s->problem, island->pairs.count, rise);
    if (p.pace < 1 || rise->slows) pinch_slow_push_out(s->contacts, island, rise, p.pace, 1, &s->problem);
    for (int try = 0;; try++) {
        try_solvers(s);
        bool may_wait = jointed && j->pace > 0 && !island->result.over_budget && known;
        if (island->status == PINCH_OK && !pinch_island_is_solved(island) && may_wait) solve_without_closing(s);
        if (island->status == PINCH_OK && !pinch_island_is_solved(island) && (p.pace < 1 || rise->slows)) {
            rise->slows = false;
            solve_as_they_came(s, first_pace);
            last = try > 0;
            p = AS_THEY_CAME;
        }
        if (!pinch_island_is_solved(island)) return;
        verdict v = judge(s, pushes, &p);
        bool good = !v.joints && !v.contacts, judged = known && (!jointed || isfinite(j->work));
        if (good || last || !judged || try == WITH_PARTNERS || (try >= TRIES && !v.partners)) break;
        slow_down(s, try, v, &p);
    }
    bounce_in_full(s, pushes, &p);
    if (pushes) pinch_close_push(s->context, &s->problem, p.pace, island);
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
static bool give_answer(island_solve *s)
{
    const pinch_step_context *context = s->context;
    pinch_step_bodies *bodies = &s->graph->bodies;
    pinch_joint_store *joints = s->joints;
    pinch_island *island = s->island;
    const pinch_problem *problem = &s->problem;
    answer_task task = {.bodies = bodies, .island = island, .problem = problem};
    pinch_each(problem->crew, island->bodies.count, read_bodies, &task);
    pinch_read_joints(joints, &island->joints, problem);
    island->drives_at_limit = pinch_drives_at_limit(island, problem);
    pinch_read_out_contacts(s->contacts, bodies, island, problem);
    bool rounds = rounding_moves_bodies(problem);
    if (island->result.dependent_rows > 0 || rounds)
        pinch_share_joint_forces(joints, bodies, island->bodies, &island->joints, problem, rounds);
    pinch_each(problem->crew, island->bodies.count, give_forces, &task);
    if (context->solve_and_advance)
        pinch_give_joint_forces(joints, context, bodies, island->bodies, &island->joints, problem);
    if (!pinch_joint_fallback_needed(context, bodies, island)) return true;
    pinch_take_back_island_forces(bodies, island);
    pinch_enable_joints(joints, &island->joints);
    island->joints.by_pinch = false;
    return false;
}

/* Tells whether the island goes to ODE without a try: ODE solves it just as well, or it went wrong not long ago. */
static bool goes_without_a_try(island_solve *s)
{
    pinch_island *island = s->island;
    island->sweeps_alone = false;
    if (island->phase == PINCH_ISLAND_ASLEEP) return false;
    if (ode_does_as_well(s)) {
        island->phase = PINCH_ISLAND_LEFT;
        island->first_solve_failed = false;
        return true;
    }
    bool waits = pinch_backoff_holds(s->context, s->graph, island);
    island->sweeps_alone = waits && pinch_island_may_be_swept(s->context, island);
    if (!waits || island->sweeps_alone) return false;
    island->first_solve_failed = false; /* none has been tried */
    pinch_leave_unsolved(s->contacts, island);
    return true;
}

/* Lets an island rest whose answer, which ODE has been given, is one of rest. */
static void let_rest(island_solve *s)
{
    pinch_island *island = s->island;
    if (island->joints.range.count > 0 && !island->joints.by_pinch) return;
    if (island->result.too_soft) return; /* a stiffer answer is tried for now and then */
    island->phase = PINCH_ISLAND_RESTING;
    pinch_balance_gravity(s->context, s->bodies, island);
    island->joints.rest_bits = pinch_joint_bits(&island->joints, &s->problem);
    pinch_remember_joint_inputs(s->joints, &island->joints);
}

void pinch_solve_island(const pinch_step_context *context, pinch_contact_store *contacts, pinch_island_graph *graph,
                        pinch_joint_store *joints, pinch_solver_pool *pool, int worker, pinch_island *island)
{
    const pinch_step_bodies *bodies = &graph->bodies;
    island_solve s = {.context = context,
                      .contacts = contacts,
                      .graph = graph,
                      .bodies = bodies,
                      .joints = joints,
                      .thread = &pool->thread[worker],
                      .island = island};
    if (pinch_island_unchanged(context, contacts, bodies, joints, &s.thread->buffers, island)) {
        pinch_reuse_answer(context, bodies, joints, island);
        return;
    }
    clear_answer(bodies, joints, island);
    if (island->phase == PINCH_ISLAND_ASLEEP && !context->settings.keep_islands) {
        pinch_leave_unsolved(contacts, island);
        return;
    }
    if (!lay_out(&s, pool)) {
        island->status = PINCH_OUT_OF_MEMORY;
        return;
    }
    fill(&s);
    if (goes_without_a_try(&s)) return;
    if (island->phase != PINCH_ISLAND_ASLEEP && !context->settings.ode_solves) solve_in_bounds(&s);
    if (!pinch_island_is_solved(island)) {
        pinch_leave_unsolved(contacts, island);
        return;
    }
    bool verified = island->result.solve.status == PINCH_SOLVE_CONVERGED;
    bool rests = verified && (island->joints.range.count == 0 || context->solve_and_advance) &&
                 pinch_island_at_rest(context, contacts, bodies, island, &s.problem);
    if (rests) pinch_make_steady(contacts, island, &s.problem);
    if (!give_answer(&s))
        pinch_leave_unsolved(contacts, island);
    else if (rests)
        let_rest(&s);
}
