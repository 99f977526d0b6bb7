/* Solves one step of one island. Section 9 of core/README.md follows this file. */
#include <pinch/problem.h>

#include "force/force_system.h"
#include "solvers/methods.h"
#include "step/stages.h"
#include "velocity/velocity_system.h"
#include "verify/step_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct pinch_step_solver {
    pinch_arena arena;
    pinch_arena beside; /* what is kept from one solve of a step to the next */
    pinch_block_order_memory orders;
};

const char *pinch_contact_state_text(pinch_contact_state state)
{
    static const char *const TEXT[] = {"open", "stick", "slip", "yield"};
    return (unsigned)state <= PINCH_CONTACT_YIELD ? TEXT[state] : "unknown";
}

pinch_status pinch_step_solver_create(pinch_step_solver **solver)
{
    if (!solver) return PINCH_INVALID_ARGUMENT;
    *solver = malloc(sizeof **solver);
    if (!*solver) return PINCH_OUT_OF_MEMORY;
    pinch_arena_init(&(*solver)->arena);
    pinch_arena_init(&(*solver)->beside);
    memset(&(*solver)->orders, 0, sizeof(*solver)->orders);
    return PINCH_OK;
}

void pinch_step_solver_destroy(pinch_step_solver *solver)
{
    if (!solver) return;
    pinch_arena_free(&solver->arena);
    pinch_arena_free(&solver->beside);
    pinch_block_order_forget(&solver->orders);
    free(solver);
}

size_t pinch_step_solver_memory(const pinch_step_solver *solver, size_t *high_water)
{
    size_t orders = sizeof *solver->orders.room * solver->orders.held;
    if (high_water)
        *high_water = pinch_arena_high_water(&solver->arena) + pinch_arena_high_water(&solver->beside) + orders;
    return pinch_arena_held(&solver->arena) + pinch_arena_held(&solver->beside) + orders;
}

void pinch_step_solver_trim(pinch_step_solver *solver, size_t least)
{
    pinch_arena_trim(&solver->arena, least);
    pinch_arena_trim(&solver->beside, least);
    pinch_block_order_forget(&solver->orders);
}

/* A stage gives up either for want of memory or because an inertia is not positive definite. */
static pinch_status failure(const pinch_arena *arena)
{
    return arena->failed ? PINCH_OUT_OF_MEMORY : PINCH_INVALID_ARGUMENT;
}

/* Only the system of forces has the law of some contact. None of the summands is negative. */
static bool needs_forces(const pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        if (c->may_soften || c->model == PINCH_CONTACT_ROLLING) return true;
        double others = c->viscous[0] + c->viscous[1];
        for (int i = 0; i < 5; i++) others += c->friction_limit[i];
        if (others != 0) return true;
    }
    return false;
}

static bool has_couplings(const pinch_problem *problem)
{
    for (int j = 0; j < problem->row_count; j++)
        if (problem->rows[j].continues) return true;
    return false;
}

/* The velocities as unknowns have rows for more than two bodies where these are of two clusters at most, as the joints
 * of a hand are, and where the row's force is bounded or compliant, or the row is of the rates of joints. */
static bool couplings_fit_velocities(const pinch_problem *problem, const pinch_mobility *mobility)
{
    for (int k = 0; k < mobility->remaining_count; k++) {
        int j = mobility->remaining[k], cluster[2] = {-1, -1};
        if (problem->rows[j].continues || !pinch_row_goes_on(problem, j)) continue;
        int parts = pinch_row_parts(problem, j);
        if (pinch_row_is_hard(&problem->rows[j]) && mobility->kept_count > 0) return false;
        for (int i = 0; i < 2 * parts; i++) {
            const pinch_joint_row *part = &problem->rows[j + i / 2];
            int body = i % 2 ? part->body2 : part->body1;
            if (body < 0) continue;
            int of = mobility->cluster_of[body], to = cluster[0] >= 0 && cluster[0] != of;
            if (cluster[to] >= 0 && cluster[to] != of) return false;
            cluster[to] = of;
        }
    }
    return true;
}

static double inverse_mass(const pinch_problem *problem, int body)
{
    return body >= 0 ? 1 / problem->bodies[body].mass : 0;
}

