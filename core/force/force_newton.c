#include "force/force_joints.h"

#include <math.h>
#include <string.h>

enum { MAX_HALVINGS = 8 };
static const double ARMIJO = 1e-4;

/*
 * Where contacts open, close or begin to slip, the merit rises along the step that finds them out, and a line search
 * that insists on descent creeps. So full steps are taken on trust (a watchdog; Chamberlain, Powell, Lemarechal and
 * Pedersen, "The watchdog technique for forcing convergence in algorithms for constrained optimization", 1982): this
 * many in a row without a gain, and none to this many times the least merit so far. Steps to a merit below TRUSTED are
 * taken in any case: forces of the last step are a good start, and a contact that closes raises the merit from there by
 * much more than that, but to no more than what Newton's method starts from elsewhere.
 */
enum { PATIENCE = 4 };
static const double LEEWAY = 300, TRUSTED = 1e-2, GAIN = 0.9;

/* Newton's method converges by squares: from any merit below the root of the tolerance, the next step on the right
 * piece is the last. */
typedef struct watchdog {
    double least, near; /* merits: the least so far; one from which a step reaches the tolerance */
    int waited;
} watchdog;

/*
 * Where rows may depend on each other, there is no limit to what is taken on trust. A contact that joints hold is
 * pushed against them by a step as if it stayed closed, with a force as large as the rows' small compliance allows.
 * That opens it, and the next step is right.
 */
static double leeway_of(const pinch_force_system *s)
{
    return s->dependent_rows ? INFINITY : LEEWAY;
}

/*
 * The tolerance holds for an island, but an answer is checked contact by contact. So steps go on to a part of the
 * tolerance, and until no contact's force is off by more than a part of the largest. That holds for forces that might
 * do as they are, too: at a tenth of the tolerance a stack that stands still creeps by a micrometre a second. Forces of
 * the last step that would do as an answer are still taken a step further, unless they are better than that by far:
 * what they lack keeps a stack trembling that would come to rest.
 */
typedef struct precision {
    double merit; /* of the tolerance */
    double off;   /* of the largest force */
    double rows;  /* of the scale: the largest error of a joint row's multiplier */
    double speed; /* m/s or rad/s: the largest that a joint row misses; the check of an answer lets 1e-9 pass */
} precision;
static const precision SOLVED = {1e-2, 1e-10, INFINITY, INFINITY}, SETTLED = {1, 5e-10, 1e-14, 5e-10},
                       UTMOST = {0, 0, 0, 0}, AT_REST = {1e-2, 2e-14, INFINITY, INFINITY};

/* A first pass of joint rows that others follow is not solved to the end: force_passes.c. */
static const precision APPROACHED = {PINCH_FORCE_APPROACHED, INFINITY, INFINITY, INFINITY};

/* keep and restore put r and y aside and bring them back. */
static void keep_elements(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *r = pinch_force_values(e, PINCH_FORCE_R);
        double *start = pinch_force_values(e, PINCH_FORCE_START);
        for (int i = 0; i < e->rows; i++) start[i] = r[i];
    }
}

static void keep(pinch_force_system *s)
{
    pinch_loop(s->crew, s->element_count, keep_elements, s);
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].start = s->multipliers[i].y;
}

static void restore(pinch_force_system *s)
{
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *start = pinch_force_values(e, PINCH_FORCE_START);
        double *r = pinch_force_values(e, PINCH_FORCE_R);
        for (int i = 0; i < e->rows; i++) r[i] = start[i];
    }
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].y = s->multipliers[i].start;
}

typedef struct move_task {
    const pinch_force_system *system;
    double part;
} move_task;

static void move_elements(void *argument, int first, int end)
{
    const move_task *task = argument;
    const pinch_force_system *s = task->system;
    double t = task->part;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *start = pinch_force_values(e, PINCH_FORCE_START);
        const double *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
        double *r = pinch_force_values(e, PINCH_FORCE_R);
        for (int i = 0; i < e->rows; i++) r[i] = start[i] + t * change[i];
    }
}

