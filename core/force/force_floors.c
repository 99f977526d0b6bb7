/*
 * Solves an island with as little softening as it takes, by continuation in the compliance: equation (25) of
 * core/README.md, from floor level to floor level, each five times softer than the one below. The floor that an island
 * needed is remembered with its contacts, so that islands may part and merge. After a number of quiet steps it is
 * lowered little by little: what lies on soft contacts is pressed in deeper, and contacts that stiffened all at once
 * would throw it up. A heap may need its floor for good. Each time that a lower one fails, all that lies on it sinks
 * again, and so the quiet steps double in number, and what a step lowers is halved: what can come to rest does, and
 * keeps the floor that it rests on, and a heap that has come near to rest is not set in motion.
 */
#include "force/force_system.h"

#include "solvers/methods.h"
#include "support/extremes.h"

#include <math.h>
#include <string.h>

enum { LEVELS = 7, SWEEPS = 30, FIRST_LIMIT = 20, LATER_LIMIT = 25, QUIET_STEPS = 20, MOST_QUIET_STEPS = 1280 };
/* Floors are parts of h W; above the softest a contact is no contact any more. */
static const double SOFTEST = 2, LOWEST_FLOOR = 1e-6, LEVEL_FACTOR = 5;

/* Contacts that are jammed against joints share an overlap with them by how compliant they are, and there a floor may
 * count that is far below the lowest one at which steps begin. Down to this one, contacts have some digits left that
 * tell how compliant they are. */
static const double STIFFEST_FLOOR = 1e-9;

/* A floor is lowered only where it lets a contact sink by more than this part of the body's size. */
static const double SUNK_SHARE = 3e-4;

/* How much farther an even push moves a body in 14 steps than in one. */
static const double IN_TIME = 100;

/* An island's floor, for how many more steps it is to stay, and for how many it was to stay when it was last raised. */
typedef struct held_floor {
    double floor;
    int hold, span;
} held_floor;

static int larger(int a, int b)
{
    return a > b ? a : b;
}

typedef struct floors_task {
    const pinch_problem *problem;
    held_floor *found; /* per chunk */
} floors_task;

static held_floor larger_floor(held_floor a, const held_floor *b)
{
    return (held_floor){fmax(a.floor, b->floor), larger(a.hold, b->hold), larger(a.span, b->span)};
}

static void find_floors(void *argument, int first, int end)
{
    const floors_task *task = argument;
    held_floor last = {0, 0, 0};
    for (int k = first; k < end; k++) {
        const pinch_contact *c = &task->problem->contacts[k];
        last.floor = pinch_larger(c->floor, last.floor);
        last.hold = larger(last.hold, c->hold);
        last.span = larger(last.span, c->hold_span);
    }
    task->found[first / PINCH_CHUNK] = last;
}

/* Returns false when memory ran out. */
static bool last_floor(pinch_arena *arena, const pinch_problem *problem, held_floor *last)
{
    int chunks = pinch_chunk_count(problem->contact_count);
    floors_task task = {problem, PINCH_ARENA_ARRAY(arena, held_floor, chunks + 1)};
    if (arena->failed) return false;
    *last = (held_floor){0, 0, 0};
    if (chunks > 0) pinch_loop(problem->crew, problem->contact_count, find_floors, &task);
    for (int k = 0; k < chunks; k++) *last = larger_floor(*last, &task.found[k]);
    if (last->floor <= 0) last->floor = PINCH_FORCE_FIRST_FLOOR;
    return true;
}

static void keep_floor(void *argument, int first, int end)
{
    const floors_task *task = argument;
    for (int k = first; k < end; k++) {
        pinch_contact *c = &task->problem->contacts[k];
        c->floor = task->found->floor;
        c->hold = task->found->hold;
        c->hold_span = task->found->span;
    }
}

/* Returns the factor by which a step lowers a floor that had to stay for so many quiet steps. In a heap whose contacts
 * sink by millimetres, a twentieth in each step of 10 ms would move bodies at 10 mm/s. */
