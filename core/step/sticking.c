/*
 * Coulomb's friction derives from no potential: its limit follows the normal force, and friction changes the normal
 * force in turn. An implicit step that is long beside sqrt(m / k) may therefore have several answers, such as one in
 * which an object rests on in its grasp and one in which all fingertips let go of it within the step. Newton's method
 * finds the one that lies in the basin of its start. A small change of load moves a start in velocities by
 * h^2 k / m of it in forces, which may be hundreds of times the grip.
 *
 * Bodies follow the answer that continues the last step: as long as what sticks can go on sticking, nothing makes it
 * slip. So where contacts let go in an answer, or open, the step is solved once more with those that stuck held by
 * friction without a limit, and the others with limits as they were. Held contacts whose forces are beyond their limits
 * are let go, and given limits follow the normal forces, until neither changes. What is found then holds by the laws as
 * they are, or nearly so: the step is solved from these forces, and its answer is taken where fewer contacts let go.
 */
#include "step/stages.h"

#include "support/extremes.h"

#include <math.h>
#include <string.h>

/* Larger islands of compliant contacts are not looked at: a second solve would take long. */
enum { MOST_CONTACTS = 64 };

static void hold(pinch_contact *c)
{
    c->friction[0] = c->friction[1] = INFINITY;
    c->torsional_friction = INFINITY;
    c->rolling_friction[0] = c->rolling_friction[1] = INFINITY;
}

/* Makes one limit a given one. */
static void give_limit(double normal, double *friction, double *limit)
{
    *limit += *friction * normal;
    *friction = 0;
}

/* Gives friction the limits that it has at a normal force (Tresca's friction), for which an answer is nearly unique.
 * Infinite friction has no other. */
static void give_limits(double normal, pinch_contact *c)
{
    if (!(normal > 0) || c->model == PINCH_CONTACT_FRICTIONLESS) return;
    for (int i = 0; i < 2; i++) give_limit(normal, &c->friction[i], &c->friction_limit[i]);
    give_limit(normal, &c->torsional_friction, &c->friction_limit[2]);
    for (int i = 0; i < 2; i++) give_limit(normal, &c->rolling_friction[i], &c->friction_limit[3 + i]);
}

/* The square of the part of its limit that a friction force is. */
static double reach2_of(double force, double limit)
{
    return force == 0 ? 0 : (force / limit) * (force / limit);
}

/* Returns which part of its limit (5) friction reaches in a contact that presses, `law` being the contact with the
 * friction that counts. */
static double reach_of(const pinch_contact *c, const pinch_contact *law, int faces)
{
    double normal = c->force[0], tangents2 = 0, torsion2 = 0, rolling2 = 0;
    for (int i = 0; i < 2; i++)
        tangents2 += reach2_of(c->force[1 + i], law->friction_limit[i] + law->friction[i] * normal);
    if (c->model == PINCH_CONTACT_SOFT || c->model == PINCH_CONTACT_ROLLING)
        torsion2 = reach2_of(c->force[3], law->friction_limit[2] + law->torsional_friction * normal);
    for (int i = 0; i < 2 && c->model == PINCH_CONTACT_ROLLING; i++) {
        double limit = law->friction_limit[3 + i] + law->rolling_friction[i] * normal;
        rolling2 += reach2_of(c->rolling_moment[i], limit);
    }
    bool together = c->model == PINCH_CONTACT_SOFT && faces == 0; /* on one ellipsoid */
    double own2 = together ? tangents2 + torsion2 : pinch_larger(tangents2, torsion2);
    return sqrt(pinch_larger(own2, rolling2));
}

/* Could a contact stick at its normal force? One without friction along a row slips there however little it moves. */
static bool may_stick(const pinch_contact *c)
{
    double normal = c->force[0];
    if (c->model == PINCH_CONTACT_FRICTIONLESS || !(normal > 0)) return false;
    bool may = true;
    for (int i = 0; i < 2; i++) may = may && c->friction_limit[i] + c->friction[i] * normal > 0;
    return may && (c->model != PINCH_CONTACT_SOFT || c->friction_limit[2] + c->torsional_friction * normal > 0);
}

/* Does a contact stick by its forces? */
static bool sticks(const pinch_contact *c, int faces)
{
    static const double INSIDE = 1 - 1e-9; /* of the limit; what slips is on it, to rounding */
    return may_stick(c) && reach_of(c, c, faces) < INSIDE;
}