static void move(pinch_force_system *s, double t)
{
    move_task task = {s, t};
    pinch_loop(s->crew, s->element_count, move_elements, &task);
    for (int i = 0; i < s->multiplier_count; i++)
        s->multipliers[i].y = s->multipliers[i].start + t * s->multipliers[i].change;
}

static void step_elements(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
        double *start = pinch_force_values(e, PINCH_FORCE_START), *r = pinch_force_values(e, PINCH_FORCE_R);
        for (int i = 0; i < e->rows; i++) {
            start[i] = r[i];
            r[i] += change[i];
        }
    }
}

/* Keeps r and y, and takes the whole step. */
static void take_step(pinch_force_system *s)
{
    pinch_loop(s->crew, s->element_count, step_elements, s);
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->start = m->y;
        m->y += m->change;
    }
}

/* Searches along one step. Returns the merit afterwards, or NaN when no step was found; r is then what it was. */
static double search(pinch_force_system *s, double merit, watchdog *w)
{
    double t = 1;
    take_step(s);
    for (int halvings = 0; halvings <= MAX_HALVINGS; halvings++, t *= 0.5) {
        if (halvings > 0) move(s, t);
        double next = pinch_force_evaluate(s);
        bool trusted = t == 1 && w->waited < PATIENCE;
        if (trusted && !(next <= fmax(leeway_of(s) * w->least, fmax(TRUSTED, w->near)))) w->waited = PATIENCE;
        if (next <= (1 - ARMIJO * t) * merit || (trusted && w->waited < PATIENCE)) {
            w->waited = w->waited >= PATIENCE || next > GAIN * w->least ? w->waited + 1 : 0;
            w->least = fmin(w->least, next);
            return next;
        }
    }
    restore(s);
    (void)pinch_force_evaluate(s);
    return NAN;
}

/* Does the law leave the force as it is: inside the limits by its trial value and by itself? */
static bool lies_inside(const pinch_force_element *e)
{
    const double *r = pinch_force_values(e, PINCH_FORCE_R);
    double p[PINCH_CONTACT_ROWS_MAX];
    if (!e->inside) return false;
    (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO), r, p, NULL);
    return memcmp(p, r, sizeof *p * (size_t)e->rows) == 0;
}

static const double ROUNDING = 4e-16; /* of the largest force; of the scale */

/* Puts multipliers that are taken to be at a bound there exactly: steps leave some a bit beside it. Tells whether one
 * moved by more than rounding. */
static bool settle_multipliers(pinch_force_system *s)
{
    bool moved = false;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        if (m->bound == 0) continue;
        moved = moved || fabs(m->f) > ROUNDING * s->scale;
        m->y -= m->f;
    }
    return moved;
}

static void settle_elements(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    bool moved = false;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        double *r = pinch_force_values(e, PINCH_FORCE_R), f[PINCH_CONTACT_ROWS_MAX];
        if (lies_inside(e)) continue;
        pinch_force_residual(e, f);
        for (int i = 0; i < e->rows; i++) {
            moved = moved || fabs(f[i]) > ROUNDING * s->force;
            r[i] -= f[i];
        }
    }
    s->partials[first / PINCH_CHUNK].any = moved;
}

/*
 * Puts the forces onto their cones exactly: r = P(z) at the solution. Those inside stay as they are: moved all at once,
 * each as if it were alone, they would end farther from the solution. The same holds for multipliers between their
 * bounds. Returns the merit, which is not found anew where nothing moves by more than rounding.
 */
static double settle(pinch_force_system *s, double merit)
{
    bool moved = !s->in_contacts && settle_multipliers(s);
    pinch_loop(s->crew, s->element_count, settle_elements, s);
    return moved || pinch_force_any(s) ? pinch_force_evaluate(s) : merit;
}