static double lowered_after(int span)
{
    return 1 - (1 - PINCH_FORCE_LOWERED) * QUIET_STEPS / larger(span, QUIET_STEPS);
}

/* Remembers the floor of an answer in which a contact sinks by `share` of its body's size. */
static void remember_floor(pinch_problem *problem, const held_floor *last, double floor, double share)
{
    held_floor next = {fmax(floor, LOWEST_FLOOR), last->hold > 0 ? last->hold - 1 : 0, last->span};
    if (floor > last->floor) {
        next.span = last->span > MOST_QUIET_STEPS / 2 ? MOST_QUIET_STEPS : larger(QUIET_STEPS, 2 * last->span);
        next.hold = next.span;
    } else if (last->hold == 0 && share > SUNK_SHARE)
        next.floor = fmax(LOWEST_FLOOR, lowered_after(last->span) * floor);
    else if (last->hold == 0)
        next.span = 0;
    floors_task task = {problem, &next};
    pinch_loop(problem->crew, problem->contact_count, keep_floor, &task);
}

static bool may_soften(const pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++)
        if (problem->contacts[k].may_soften) return true;
    return false;
}

/* A way down to stiffer floors. */
typedef struct descent {
    const pinch_problem *problem;
    const pinch_solver_settings *settings;
    pinch_force_answer *center; /* room for one */
    pinch_step_result *result;
    double *sinks; /* of each contact at the softer floor, m */
    /* as soon as a stiffer floor is tried: */
    pinch_force_answer kept; /* room for one */
    double *short_of;        /* of each contact at the softer floor, m/s */
    double *row_forces;      /* of each joint row at the softer floor, N or N m */
} descent;

/* Makes room for what a try needs. Most answers count at once, and none is made. Returns false when memory ran out. */
static bool make_room_for_tries(pinch_arena *arena, const pinch_force_system *s, descent *d)
{
    d->short_of = PINCH_ARENA_ARRAY(arena, double, s->contact_count + 1);
    d->row_forces = PINCH_ARENA_ARRAY(arena, double, d->problem->row_count + 1);
    return pinch_force_make_room(arena, s, &d->kept);
}

/* Returns by how much (m/s) the compliance of a contact lets its velocity fall short of what it asks for. */
static double falls_short(const pinch_force_element *e)
{
    return *pinch_force_values(e, PINCH_FORCE_COMPLIANCE) * *pinch_force_values(e, PINCH_FORCE_R);
}

/*
 * Bounds by how much a floor lets contacts sink where the answers at two floors are known: equation (63). share is
 * f / (f1 - f2) of the floor in question. A force that lasts has its contact fall short by C r, in proportion to the
 * floor, and all of that goes away with it. Contacts that are jammed against each other fall short by as much at any
 * floor, as nothing can move, and their overlap is no floor's. What is much heavier than the body it lies on hardly
 * moves within a step either, but it does in time: pushed evenly, a hundred times as far in 14 steps.
 */
static void bound_sinks(const pinch_force_system *s, const descent *d, double share, double *sinks)
{
    double h = d->problem->step;
    for (int k = 0; k < s->contact_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double pace = e->contact->stiffness[0] * pinch_force_prescribed(e->contact, h, 0);
        double most = pace > 0 ? IN_TIME * share * fabs(falls_short(e) - d->short_of[k]) / pace : INFINITY;
        if (sinks)
            sinks[k] = fmin(sinks[k], most);
        else
            e->sinks_at_most = most;
    }
}

/*
 * Tells whether a motor jams bodies, and not for long: the force by which it drives grows as those of a jam do, by what
 * the floor is stiffer, and reaches its limit at a floor that is still to come. From there on the bodies fall short in
 * proportion to the floor, and what two softer floors tell says nothing. Brakes only resist: where they share a jam
 * with joints, stiffer floors throw what is in it.
 */
