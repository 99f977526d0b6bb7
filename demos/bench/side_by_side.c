#include "side_by_side.h"

#include "allocations.h"
#include "common/measure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of the steps of a turn the last is timed: it finds in the caches what the others have left there, as the steps of a
 * run do. */
enum { WARM_UP = 40, TURN = 2, FEWEST = 7, MOST = 2001 };
enum { CONTACT, WHOLE, PARTS };

static void copy_bodies(int count, const dBodyID *from, const dBodyID *to)
{
    for (int k = 0; k < count; k++) {
        const double *x = dBodyGetPosition(from[k]), *v = dBodyGetLinearVel(from[k]),
                     *omega = dBodyGetAngularVel(from[k]);
        dBodySetPosition(to[k], x[0], x[1], x[2]);
        dBodySetQuaternion(to[k], dBodyGetQuaternion(from[k]));
        dBodySetLinearVel(to[k], v[0], v[1], v[2]);
        dBodySetAngularVel(to[k], omega[0], omega[1], omega[2]);
    }
}

void bench_copy_state(const bench_world *from, bench_world *to)
{
    copy_bodies(from->body_count, from->bodies, to->bodies);
    copy_bodies(from->driven_count, from->driven, to->driven);
    to->steps = from->steps;
    to->time = from->time;
}

static bool step(bench_world *w, double *seconds)
{
    bench_prepare(w);
    *seconds = w->failed ? -1 : bench_step(w);
    return *seconds >= 0;
}

/* The worlds and the times measured in them. */
typedef struct timing_buffer {
    const timing_plan *plan;
    int size;
    bench_world worlds[BENCH_SOLVERS];
    bool taking_part[BENCH_SOLVERS];
    double seconds[BENCH_SOLVERS][PARTS][MOST], ratio[BENCH_SOLVERS][PARTS][MOST]; /* ratio: of Pinch's to theirs */
    double *built; /* 3 per body: where it was built, m */
} timing_buffer;

static bool note_built(timing_buffer *b, const bench_world *w)
{
    b->built = calloc(3 * (size_t)w->body_count + 1, sizeof *b->built);
    for (int k = 0; k < w->body_count && b->built; k++)
        memcpy(b->built + 3 * k, dBodyGetPosition(w->bodies[k]), 3 * sizeof *b->built);
    return b->built != NULL;
}

/* In all worlds that settle by themselves. */
static int settling_steps(const timing_plan *plan)
{
    return plan->settle * (plan->each_settles ? BENCH_SOLVERS : 1);
}

/* Tells what goes on. Settling takes time as bodies and steps do; warming up and measuring take at most the budget
 * each. */
static void tell(const timing_buffer *b, const char *what, double settled, double measured)
{
    const timing_progress *p = b->plan->progress;
    double spent = clock_seconds() - p->line->started;
    double steps = settling_steps(b->plan);
    double left = p->pace * (b->size * (steps - settled) + p->later_size * steps) +
                  b->plan->budget * (2 * p->later + 2) - measured;
    char text[160];
    snprintf(text, sizeof text, "%s, size %d: %s", p->series, b->size, what);
    progress_tell(p->line, text, spent / (spent + fmax(left, 0)));
}

/* Steps until the world has settled. */
static bool settle(timing_buffer *b, bench_world *w, int before)
{
    double seconds, start = clock_seconds();
    timing_progress *p = b->plan->progress;
    for (int i = 0; i < b->plan->settle; i++) {
        char what[128];
        if (!step(w, &seconds)) return false;
        if (!progress_is_due(p->line)) continue;
        p->pace = (clock_seconds() - start) / ((double)(i + 1) * b->size);
        snprintf(what, sizeof what, "settles, %d of %d steps, %.3g s of %.3g s simulated", i + 1, b->plan->settle,
                 w->time, b->plan->settle * b->plan->step);
        tell(b, what, before + i + 1, 0);
    }
    p->pace = (clock_seconds() - start) / ((double)b->plan->settle * b->size);
    return true;
}

static bool set_up(timing_buffer *b, int size)
{
    const timing_plan *plan = b->plan;
    bool fine = true;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        bench_settings settings = {.solver = (bench_solver)k, .cold = plan->cold, .threads = plan->threads};
        bench_world_make(&b->worlds[k], &settings, plan->step);
        plan->build(&b->worlds[k], size);
        b->taking_part[k] = k != BENCH_WORLDSTEP || plan->worldstep;
        fine = fine && !b->worlds[k].failed;
    }
    int settled = 0;
    bench_world *first = &b->worlds[plan->settler];
    fine = fine && note_built(b, first);
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        if (k != (int)plan->settler && !(plan->each_settles && b->taking_part[k])) continue;
        fine = fine && settle(b, &b->worlds[k], settled);
        settled += plan->settle;
    }
    for (int k = 0; k < BENCH_SOLVERS && fine && plan->settle > 0 && !plan->each_settles; k++)
        if (k != (int)plan->settler) bench_copy_state(first, &b->worlds[k]);
    return fine;
}