bool pinch_note_start(pinch_arena *arena, const pinch_problem *problem, pinch_sticking *start)
{
    int count = problem->contact_count;
    bool any = false, compliant = count <= MOST_CONTACTS;
    start->contacts = NULL;
    for (int k = 0; k < count && compliant; k++) {
        any = any || problem->contacts[k].force[0] > 0;
        compliant = !problem->contacts[k].may_soften;
    }
    if (!any || !compliant) return true;
    start->contacts = PINCH_ARENA_ARRAY(arena, pinch_contact, count);
    start->row_forces = PINCH_ARENA_ARRAY(arena, double, problem->row_count + 1);
    if (arena->failed) return false;
    memcpy(start->contacts, problem->contacts, sizeof *start->contacts * (size_t)count);
    for (int j = 0; j < problem->row_count; j++) start->row_forces[j] = problem->rows[j].force;
    return true;
}

int pinch_contacts_let_go(const pinch_sticking *start, const pinch_problem *problem)
{
    int count = 0;
    for (int k = 0; k < problem->contact_count && start->contacts; k++) {
        pinch_contact_state state = problem->contacts[k].state;
        bool holds = state == PINCH_CONTACT_STICK || state == PINCH_CONTACT_YIELD;
        count += !holds && sticks(&start->contacts[k], problem->faces);
        count += state == PINCH_CONTACT_OPEN && start->contacts[k].force[0] > 0;
    }
    return count;
}

/* Adds what a solve has taken. */
static void count(const pinch_step_result *of, pinch_step_result *sum)
{
    sum->solve.iterations += of->solve.iterations;
    sum->solve.newton_steps += of->solve.newton_steps;
    sum->solve.projections += of->solve.projections;
    sum->work += of->work;
}

/* A search for such an answer. */
typedef struct search {
    const pinch_sticking *start;
    pinch_sticking_solve *solve;
    pinch_step_solver *solver;
    pinch_problem *problem;
    const pinch_solver_settings *settings;
    bool *held;     /* per contact */
    double *normal; /* per contact, N: what the limits of those that are not held follow */
    pinch_step_result spent;
} search;

/* Puts back what a solve has changed. Contacts that are held get friction without a limit, the others given limits. */
static void begin_again(search *s)
{
    pinch_problem *problem = s->problem;
    for (int k = 0; k < problem->contact_count; k++) {
        problem->contacts[k] = s->start->contacts[k];
        if (s->held[k])
            hold(&problem->contacts[k]);
        else
            give_limits(s->normal[k], &problem->contacts[k]);
    }
    for (int j = 0; j < problem->row_count; j++) problem->rows[j].force = s->start->row_forces[j];
}

/* Lets go of held contacts whose forces are beyond their limits. Tells whether there were any. */
static bool let_go_beyond_limits(search *s)
{
    static const double BEYOND = 1 + 1e-12;
    bool any = false;
    for (int k = 0; k < s->problem->contact_count; k++) {
        const pinch_contact *c = &s->problem->contacts[k];
        if (!s->held[k]) continue;
        s->held[k] = !(c->force[0] > 0 && reach_of(c, &s->start->contacts[k], s->problem->faces) > BEYOND);
        any = any || !s->held[k];
    }
    return any;
}

/* Has given limits follow the normal forces. Tells whether one changed by much. */
static bool follow_limits(search *s)
{
    static const double MUCH = 1e-3;
    bool any = false;
    for (int k = 0; k < s->problem->contact_count; k++) {
        double normal = s->problem->contacts[k].force[0];
        any = any || (!s->held[k] && fabs(normal - s->normal[k]) > MUCH * s->normal[k]);
        s->normal[k] = normal;
    }
    return any;
}

/* Solves once. A search that is worth it takes few steps. */
static pinch_status solve_briefly(search *s, pinch_solver_settings settings, bool by_forces, pinch_step_result *result)
{
    enum { MOST_STEPS = 60 };
    if (settings.max_iterations > MOST_STEPS) settings.max_iterations = MOST_STEPS;
    pinch_status status = s->solve(s->solver, s->problem, &settings, by_forces, result);
    count(result, &s->spent);
    return status;
}

/* Solves with contacts that are held. The forces are the unknowns: a small change of load moves them little, whatever
 * the stiffness is. Without a limit of friction its cone needs no facets. */
static pinch_status solve_held(search *s, pinch_step_result *result)
{
    pinch_problem *problem = s->problem;
    pinch_solver_settings settings = *s->settings;
    pinch_problem as_it_was = *problem;
    settings.solver = PINCH_SOLVER_NEWTON;
    problem->faces = 0;
    problem->keep_trial = true;
    begin_again(s);
    pinch_status status = solve_briefly(s, settings, true, result);
    *problem = as_it_was;
    return status;
}