/* The island is so stiff that the forces serve better as unknowns. */
static bool is_stiff(const pinch_problem *problem)
{
    /* below this compliance, as a part of what its own inertia gives a contact in a step, Newton's method in the
     * velocities begins to fail */
    static const double STIFF = 1e-3;
    double h = problem->step, most = 0;
    for (int b = 0; b < problem->body_count; b++) most = fmax(most, 2 * inverse_mass(problem, b));
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        double stiffness = STIFF * h * (h * c->stiffness[0] + c->damping[0]);
        if (1 < stiffness * most && 1 < stiffness * (inverse_mass(problem, c->body1) + inverse_mass(problem, c->body2)))
            return true;
    }
    return false;
}

/* The island is so large that the forces serve better as unknowns: a sparse factorization is worth its lists. */
static bool is_large(const pinch_mobility *mobility)
{
    enum { LARGE = 60 };
    return mobility->unknowns > LARGE;
}

/* Tells of all clusters that joints tie together, or of any of them, whether the rates of their joints are unknowns. */
static bool has_rates(const pinch_mobility *mobility, bool all)
{
    bool any = false;
    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &mobility->clusters[c];
        if (cluster->space)
            any = true;
        else if (all && (cluster->tree || cluster->factor))
            return false;
    }
    return any;
}

/* Rows alone are linear, but for their bounds: the forces serve better, but where each acts on a joint's rate alone. */
static bool is_rows_alone(const pinch_problem *problem, const pinch_mobility *mobility)
{
    return problem->contact_count == 0 && !has_rates(mobility, true);
}

/* Which unknowns may the system have? */
typedef struct choice {
    bool velocities, forces;
} choice;

/* The forces as unknowns need Newton's steps, the exact cone and bodies with mass; Lemke and PGS need the velocities
 * and a cone with facets. */
static choice possible_unknowns(const pinch_problem *problem, const pinch_solver_settings *settings)
{
    bool needs_facets = settings->solver == PINCH_SOLVER_LEMKE || settings->solver == PINCH_SOLVER_PGS;
    choice can = {.velocities =
                      !needs_forces(problem) && (!needs_facets || (problem->faces != 0 && !has_couplings(problem))),
                  .forces = problem->faces == 0 && pinch_solver_takes_newton_steps(settings)};
    for (int b = 0; b < problem->body_count && can.forces; b++) can.forces = problem->bodies[b].mass != 0;
    return can;
}

/* A solve on its way. */
typedef struct step_solve {
    pinch_step_solver *solver;
    pinch_problem *problem;
    const pinch_solver_settings *settings;
    pinch_step_result *result;
    choice can;
    bool stiff;              /* contacts are, or count as such: then the forces are better unknowns */
    bool forces;             /* the forces are the first unknowns that are tried */
    bool sweeps;             /* sweeps may take over */
    pinch_mobility mobility; /* for the attempt at hand */
    double *start;           /* keep_trial: room for the forces that an attempt began with */
    bool has_trial;          /* the problem has forces of an attempt that failed, and `start` those before */
} step_solve;

/* Moves a number from `value` to its place, or back. */
static void move_number(double *value, double **place, bool back)
{
    if (back)
        *value = **place;
    else
        **place = *value;
    ++*place;
}

/* Keeps the forces of the problem in `start`, or puts them back. */
static void move_start(step_solve *s, bool back)
{
    double *place = s->start;
    for (int k = 0; k < s->problem->contact_count; k++) {
        pinch_contact *c = &s->problem->contacts[k];
        for (int i = 0; i < 4; i++) move_number(&c->force[i], &place, back);
        for (int i = 0; i < 2; i++) move_number(&c->rolling_moment[i], &place, back);
    }
    for (int j = 0; j < s->problem->row_count; j++) move_number(&s->problem->rows[j].force, &place, back);
}

/* Takes back what an attempt has left that failed. Only the last one is shown, and those after it begin as if nobody
 * looked. */
static void take_back_trial(step_solve *s)
{
    if (!s->has_trial) return;
    move_start(s, true);
    s->result->floor_depth = s->result->floor_residual = 0;
    s->result->too_soft = false;
    s->has_trial = false;
}

/* Checks an answer, and where it does not hold, once more with joint rows that are held by themselves. Returns false
 * when memory ran out. */
static bool check_forces(step_solve *s, pinch_force_system *system, bool *verified)
{
    double share;
    *verified = pinch_step_verify(s->problem, s->settings->tolerance, system->body_scratch, s->result);
    if (*verified || !system->joints_kept) return true;
    pinch_force_undo(system);
    pinch_force_hold_rows(system);
    if (!pinch_force_read_back(&s->solver->arena, s->problem, system, s->result, &share)) return false;
    *verified = pinch_step_verify(s->problem, s->settings->tolerance, system->body_scratch, s->result);
    return true;
}