static bool a_motor_will_give_way(const pinch_force_system *s, const descent *d, double floor, double next)
{
    double grows_by = 1 + 0.5 * (floor / next - 1);
    for (int j = 0; j < d->problem->row_count; j++) {
        const pinch_joint_row *row = &d->problem->rows[j];
        double before = d->row_forces[j], now = pinch_force_of_row(s, j), limit = now > 0 ? row->high : -row->low;
        bool grows = now * row->rhs > 0 && before * now > 0 && fabs(now) > grows_by * fabs(before);
        if (grows && fabs(now) < limit && next * fabs(now) > 10 * STIFFEST_FLOOR * limit) return true;
    }
    return false;
}

static void scale_contacts(pinch_force_system *s, double factor)
{
    for (int k = 0; k < s->contact_count; k++) {
        double *r = pinch_force_values(&s->elements[k], PINCH_FORCE_R);
        for (int i = 0; i < s->elements[k].rows; i++) r[i] *= factor;
    }
}

/* Forces that last are the same at the next floor, those of jammed bodies are larger by what it is stiffer. The start
 * is the better of the two. */
static void start_stiffer(pinch_force_system *s, pinch_force_answer *kept, double floor, double next)
{
    pinch_force_set_floor(s, next);
    double lasting = pinch_force_evaluate(s);
    scale_contacts(s, floor / next);
    if (pinch_force_evaluate(s) < lasting) return;
    pinch_force_keep(s, kept, true);
    (void)pinch_force_evaluate(s);
}

/* Do forces and rows hold as the check of an answer wants it? The stiffer a jam is, the larger its forces are, and with
 * them the rounding of what they cancel to. */
static bool holds_closely(const pinch_force_system *s)
{
    static const double MOST_OFF = 5e-10, MOST_MISSED = 5e-9; /* of the largest force; m/s or rad/s */
    return s->off <= MOST_OFF * s->force && s->row_missed <= MOST_MISSED;
}

/* Solves for the next stiffer floor where Newton's method has not converged from the forces at this one: once more from
 * them by (75), or in smaller islands with steps with given limits. Returns false when memory ran out. */
static bool try_again(pinch_arena *arena, pinch_force_system *s, descent *d, double next, pinch_solver_result *part)
{
    static const double EASE = 4; /* of the floor */
    pinch_solver_result *total = &d->result->solve;
    const pinch_solver_settings *settings = d->settings;
    if (pinch_force_may_approach(s)) {
        pinch_force_keep(s, &d->kept, true);
        return pinch_force_approach(arena, s, settings, (pinch_force_proximal){next, EASE * next, 0, d->center}, total,
                                    part);
    }
    if (!pinch_force_may_give_limits(s, settings, total->iterations)) return true;
    pinch_force_keep(s, &d->kept, true);
    bool served = pinch_force_tresca(arena, s, settings->max_iterations - total->iterations, &total->iterations);
    if (arena->failed || !served) return !arena->failed;
    return pinch_force_newton_within(arena, s, settings, LATER_LIMIT, total, part);
}

/*
 * Solves for the next stiffer floor, from the forces at this one: a much better start than the last step's forces.
 * Where Newton's method fails from there, steps with given limits of friction lead it to a better one, or (75).
 * Where it does not converge, or below LOWEST_FLOOR is not exact any more, *floor and its answer stay. So they do where
 * the stiffer one tells that the answer counts: then bodies are jammed, and all that would become stiffer is what they
 * press each other with. Returns false when memory ran out.
 */