static bool precise(const pinch_force_system *s, double merit, double tolerance, precision wanted)
{
    return merit <= wanted.merit * tolerance && s->off <= wanted.off * s->force && s->row_off <= wanted.rows &&
           s->row_missed <= wanted.speed;
}

/* Settles, but not where joint rows miss too much by what that moves. Returns the merit. */
static double settle_beside_rows(pinch_force_system *s, double merit)
{
    keep(s);
    double settled = settle(s, merit);
    if (s->row_missed <= SETTLED.speed) return settled;
    restore(s);
    return pinch_force_evaluate(s);
}

/*
 * Near the answer Newton's steps may go in circles between pieces of the law, for contacts that touch and hardly bear
 * anything, and a line search creeps. A sweep puts each contact on the piece that its neighbours leave to it. Returns
 * the merit.
 */
static double leave_circle(pinch_force_system *s, watchdog *w)
{
    pinch_force_sweeps(s, 1);
    s->work += s->element_count;
    w->waited = 0;
    return w->least = pinch_force_evaluate(s);
}

/*
 * Is the merit at the goal, or at what rounding leaves of it? The goal is a part of the scale, which is so large where
 * bodies are jammed that joint rows may miss more beside it than they should. Steps go on then, as far as rounding lets
 * them.
 */
static bool at_goal(const pinch_force_system *s, double merit, double goal)
{
    double rounding = pinch_force_rounding(s);
    if (!(merit <= fmax(goal, rounding))) return false;
    return s->row_missed <= SETTLED.speed || merit <= fmax(ROUNDING, rounding);
}

/* Returns the tolerance of a merit, or what rounding leaves of it. */
static double reached(const pinch_force_system *s, const pinch_solver_settings *settings, double merit)
{
    double tolerance = fmax(settings->tolerance, pinch_force_rounding(s));
    return merit <= tolerance || !isfinite(merit) ? tolerance : fmax(tolerance, pinch_force_rounding_of_motion(s));
}

/* Takes steps until the merit is as precise as wanted, or at the goal, or nothing is gained any more. Returns false
 * when memory ran out. */
static bool descend(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, precision wanted,
                    int limit, double *merit, int *steps)
{
    enum { MANY = 8 };
    watchdog w = {.least = *merit, .near = sqrt(settings->tolerance)};
    while (!at_goal(s, *merit, settings->goal) && *steps < limit) {
        if (precise(s, *merit, settings->tolerance, wanted) &&
            (*steps > 0 || wanted.merit > 1 || precise(s, *merit, settings->tolerance, AT_REST)))
            break;
        bool singular;
        if (!pinch_force_solve_linear(arena, s, *merit, &singular)) {
            (void)pinch_force_evaluate(s); /* as before the step: z */
            return singular;
        }
        double next = search(s, *merit, &w);
        if (isnan(next)) return true;
        bool creeps = w.waited > PATIENCE && next < w.near && !s->in_contacts;
        *merit = creeps ? leave_circle(s, &w) : next;
        ++*steps;
        if (*steps % MANY == 0 && *merit <= pinch_force_rounding_of_motion(s)) return true;
    }
    return true;
}

/* Makes the passes that dependent joint rows need, from an approach to the first on, and ends with one that is solved.
 * Returns false when memory ran out. */
static bool approach_rows(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, int limit,
                          double *merit, int *steps)
{
    pinch_force_passes passes = {.approach = true};
    while (s->dependent_rows) {
        if (s->in_contacts) pinch_force_satisfy_rows(s, true);
        pinch_force_pass_kind kind = pinch_force_next_pass(s, *merit, settings->tolerance, &passes);
        if (kind == PINCH_FORCE_NO_PASS) break;
        if (s->in_contacts && kind == PINCH_FORCE_FIRST_PASS)
            pinch_force_enter_contacts(s);
        else if (s->in_contacts && kind == PINCH_FORCE_FURTHER_PASS)
            pinch_force_advance_contacts(s);
        *merit = pinch_force_evaluate(s);
        if (!descend(arena, s, settings, SOLVED, *steps + limit, merit, steps)) return false;
    }
    return true;
}