/* Solves, and checks the answer. What the check does not let pass of an approximation stays one. */
static pinch_status solve_in_forces(step_solve *s, const pinch_mobility *mobility, pinch_force_way way)
{
    pinch_arena *arena = &s->solver->arena;
    pinch_problem *problem = s->problem;
    const pinch_solver_settings *settings = s->settings;
    pinch_step_result *result = s->result;
    pinch_force_system system = {.orders = &s->solver->orders};
    take_back_trial(s);
    if (!pinch_force_solve(arena, problem, mobility, settings, way, &system, result)) return failure(arena);
    bool approximated = system.given_up || way == PINCH_FORCE_BY_SWEEPS;
    if (result->solve.status != PINCH_SOLVE_CONVERGED) result->swept = false;
    bool converged = result->solve.status == PINCH_SOLVE_CONVERGED, verified = false;
    if (converged && !check_forces(s, &system, &verified)) return failure(arena);
    if (converged && !verified) {
        result->solve.status = approximated ? PINCH_SOLVE_MAX_ITERATIONS : PINCH_SOLVE_UNVERIFIED;
        result->swept = approximated;
    }
    if (approximated || result->solve.status == PINCH_SOLVE_CONVERGED) return PINCH_OK;
    double share;
    bool written = system.before != NULL;
    if (!written && problem->keep_trial) {
        move_start(s, false);
        s->has_trial = true;
        if (!pinch_force_read_back(arena, problem, &system, result, &share)) return failure(arena);
    }
    pinch_force_undo(&system);
    return PINCH_OK;
}

/* Sweeps are for free bodies that the system of forces knows. */
static bool can_be_swept(const pinch_problem *problem, const pinch_solver_settings *settings, choice can)
{
    return settings->sweeps > 0 && can.forces && problem->row_count == 0 && problem->contact_count > 0;
}

/* Approximates the step after other ways. */
static pinch_status sweep(step_solve *s, const pinch_mobility *mobility)
{
    bool over_budget = s->result->over_budget;
    s->result->floor_depth = s->result->floor_residual = 0;
    pinch_status status = solve_in_forces(s, mobility, PINCH_FORCE_BY_SWEEPS);
    s->result->over_budget = over_budget;
    return status;
}

/*
 * Solves, reads the answer back and checks it. The solver's tolerance counts in the forces that act at the start of the
 * solve; where hardly any are left at the end (a contact that just opens), or nothing but rounding moves a light
 * finger, that is too coarse for the check, and the solve goes on from where it is, measured by what acts there, as
 * long as a step pays.
 */
static pinch_status solve_in_velocities(step_solve *s)
{
    enum { MEASURES = 3 };
    pinch_arena *arena = &s->solver->arena;
    pinch_problem *problem = s->problem;
    const pinch_solver_settings *settings = s->settings;
    pinch_step_result *result = s->result;
    pinch_velocity_system system;
    take_back_trial(s);
    if (!pinch_velocity_system_build(arena, problem, &s->mobility, &system)) return failure(arena);
    result->unknowns = system.unknowns;
    pinch_solver_result total = {.status = PINCH_SOLVE_CONVERGED}, *solve = &result->solve;
    bool verified = false;
    int measures = system.unknowns > 0 ? MEASURES : 1; /* where joints hold everything there is nothing to measure */
    for (int measure = 0; measure < measures && !verified && total.status == PINCH_SOLVE_CONVERGED; measure++) {
        pinch_solver_settings finer = *settings;
        if (measure > 0) {
            pinch_velocity_system_rescale(&system);
            finer.goal = 0;
        }
        pinch_status status = pinch_velocity_solve(arena, &system, &finer, solve);
        if (status != PINCH_OK) return status;
        solve->iterations += total.iterations;
        solve->projections += total.projections;
        solve->newton_steps += total.newton_steps;
        solve->by_flow = solve->by_flow || total.by_flow;
        total = *solve;
        pinch_velocity_read_back(&system, problem);
        verified = pinch_step_verify(problem, settings->tolerance, system.body_scratch, result);
    }
    if (solve->status == PINCH_SOLVE_CONVERGED && !verified) solve->status = PINCH_SOLVE_UNVERIFIED;
    pinch_velocity_remember(&system, solve->status == PINCH_SOLVE_CONVERGED);
    return PINCH_OK;
}

/* Has the island one body with mass, which everything else touches that moves? Newton's steps alone, and nobody who
 * watches them, will do for it. */