static bool try_stiffer(pinch_arena *arena, pinch_force_system *s, descent *d, double next, double *floor,
                        bool *converged)
{
    pinch_solver_result part, *total = &d->result->solve;
    const pinch_solver_settings *settings = d->settings;
    *converged = false;
    if (total->iterations >= settings->max_iterations || s->work > s->budget) return true;
    pinch_force_keep(s, &d->kept, false);
    for (int k = 0; k < s->contact_count; k++) d->short_of[k] = falls_short(&s->elements[k]);
    for (int j = 0; j < d->problem->row_count; j++) d->row_forces[j] = pinch_force_of_row(s, j);
    start_stiffer(s, &d->kept, *floor, next);
    if (!pinch_force_newton_within(arena, s, settings, LATER_LIMIT, total, &part)) return false;
    if (part.status != PINCH_SOLVE_CONVERGED && !try_again(arena, s, d, next, &part)) return false;
    *converged = part.status == PINCH_SOLVE_CONVERGED && (next >= LOWEST_FLOOR || holds_closely(s));
    bool counts = false, tells = *converged && !a_motor_will_give_way(s, d, *floor, next);
    if (tells) {
        bound_sinks(s, d, *floor / (*floor - next), d->sinks);
        counts = *floor <= PINCH_FORCE_MOST_MISSED && !pinch_force_sinks_far(arena, d->problem, s, d->sinks);
        if (arena->failed) return false;
    }
    bool done = *converged && !counts;
    if (tells) bound_sinks(s, d, (done ? next : *floor) / (*floor - next), NULL);
    if (done) {
        total->residual = part.residual;
        *floor = next;
        return true;
    }
    pinch_force_keep(s, &d->kept, true);
    pinch_force_set_floor(s, *floor);
    (void)pinch_force_evaluate(s);
    return true;
}

/*
 * Goes back down while the floor is one that the answer would not count with, by equation (60) or because bodies sink;
 * stiffer floors would only make the next steps dearer. Strides are counted as factors. In heaps of boxes one of 5 has
 * an answer in a tenth of the tries, and the others take all of their Newton steps; one of 1.25 has it in four fifths,
 * after a few. So the first is between the two, each answer doubles the next one's logarithm, and where there is none a
 * floor that is near is tried, which tells as well what the floor does. Five tries go down by four levels and more.
 * Without `tries` it only tells whether the answer counts. Returns false when memory ran out.
 */
static bool stiffen(pinch_arena *arena, pinch_force_system *s, descent *d, bool tries, double *floor)
{
    enum { TRIES = 5 };
    static const double FIRST = 2.2, NEAR = 1.25, LARGEST = 5;
    double factor = FIRST;
    for (int try = 0; try < TRIES; try++) {
        double least = *floor > PINCH_FORCE_MOST_MISSED ? PINCH_FORCE_FIRST_FLOOR
                       : *floor > LOWEST_FLOOR          ? LOWEST_FLOOR
                                                        : STIFFEST_FLOOR;
        pinch_force_sinks(d->problem, s, d->sinks);
        bool counts = *floor <= PINCH_FORCE_MOST_MISSED && !pinch_force_sinks_far(arena, d->problem, s, d->sinks);
        if (arena->failed) return false;
        d->result->gave_way = d->result->gave_way || !counts;
        s->answer_counts = counts;
        if (counts || *floor <= least || !tries) return true;
        if (try == 0 && !make_room_for_tries(arena, s, d)) return false;
        bool converged;
        if (!try_stiffer(arena, s, d, fmax(least, *floor / factor), floor, &converged)) return false;
        if (!converged && factor == NEAR) return true;
        factor = converged ? fmin(factor * factor, LARGEST) : NEAR;
    }
    return true;
}

static void sweep_from_warm_start(pinch_force_system *s, const pinch_problem *problem)
{
    pinch_force_warm_start(s, problem);
    pinch_force_sweeps(s, SWEEPS);
    s->work += (double)SWEEPS * s->element_count;
}

/* Finds forces from which the first retry or a later one begins. Returns false when memory ran out. */
static bool find_start(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem, int try,
                       const pinch_solver_settings *settings, int *steps)
{
    bool may = try == 1 && pinch_force_may_give_limits(s, settings, *steps);
    sweep_from_warm_start(s, problem);
    if (!may) return true;
    if (!pinch_force_tresca(arena, s, settings->max_iterations - *steps, steps)) sweep_from_warm_start(s, problem);
    return !arena->failed;
}