/* Returns false when a step fails. */
static bool warm_up(timing_buffer *b)
{
    double seconds, start = clock_seconds();
    for (int i = 0; i < WARM_UP && (i < 3 || clock_seconds() - start < b->plan->budget); i++) {
        if (progress_is_due(b->plan->progress->line)) tell(b, "warms up", settling_steps(b->plan), 0);
        for (int k = 0; k < BENCH_SOLVERS; k++) {
            if (!b->taking_part[k]) continue;
            if (!step(&b->worlds[k], &seconds)) return false;
            if (k == BENCH_WORLDSTEP && seconds > 1) b->taking_part[k] = false;
        }
    }
    return true;
}

static void tell_measuring(const timing_buffer *b, int round, double spent)
{
    char what[128];
    if (!progress_is_due(b->plan->progress->line)) return;
    snprintf(what, sizeof what, "measures, %d rounds, %.1f s of about %g s", round, spent, b->plan->budget);
    tell(b, what, settling_steps(b->plan), b->plan->budget + spent);
}

static bool measure(timing_buffer *b, side_by_side *result)
{
    long allocations[BENCH_SOLVERS] = {0};
    double start = clock_seconds();
    pinch_ode_reset_statistics(b->worlds[BENCH_PINCH].pinch);
    int i = 0;
    for (; i < MOST && (i < FEWEST || clock_seconds() - start < b->plan->budget); i++) {
        for (int k = 0; k < BENCH_SOLVERS; k++) {
            bench_world *w = &b->worlds[k];
            for (int s = 0; s < TURN && b->taking_part[k]; s++) {
                double detected = bench_prepare(w);
                long before = allocations_counted();
                double seconds = b->seconds[k][CONTACT][i] = bench_step(w);
                allocations[k] += allocations_counted() - before;
                if (w->failed || seconds < 0) return false;
                b->seconds[k][WHOLE][i] = detected + seconds;
                result->of[k].residual = fmax(result->of[k].residual, bench_residual(w));
            }
        }
        tell_measuring(b, i, clock_seconds() - start);
        for (int k = 0; k < BENCH_SOLVERS * PARTS; k++)
            b->ratio[k / PARTS][k % PARTS][i] =
                b->seconds[BENCH_PINCH][k % PARTS][i] / b->seconds[k / PARTS][k % PARTS][i];
    }
    result->rounds = i;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        result->of[k].allocations = (double)allocations[k] / ((double)TURN * i);
        result->of[k].seconds = b->taking_part[k] ? median(b->seconds[k][CONTACT], i) : NAN;
        result->of[k].whole = b->taking_part[k] ? median(b->seconds[k][WHOLE], i) : NAN;
        result->of[k].iterations = k == BENCH_QUICKSTEP ? dWorldGetQuickStepNumIterations(b->worlds[k].ode) : NAN;
    }
    for (int part = 0; part < PARTS; part++) {
        result->ratio[part] = median(b->ratio[BENCH_QUICKSTEP][part], i);
        result->worldstep_ratio[part] =
            b->taking_part[BENCH_WORLDSTEP] ? median(b->ratio[BENCH_WORLDSTEP][part], i) : NAN;
    }
    return true;
}

static double kinetic_energy(const bench_world *w)
{
    double sum = 0;
    for (int k = 0; k < w->body_count; k++) {
        dMass mass;
        const double *v = dBodyGetLinearVel(w->bodies[k]);
        dBodyGetMass(w->bodies[k], &mass);
        sum += 0.5 * mass.mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    return sum;
}

static double fastest(const bench_world *w)
{
    double most = 0;
    for (int k = 0; k < w->body_count; k++) most = fmax(most, dCalcVectorLength3(dBodyGetLinearVel(w->bodies[k])));
    return most;
}

static double farthest(const bench_world *w, const double *built)
{
    double most = 0;
    for (int k = 0; k < w->body_count; k++) {
        const double *x = dBodyGetPosition(w->bodies[k]), *from = built + 3 * k;
        most = fmax(most, hypot(hypot(x[0] - from[0], x[1] - from[1]), x[2] - from[2]));
    }
    return most;
}

static void read_out(const timing_buffer *b, side_by_side *result)
{
    const bench_world *w = &b->worlds[BENCH_PINCH];
    pinch_ode_stats stats = pinch_ode_statistics(w->pinch);
    solver_timing *ours = &result->of[BENCH_PINCH];
    ours->iterations = (double)stats.iterations / (double)stats.islands;
    ours->memory = stats.memory;
    ours->unsolved = stats.unconverged_steps;
    ours->solver_residual = stats.residual_max;
    result->contacts = w->contact_count;
    result->bodies = w->body_count;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        solver_timing *side = &result->of[k];
        side->energy = kinetic_energy(&b->worlds[k]);
        side->fastest = fastest(&b->worlds[k]);
        side->moved = farthest(&b->worlds[k], b->built);
        side->stands = b->plan->stands > 0 && side->moved <= b->plan->stands;
    }
}

bool time_side_by_side(const timing_plan *plan, int size, side_by_side *result)
{
    timing_buffer *b = calloc(1, sizeof *b);
    memset(result, 0, sizeof *result);
    result->size = size;
    if (!b) return false;
    b->plan = plan;
    b->size = size;
    bool fine = set_up(b, size) && warm_up(b) && measure(b, result);
    if (fine) read_out(b, result);
    for (int k = 0; k < BENCH_SOLVERS; k++) bench_world_free(&b->worlds[k]);
    free(b->built);
    free(b);
    return fine;
}
