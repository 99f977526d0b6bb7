#include "paper.h"

#include "common/measure.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_REPEATS = 60, LEAST_ROUNDS = 5, MOST_ROUNDS = 25 };
static const double BUDGET = 1.0; /* s for the rounds of a problem, beyond the least number of them */

/* Sorts the values. For an even count the median is the upper of the two in the middle. */
static paper_spread spread_of(double *values, int count)
{
    double middle = median(values, count);
    return (paper_spread){values[count / 4], middle, values[(3 * count) / 4]};
}

typedef struct run {
    pinch_solver_result result;
    double time, instructions;
} run;

static run run_once(paper_problem *problem, const pinch_solver_settings *settings)
{
    run r;
    double instructions = instructions_now(), start = clock_thread_seconds();
    r.result = paper_problem_solve(problem, settings);
    r.time = clock_thread_seconds() - start;
    r.instructions = instructions_now() - instructions;
    return r;
}

/* The times of all runs of both methods. */
typedef struct samples {
    int rounds;
    double (*nsngrk)[MOST_ROUNDS];                         /* of each seed */
    double (*ratio)[MOST_ROUNDS];                          /* of each seed: over the runs of NSNMGK around it */
    double *nsnmgk;                                        /* of all runs */
    double iterations[PAPER_SEEDS], residual[PAPER_SEEDS]; /* of NSNGRK, by seed */
} samples;

/* Adds to sums, which `summarize` turns into means. */
static void note(paper_measurement *m, const run *r)
{
    if (r->result.status != PINCH_SOLVE_CONVERGED) m->status = r->result.status;
    m->iterations += r->result.iterations;
    m->projections += (double)r->result.projections;
    m->residual += r->result.residual;
    m->instructions += r->instructions;
}

/* A run of a seed between two of NSNMGK, the last of which is the first of the next seed. What slows the machine for a
 * while slows all three. */
static run run_between(paper_problem *problem, uint64_t seed, double *before, double *ratio, run *after)
{
    const pinch_solver_settings random = paper_settings(problem->faces, PINCH_SOLVER_NSNGRK, seed).solver,
                                sweeps = paper_settings(problem->faces, PINCH_SOLVER_NSNMGK, 1).solver;
    if (isnan(*before)) *before = run_once(problem, &sweeps).time;
    run r = run_once(problem, &random);
    *after = run_once(problem, &sweeps);
    *ratio = 2.0 * r.time / (*before + after->time);
    *before = after->time;
    return r;
}

static void run_rounds(paper_problem *problem, uint64_t first, double budget, samples *s, paper_pair *pair)
{
    double start = clock_thread_seconds();
    int least = budget > 0 ? 1 : LEAST_ROUNDS;
    if (budget <= 0) budget = BUDGET;
    for (s->rounds = 0; s->rounds < MOST_ROUNDS; s->rounds++) {
        if (s->rounds >= least && clock_thread_seconds() - start > budget) return;
        double before = NAN;
        for (int k = 0; k < PAPER_SEEDS; k++) {
            run after, r = run_between(problem, first + (uint64_t)k, &before, &s->ratio[k][s->rounds], &after);
            s->nsngrk[k][s->rounds] = r.time;
            s->nsnmgk[s->rounds * PAPER_SEEDS + k] = after.time;
            if (s->rounds > 0) continue; /* iterates do not depend on the round */
            note(&pair->nsngrk, &r);
            note(&pair->nsnmgk, &after);
            s->iterations[k] = r.result.iterations;
            s->residual[k] = r.result.residual;
        }
    }
}

static void divide(paper_measurement *m)
{
    m->iterations /= PAPER_SEEDS;
    m->projections /= PAPER_SEEDS;
    m->residual /= PAPER_SEEDS;
    m->instructions /= PAPER_SEEDS;
}

static void summarize(samples *s, paper_pair *pair)
{
    double by_seed[PAPER_SEEDS], ratios[PAPER_SEEDS];
    divide(&pair->nsngrk);
    divide(&pair->nsnmgk);
    pair->rounds = s->rounds;
    pair->nsnmgk.time = spread_of(s->nsnmgk, s->rounds * PAPER_SEEDS);
    for (int k = 0; k < PAPER_SEEDS; k++) {
        by_seed[k] = median(s->nsngrk[k], s->rounds);
        ratios[k] = median(s->ratio[k], s->rounds);
    }
    pair->nsngrk.time = spread_of(by_seed, PAPER_SEEDS);
    pair->nsngrk.iterations_spread = spread_of(s->iterations, PAPER_SEEDS);
    pair->nsngrk.residual_spread = spread_of(s->residual, PAPER_SEEDS);
    double iterations = pair->nsnmgk.iterations, residual = pair->nsnmgk.residual;
    pair->nsnmgk.iterations_spread = (paper_spread){iterations, iterations, iterations};
    pair->nsnmgk.residual_spread = (paper_spread){residual, residual, residual};
    pair->speedup = spread_of(ratios, PAPER_SEEDS);
}

bool paper_measure_pair(paper_problem *problem, uint64_t first, double budget, paper_pair *pair)
{
    samples s = {.nsngrk = malloc(PAPER_SEEDS * sizeof *s.nsngrk),
                 .ratio = malloc(PAPER_SEEDS * sizeof *s.ratio),
                 .nsnmgk = malloc(PAPER_SEEDS * MOST_ROUNDS * sizeof *s.nsnmgk)};
    bool measured = s.nsngrk && s.ratio && s.nsnmgk;
    *pair = (paper_pair){.rounds = 0};
    if (measured) {
        run_rounds(problem, first, budget, &s, pair);
        summarize(&s, pair);
    }
    free(s.nsngrk);
    free(s.ratio);
    free(s.nsnmgk);
    return measured;
}

/* A method that gives the same result in each run. */
static paper_measurement measurement_of(const run *last, double *times, int repeats)
{
    double iterations = last->result.iterations, residual = last->result.residual;
    return (paper_measurement){.status = last->result.status,
                               .iterations = iterations,
                               .projections = (double)last->result.projections,
                               .residual = residual,
                               .iterations_spread = {iterations, iterations, iterations},
                               .residual_spread = {residual, residual, residual},
                               .time = spread_of(times, repeats),
                               .instructions = last->instructions};
}

paper_measurement paper_measure(paper_problem *problem, const pinch_solver_settings *settings, int repeats)
{
    double times[MOST_REPEATS];
    run r = {.time = 0.0};
    for (int i = 0; i < repeats; i++) {
        r = run_once(problem, settings);
        times[i] = r.time;
    }
    return measurement_of(&r, times, repeats);
}

paper_measurement paper_measure_statics(const paper_example *example, pinch_statics *statics,
                                        const pinch_statics_settings *settings, int repeats)
{
    double times[MOST_REPEATS];
    run r = {.time = 0.0};
    for (int i = 0; i < repeats; i++) {
        pinch_statics_result result = {.solve = {.status = PINCH_SOLVE_DIVERGED}};
        double instructions = instructions_now(), start = clock_thread_seconds();
        pinch_statics_solve(statics, &example->grasp, settings, example->results, &result);
        times[i] = clock_thread_seconds() - start;
        r = (run){result.solve, times[i], instructions_now() - instructions};
    }
    return measurement_of(&r, times, repeats);
}