/*
 * Tells whether stiffer floors are tried for an answer at the floor of the last step. In a heap with many contacts that
 * takes a hundred times as long as the answer did. Where it was in vain for long, the heap lies still as a rule, and it
 * would be in vain in the next step, too: so it is tried now and then.
 */
static bool stiffer_ones_are_due(const pinch_force_system *s, const held_floor *last)
{
    enum { MANY = 100, SOON = 64, BETWEEN = 32 };
    int quiet = last->span - last->hold;
    return s->contact_count <= MANY || last->hold == 0 || quiet <= SOON || quiet % BETWEEN == 0;
}

/* Returns how the forces of a heap are led to a floor from those of the last step. */
static pinch_force_proximal way_to_floor(double floor, pinch_force_answer *center)
{
    return (pinch_force_proximal){.floor = floor, .ease = 1e-2, .sweeps = 500, .center = center};
}

/*
 * First the floor of the last step is tried from the warm start, then the same from Gauss-Seidel sweeps and steps with
 * given limits of friction, in heaps by (75), then floor level by floor level, and back down from where one is found,
 * or from a floor of an earlier step. Returns false when memory ran out.
 */
static bool continue_in_compliance(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                                   const pinch_solver_settings *settings, double *floor, pinch_step_result *result)
{
    pinch_solver_result *total = &result->solve;
    int tries = may_soften(problem) ? LEVELS : 2;
    double last = *floor;
    bool heap = tries > 2 && pinch_force_may_approach(s);
    pinch_force_answer center = {0};
    if (heap && !pinch_force_make_room(arena, s, &center)) return false;
    pinch_solver_result part;
    memset(total, 0, sizeof *total);
    total->status = PINCH_SOLVE_MAX_ITERATIONS;
    for (int try = 0; try < tries && (try < 2 || *floor < SOFTEST); try++) {
        if (try > 1) *floor *= LEVEL_FACTOR;
        if (try == 1 && heap) *floor = fmin(*floor, PINCH_FORCE_FLOOR_OF_HEAPS);
        pinch_force_warm_start(s, problem);
        pinch_force_set_floor(s, *floor);
        pinch_force_proximal way = way_to_floor(*floor, &center);
        bool ran;
        if (heap && try == 0)
            ran = pinch_force_begin_heap(arena, s, settings, &way, FIRST_LIMIT, total, &part);
        else if (heap)
            ran = pinch_force_approach(arena, s, settings, way, total, &part);
        else
            ran = (try == 0 || find_start(arena, s, problem, try, settings, &total->iterations)) &&
                  pinch_force_newton_within(arena, s, settings, try == 0 ? FIRST_LIMIT : LATER_LIMIT, total, &part);
        if (!ran) return false;
        if (heap) *floor = way.floor;
        total->status = part.status;
        total->residual = part.residual;
        if (part.status == PINCH_SOLVE_CONVERGED || s->work > s->budget) break;
        if (try == 0 && s->split_products > 0) {
            s->given_up = true; /* at any higher floor a tall pile sinks as a whole, and the way back down takes long */
            return true;
        }
    }
    if (tries == 2 || total->status != PINCH_SOLVE_CONVERGED) return true;
    descent down = {.problem = problem,
                    .settings = settings,
                    .center = &center,
                    .result = result,
                    .sinks = PINCH_ARENA_ARRAY(arena, double, s->contact_count + 1)};
    return !arena->failed && stiffen(arena, s, &down, *floor > last || s->may_stiffen, floor);
}

/*
 * Leads the forces near a solution along a path, first at the floor of the last step and then at softer ones. *total
 * says how the solve had ended before; where no path arrives, it stays so, and the velocities are those of the forces
 * that the last path began with. Returns false when memory ran out.
 */