static bool is_single_body(const pinch_problem *problem, const pinch_solver_settings *settings)
{
    enum { MOST_BODIES = 9 };
    int masses = 0, body = 0;
    if (problem->body_count > MOST_BODIES || problem->row_count > 0 || problem->faces != 0 || settings->progress ||
        !pinch_solver_takes_newton_steps(settings))
        return false;
    for (int b = 0; b < problem->body_count; b++) {
        if (problem->bodies[b].mass == 0) continue;
        masses++;
        body = b;
    }
    if (masses != 1) return false;
    for (int k = 0; k < problem->contact_count && problem->body_count > 1; k++)
        if (problem->contacts[k].body1 != body && problem->contacts[k].body2 != body) return false;
    return true;
}

/* Solves the step of a single free body and checks the answer. Where there is none, the status of the solve says so. */
static pinch_status solve_single_body(pinch_arena *arena, pinch_problem *problem, const pinch_solver_settings *settings,
                                      pinch_step_result *result)
{
    enum { FREEDOMS = 6 };
    double *check_scratch = PINCH_ARENA_ARRAY(arena, double, 12 * problem->body_count);
    if (!check_scratch) return failure(arena);
    pinch_status status = pinch_single_body_solve(arena, problem, settings, &result->solve);
    bool answered = status == PINCH_OK && result->solve.status == PINCH_SOLVE_CONVERGED &&
                    pinch_step_verify(problem, settings->tolerance, check_scratch, result);
    if (answered)
        result->unknowns = FREEDOMS + problem->body_count - 1;
    else
        memset(result, 0, sizeof *result);
    return status;
}

/* What is no answer must not pass for one. */
static void poison(pinch_problem *problem)
{
    for (int b = 0; b < problem->body_count; b++)
        for (int i = 0; i < 6; i++) problem->bodies[b].velocity_end[i] = NAN;
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        for (int i = 0; i < 4; i++) c->force[i] = c->relative_velocity[i] = NAN;
        for (int i = 0; i < 3; i++) c->elastic_end[i] = c->slip[i] = NAN;
        for (int i = 0; i < 2; i++) c->rolling_elastic_end[i] = c->rolling_moment[i] = NAN;
    }
    for (int j = 0; j < problem->row_count; j++) problem->rows[j].force = NAN;
}

/* Tells whether there is no answer yet, and the forces as unknowns may find one. */
static bool can_go_on(const step_solve *s)
{
    const pinch_step_result *result = s->result;
    return s->can.forces && result->solve.status != PINCH_SOLVE_CONVERGED && !result->over_budget &&
           result->solve.iterations < s->settings->max_iterations;
}

static bool build_mobility(step_solve *s, pinch_elimination elimination)
{
    return pinch_mobility_build(&s->solver->arena, s->problem, elimination, &s->mobility);
}

/* Prepares the mobility, and finds which unknowns are tried first. */
static pinch_status choose_unknowns(step_solve *s)
{
    pinch_elimination elimination = !s->can.forces                   ? PINCH_ELIMINATE_ALL
                                    : s->can.velocities && !s->stiff ? PINCH_ELIMINATE_INTO_RATES
                                                                     : PINCH_ELIMINATE_WHERE_CHEAP;
    if (!build_mobility(s, elimination)) return failure(&s->solver->arena);
    s->can.velocities = s->can.velocities && couplings_fit_velocities(s->problem, &s->mobility);
    if (!s->can.velocities && !s->can.forces) return PINCH_UNSUPPORTED;
    s->result->dependent_rows = s->mobility.dependent_count;
    s->forces = s->can.forces && (!s->can.velocities || s->mobility.kept_count > 0 || s->stiff ||
                                  is_large(&s->mobility) || is_rows_alone(s->problem, &s->mobility));
    if (s->forces && has_rates(&s->mobility, false) && !build_mobility(s, PINCH_ELIMINATE_WHERE_CHEAP))
        return failure(&s->solver->arena);
    s->sweeps = can_be_swept(s->problem, s->settings, s->can);
    return PINCH_OK;
}

/* Makes another mobility, and solves in the forces with it. */
static pinch_status solve_in_forces_anew(step_solve *s, pinch_elimination elimination, pinch_force_way way)
{
    if (!build_mobility(s, elimination)) return failure(&s->solver->arena);
    s->result->dependent_rows = s->mobility.dependent_count;
    return solve_in_forces(s, &s->mobility, way);
}

/* Tries what may find an answer, one after the other: the forces, the velocities, the forces with loops that are in the
 * rates of joints no more, a path of solutions, sweeps. */