/* Runs from where the forces are to the answer. Returns false when memory ran out. */
static bool run(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, int limit,
                double *merit, int *steps)
{
    *merit = pinch_force_evaluate(s);
    if (!descend(arena, s, settings, s->dependent_rows ? APPROACHED : SOLVED, limit, merit, steps)) return false;
    if (!approach_rows(arena, s, settings, limit, merit, steps)) return false;
    double tolerance = reached(s, settings, *merit);
    if (!(*merit <= tolerance && *merit > 0)) return true;
    double settled = settle_beside_rows(s, *merit);
    if (!precise(s, settled, tolerance, SETTLED) && !at_goal(s, *merit, settings->goal)) {
        restore(s); /* many contacts give way together */
        *merit = pinch_force_evaluate(s);
        if (!descend(arena, s, settings, UTMOST, *steps + limit, merit, steps)) return false;
        settled = settle_beside_rows(s, *merit);
    }
    *merit = settled;
    return true;
}

/* Puts multipliers beyond a bound at that bound. */
static void keep_bounds(pinch_force_system *s)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->y = fmin(fmax(m->y, m->unit.low), m->unit.high);
    }
}

/*
 * Does the same in the contacts alone, and finds the multipliers for the forces there. *done tells whether all that is
 * left to say is in *merit. Otherwise the rows miss more than rounding, or multipliers are at other bounds than those
 * that they were held at, and the steps on all blocks go on from here. Returns false when memory ran out.
 */
static bool run_in_contacts(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, int limit,
                            double *merit, int *steps, bool *done)
{
    pinch_force_enter_contacts(s);
    bool ran = run(arena, s, settings, limit, merit, steps);
    s->in_contacts = false;
    if (!ran) return false;
    double tolerance = reached(s, settings, *merit);
    *done = !(*merit <= tolerance) && !s->joints->bounded;
    pinch_force_satisfy_rows(s, true);
    *merit = pinch_force_evaluate(s);
    if (*done) return true;
    if (!precise(s, *merit, tolerance, SETTLED)) {
        pinch_force_refine_rows(s);
        *merit = pinch_force_evaluate(s);
    }
    if (s->joints->bounded) {
        keep_bounds(s);
        *merit = pinch_force_evaluate(s);
    }
    *done = *merit <= tolerance && (!s->joints->bounded || precise(s, *merit, tolerance, SETTLED));
    if (*done && s->joints->bounded && settle_multipliers(s)) *merit = pinch_force_evaluate(s);
    return true;
}

bool pinch_force_newton(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, int limit,
                        pinch_solver_result *result)
{
    double merit;
    int steps = 0;
    memset(result, 0, sizeof *result);
    bool done = false;
    if (!s->joints_tried) {
        s->joints_tried = true;
        if (!pinch_force_factor_joints(arena, s) || !pinch_force_condense(arena, s)) return false;
    }
    if (s->condensed && !run_in_contacts(arena, s, settings, limit, &merit, &steps, &done)) return false;
    if (!done) {
        if (s->kept_rows && !pinch_force_begin_rows(arena, s)) return false;
        if (!run(arena, s, settings, limit, &merit, &steps)) return false;
    }
    double tolerance = reached(s, settings, merit);
    result->iterations = result->newton_steps = steps;
    result->residual = merit;
    result->status = merit <= tolerance ? PINCH_SOLVE_CONVERGED
                     : isfinite(merit)  ? PINCH_SOLVE_MAX_ITERATIONS
                                        : PINCH_SOLVE_DIVERGED;
    return true;
}

bool pinch_force_newton_within(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings,
                               int limit, pinch_solver_result *total, pinch_solver_result *result)
{
    int left = settings->max_iterations - total->iterations;
    if (!pinch_force_newton(arena, s, settings, limit < left ? limit : left, result)) return false;
    total->iterations += result->iterations;
    total->newton_steps += result->newton_steps;
    return true;
}