/* Forces to start from need not pass the check of an answer. */
static bool will_do(const pinch_step_result *result)
{
    return result->solve.status == PINCH_SOLVE_CONVERGED || result->solve.status == PINCH_SOLVE_UNVERIFIED;
}

/* Finds forces with which contacts that are held stick within their limits. *found tells whether there are some. */
static pinch_status find_forces(search *s, bool *found)
{
    enum { ROUNDS = 6 };
    *found = false;
    bool moves = true;
    for (int round = 0; round < ROUNDS && moves; round++) {
        pinch_step_result result;
        pinch_status status = solve_held(s, &result);
        if (status == PINCH_OUT_OF_MEMORY) return status;
        if (status != PINCH_OK || !will_do(&result)) return PINCH_OK;
        *found = !let_go_beyond_limits(s);
        moves = follow_limits(s) || !*found;
    }
    return PINCH_OK;
}

/* Solves by the laws as they are, from the forces at hand. */
static pinch_status solve_from_forces(search *s, pinch_step_result *result)
{
    pinch_problem *problem = s->problem;
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k], from = *c;
        *c = s->start->contacts[k];
        memcpy(c->force, from.force, sizeof c->force);
        memcpy(c->rolling_moment, from.rolling_moment, sizeof c->rolling_moment);
    }
    return solve_briefly(s, *s->settings, false, result);
}

/* An answer put aside. */
typedef struct kept_answer {
    pinch_body *bodies;
    pinch_contact *contacts;
    pinch_joint_row *rows;
} kept_answer;

static bool keep(pinch_arena *arena, const pinch_problem *p, kept_answer *kept)
{
    kept->bodies = PINCH_ARENA_ARRAY(arena, pinch_body, p->body_count);
    kept->contacts = PINCH_ARENA_ARRAY(arena, pinch_contact, p->contact_count);
    kept->rows = PINCH_ARENA_ARRAY(arena, pinch_joint_row, p->row_count + 1);
    if (arena->failed) return false;
    memcpy(kept->bodies, p->bodies, sizeof *p->bodies * (size_t)p->body_count);
    memcpy(kept->contacts, p->contacts, sizeof *p->contacts * (size_t)p->contact_count);
    if (p->row_count > 0) memcpy(kept->rows, p->rows, sizeof *p->rows * (size_t)p->row_count);
    return true;
}

static void put_back(const kept_answer *kept, pinch_problem *p)
{
    memcpy(p->bodies, kept->bodies, sizeof *p->bodies * (size_t)p->body_count);
    memcpy(p->contacts, kept->contacts, sizeof *p->contacts * (size_t)p->contact_count);
    if (p->row_count > 0) memcpy(p->rows, kept->rows, sizeof *p->rows * (size_t)p->row_count);
}

pinch_status pinch_go_on_sticking(pinch_arena *arena, const pinch_sticking *start, pinch_sticking_solve *solve,
                                  pinch_step_solver *solver, pinch_problem *problem,
                                  const pinch_solver_settings *settings, pinch_step_result *result)
{
    search s = {.start = start, .solve = solve, .solver = solver, .problem = problem, .settings = settings};
    s.held = PINCH_ARENA_ARRAY(arena, bool, problem->contact_count);
    s.normal = PINCH_ARENA_ARRAY(arena, double, problem->contact_count);
    kept_answer kept;
    pinch_step_result other;
    bool found;
    int let_go = pinch_contacts_let_go(start, problem);
    if (arena->failed || !keep(arena, problem, &kept)) return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < problem->contact_count; k++) {
        s.held[k] = sticks(&start->contacts[k], problem->faces);
        s.normal[k] = start->contacts[k].force[0];
    }
    pinch_step_memory *memory = problem->memory;
    problem->memory = NULL; /* it keeps what the first solve has left for the next step */
    pinch_status status = find_forces(&s, &found);
    if (status == PINCH_OK && found) status = solve_from_forces(&s, &other);
    problem->memory = memory;
    count(result, &s.spent);
    if (status == PINCH_OK && found && other.solve.status == PINCH_SOLVE_CONVERGED &&
        pinch_contacts_let_go(start, problem) < let_go)
        *result = other;
    else
        put_back(&kept, problem);
    result->solve.iterations = s.spent.solve.iterations;
    result->solve.newton_steps = s.spent.solve.newton_steps;
    result->solve.projections = s.spent.solve.projections;
    result->work = s.spent.work;
    return status == PINCH_OUT_OF_MEMORY ? status : PINCH_OK;
}