static pinch_status try_in_order(step_solve *s)
{
    enum { DENSE_LIMIT = 600 }; /* unknowns above which a dense factorization is not tried */
    pinch_step_result *result = s->result;
    pinch_arena *arena = &s->solver->arena;
    const pinch_mobility reduced = s->mobility; /* later attempts may make another one, behind this mark */
    pinch_arena_mark here = pinch_arena_here(arena);
    pinch_status status = PINCH_OK;
    bool by_forces = s->forces;
    if (by_forces) {
        status = solve_in_forces(s, &s->mobility, PINCH_FORCE_BY_NEWTON);
        bool answered = status != PINCH_OK || result->solve.status == PINCH_SOLVE_CONVERGED || result->swept;
        by_forces = answered || !s->can.velocities || s->mobility.unknowns > DENSE_LIMIT ||
                    result->solve.iterations >= s->settings->max_iterations;
    }
    if (!by_forces && s->mobility.kept_count > 0 && !build_mobility(s, PINCH_ELIMINATE_ALL)) return failure(arena);
    if (!by_forces) status = solve_in_velocities(s);
    if (status == PINCH_OK && pinch_mobility_has_loops(&s->mobility) && can_go_on(s))
        status = solve_in_forces_anew(s, PINCH_ELIMINATE_WHERE_CHEAP, PINCH_FORCE_BY_NEWTON);
    if (status == PINCH_OK && can_go_on(s)) /* a path takes fewer unknowns */
        status = solve_in_forces_anew(s, PINCH_ELIMINATE_INDEPENDENT, PINCH_FORCE_BY_PATH);
    if (status == PINCH_OK && result->solve.status != PINCH_SOLVE_CONVERGED && result->over_budget && s->sweeps &&
        !result->swept) {
        pinch_arena_rewind(arena, &here);
        status = sweep(s, &reduced);
    }
    return status;
}

/* Finds an answer. by_forces: the forces are the first unknowns, if they can be. */
static pinch_status solve_step(pinch_step_solver *solver, pinch_problem *problem, const pinch_solver_settings *settings,
                               bool by_forces, pinch_step_result *result)
{
    memset(result, 0, sizeof *result);
    step_solve s = {.solver = solver, .problem = problem, .settings = settings, .result = result};
    s.can = possible_unknowns(problem, settings);
    if (!s.can.velocities && !s.can.forces) return PINCH_UNSUPPORTED;
    pinch_arena_reset(&solver->arena);
    s.stiff = s.can.forces && (by_forces || is_stiff(problem));
    if (s.can.velocities && !s.stiff && is_single_body(problem, settings)) {
        pinch_status status = solve_single_body(&solver->arena, problem, settings, result);
        if (status != PINCH_OK || result->unknowns > 0) return status;
        pinch_arena_reset(&solver->arena);
    }
    for (int j = 0; j < problem->row_count; j++) problem->rows[j].violation = 0;
    pinch_status status = choose_unknowns(&s);
    if (status != PINCH_OK) return status;
    if (problem->keep_trial) {
        enum { FORCES = 6 };
        s.start = PINCH_ARENA_ARRAY(&solver->arena, double, FORCES * problem->contact_count + problem->row_count + 1);
        if (!s.start) return failure(&solver->arena);
    }
    if (s.sweeps && settings->sweeps_alone) return sweep(&s, &s.mobility);
    status = try_in_order(&s);
    bool outputs = result->solve.status == PINCH_SOLVE_CONVERGED || result->swept || problem->keep_trial;
    if (status == PINCH_OK && !outputs) poison(problem);
    return status;
}

pinch_status pinch_step_solve(pinch_step_solver *solver, pinch_problem *problem, const pinch_solver_settings *settings,
                              pinch_step_result *result)
{
    pinch_sticking start;
    if (pinch_check_solver_settings(settings) != PINCH_OK || !pinch_problem_valid(problem)) {
        memset(result, 0, sizeof *result);
        return PINCH_INVALID_ARGUMENT;
    }
    pinch_arena_reset(&solver->beside);
    if (!pinch_note_start(&solver->beside, problem, &start)) return PINCH_OUT_OF_MEMORY;
    pinch_status status = solve_step(solver, problem, settings, false, result);
    bool answered = status == PINCH_OK && result->solve.status == PINCH_SOLVE_CONVERGED;
    if (!answered || pinch_contacts_let_go(&start, problem) == 0) return status;
    return pinch_go_on_sticking(&solver->beside, &start, solve_step, solver, problem, settings, result);
}