static bool continue_along_path(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                                const pinch_solver_settings *settings, double *floor, pinch_solver_result *total)
{
    enum { PATHS = 3 };
    static const double SOFTER = 25;
    pinch_solver_result part;
    pinch_force_warm_start(s, problem);
    if (s->mobility->unknowns + s->multiplier_count > PINCH_PATH_MOST_UNKNOWNS) {
        pinch_force_move(s);
        return true;
    }
    int tries = may_soften(problem) ? PATHS : 1;
    double each = pow((s->mobility->unknowns + s->multiplier_count + 1) / 6.0, 3) / 3 + s->element_count;
    for (int try = 0; try < tries && total->status != PINCH_SOLVE_CONVERGED; try++) {
        int steps = settings->max_iterations - total->iterations;
        bool arrived;
        if (try > 0) *floor = fmin(SOFTER * *floor, SOFTEST);
        if (steps > PINCH_PATH_MOST_STEPS) steps = PINCH_PATH_MOST_STEPS;
        if (steps > (s->budget - s->work) / each) steps = (int)((s->budget - s->work) / each);
        pinch_force_warm_start(s, problem);
        pinch_force_set_floor(s, *floor);
        if (!pinch_force_follow_path(arena, s, &steps, &arrived)) return false;
        total->iterations += steps;
        s->work += each * steps;
        if (!arrived) continue;
        if (!pinch_force_newton(arena, s, settings, LATER_LIMIT, &part)) return false;
        total->by_flow = true;
        total->status = part.status;
        total->iterations += part.iterations;
        total->newton_steps += part.newton_steps;
        total->residual = part.residual;
    }
    if (total->status != PINCH_SOLVE_CONVERGED) pinch_force_move(s);
    return true;
}

/* An island that is so tall and has so many contacts that complete factors would not be made for Newton's method is
 * approximated at once: iterations fail there. Returns false when memory ran out. */
static bool solve_or_approximate(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                                 const pinch_solver_settings *settings, double *floor, pinch_step_result *result)
{
    enum { MANY = 2000 };
    if (settings->sweeps > 0 && problem->contact_count > MANY) {
        if (!pinch_force_may_split(arena, s, settings->sweeps)) return false;
        s->given_up = s->split_products > 0 && s->dear;
    }
    if (!s->given_up && !continue_in_compliance(arena, s, problem, settings, floor, result)) return false;
    return !s->given_up || pinch_force_approximate(arena, s, problem, settings, floor, result);
}

static bool go_one_way(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                       const pinch_solver_settings *settings, pinch_force_way way, double *floor,
                       pinch_step_result *result)
{
    switch (way) {
    case PINCH_FORCE_BY_PATH:
        return continue_along_path(arena, s, problem, settings, floor, &result->solve);
    case PINCH_FORCE_BY_SWEEPS:
        return pinch_force_may_split(arena, s, settings->sweeps) &&
               pinch_force_approximate(arena, s, problem, settings, floor, result);
    default:
        return solve_or_approximate(arena, s, problem, settings, floor, result);
    }
}

/* Returns how many levels a floor is above the first. */
static int level_of(double floor)
{
    if (floor <= PINCH_FORCE_FIRST_FLOOR) return 0;
    return (int)fmax(0, ceil(log(floor / PINCH_FORCE_FIRST_FLOOR) / log(LEVEL_FACTOR) - 1e-6));
}

bool pinch_force_solve(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                       const pinch_solver_settings *settings, pinch_force_way way, pinch_force_system *s,
                       pinch_step_result *result)
{
    held_floor last;
    if (!last_floor(arena, problem, &last)) return false;
    double share, floor = last.floor;
    if (!pinch_force_system_build(arena, problem, mobility, s)) return false;
    s->budget = settings->budget > 0 ? settings->budget : INFINITY;
    s->may_stiffen = stiffer_ones_are_due(s, &last);
    if (!go_one_way(arena, s, problem, settings, way, &floor, result)) return false;
    result->unknowns = mobility->unknowns + s->multiplier_count;
    result->over_budget = s->given_up || s->work > s->budget;
    result->work += s->work;
    if (result->solve.status != PINCH_SOLVE_CONVERGED) return true;
    result->floor_level = level_of(floor);
    if (!pinch_force_read_back(arena, problem, s, result, &share)) return false;
    remember_floor(problem, &last, floor, share);
    return true;
}
