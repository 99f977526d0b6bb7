/* The same world by each solver in turn. */
#include "duel.h"

#include "allocations.h"
#include "common/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WARM_UP = 40, FEWEST = 7, MOST = 2001 };

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

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

static void copy_state(const bench_world *from, bench_world *to)
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

/* What a duel works on. */
typedef struct arena {
    const duel_plan *plan;
    bench_world worlds[BENCH_SOLVERS];
    bool taking_part[BENCH_SOLVERS];
    double seconds[BENCH_SOLVERS][MOST], ratio[2][MOST];
    double *built; /* 3 per body: where it was built, m */
} arena;

static bool note_built(arena *a, const bench_world *w)
{
    a->built = calloc(3 * (size_t)w->body_count + 1, sizeof *a->built);
    for (int k = 0; k < w->body_count && a->built; k++)
        memcpy(a->built + 3 * k, dBodyGetPosition(w->bodies[k]), 3 * sizeof *a->built);
    return a->built != NULL;
}

static bool set_up(arena *a, int size)
{
    const duel_plan *plan = a->plan;
    bool fine = true;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        bench_settings settings = {(bench_solver)k, plan->cold, plan->threads};
        bench_world_make(&a->worlds[k], &settings, plan->step);
        plan->build(&a->worlds[k], size);
        a->taking_part[k] = k != BENCH_WORLDSTEP || plan->worldstep;
        fine = fine && !a->worlds[k].failed;
    }
    double seconds;
    bench_world *first = &a->worlds[plan->settler];
    fine = fine && note_built(a, first);
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        if (k != (int)plan->settler && !(plan->each_settles && a->taking_part[k])) continue;
        for (int i = 0; i < plan->settle && fine; i++) fine = step(&a->worlds[k], &seconds);
    }
    for (int k = 0; k < BENCH_SOLVERS && plan->settle > 0 && !plan->each_settles; k++)
        if (k != (int)plan->settler) copy_state(first, &a->worlds[k]);
    return fine;
}

/* false: a step failed */
static bool warm_up(arena *a)
{
    double seconds, start = clock_seconds();
    for (int i = 0; i < WARM_UP && (i < 3 || clock_seconds() - start < a->plan->budget); i++)
        for (int k = 0; k < BENCH_SOLVERS; k++) {
            if (!a->taking_part[k]) continue;
            if (!step(&a->worlds[k], &seconds)) return false;
            if (k == BENCH_WORLDSTEP && seconds > 1) a->taking_part[k] = false;
        }
    return true;
}

static bool measure(arena *a, duel *result)
{
    long allocations[BENCH_SOLVERS] = {0};
    double start = clock_seconds();
    pinch_ode_reset_statistics(a->worlds[BENCH_PINCH].pinch);
    int i = 0;
    for (; i < MOST && (i < FEWEST || clock_seconds() - start < a->plan->budget); i++) {
        for (int k = 0; k < BENCH_SOLVERS; k++) {
            bench_world *w = &a->worlds[k];
            if (!a->taking_part[k]) continue;
            bench_prepare(w);
            long before = allocations_counted();
            a->seconds[k][i] = bench_step(w);
            allocations[k] += allocations_counted() - before;
            if (w->failed || a->seconds[k][i] < 0) return false;
            result->side[k].residual = fmax(result->side[k].residual, bench_residual(w));
        }
        a->ratio[0][i] = a->seconds[BENCH_PINCH][i] / a->seconds[BENCH_QUICKSTEP][i];
        a->ratio[1][i] = a->seconds[BENCH_PINCH][i] / a->seconds[BENCH_WORLDSTEP][i];
    }
    result->rounds = i;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        result->side[k].allocations = (double)allocations[k] / i;
        result->side[k].seconds = a->taking_part[k] ? median(a->seconds[k], i) : NAN;
        result->side[k].iterations = k == BENCH_QUICKSTEP ? dWorldGetQuickStepNumIterations(a->worlds[k].ode) : NAN;
    }
    result->ratio = median(a->ratio[0], i);
    result->worldstep_ratio = a->taking_part[BENCH_WORLDSTEP] ? median(a->ratio[1], i) : NAN;
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

static double farthest(const bench_world *w, const double *built)
{
    double most = 0;
    for (int k = 0; k < w->body_count; k++) {
        const double *x = dBodyGetPosition(w->bodies[k]), *from = built + 3 * k;
        most = fmax(most, hypot(hypot(x[0] - from[0], x[1] - from[1]), x[2] - from[2]));
    }
    return most;
}

static void read_out(const arena *a, duel *result)
{
    const bench_world *w = &a->worlds[BENCH_PINCH];
    pinch_ode_stats stats = pinch_ode_statistics(w->pinch);
    duel_side *ours = &result->side[BENCH_PINCH];
    ours->iterations = (double)stats.iterations / (double)stats.islands;
    ours->memory = stats.memory;
    ours->unsolved = stats.unconverged_steps;
    ours->solver_residual = stats.residual_max;
    result->contacts = w->contact_count;
    result->bodies = w->body_count;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        duel_side *side = &result->side[k];
        side->energy = kinetic_energy(&a->worlds[k]);
        side->moved = farthest(&a->worlds[k], a->built);
        side->stands = a->plan->stands > 0 && side->moved <= a->plan->stands;
    }
}

bool duel_run(const duel_plan *plan, int size, duel *result)
{
    arena *a = calloc(1, sizeof *a);
    memset(result, 0, sizeof *result);
    result->size = size;
    if (!a) return false;
    a->plan = plan;
    bool fine = set_up(a, size) && warm_up(a) && measure(a, result);
    if (fine) read_out(a, result);
    for (int k = 0; k < BENCH_SOLVERS; k++) bench_world_free(&a->worlds[k]);
    free(a->built);
    free(a);
    return fine;
}
