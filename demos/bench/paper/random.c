/* Random grasps of 3 to 200 fingers: how often each solver finds an answer, and in what time. */
#include "paper.h"

#include "common/measure.h"
#include "common/output.h"

#include <ode/ode.h>

#include <math.h>
#include <stdlib.h>

enum { MOST_FINGERS = 200, MOST_LCP_FINGERS = 50, FACES = 4, GRASPS = 20, ITERATIONS = 5000 };
/* Finer than what the check of every answer asks for, so that none is refused for its tolerance alone. */
static const double TOLERANCE = 1e-11;
static const int sizes[PAPER_RANDOM_SIZES] = {3, 5, 10, 20, 50, 100, 200};

static double between(double low, double high)
{
    return low + (high - low) * dRandReal();
}

static void draw_direction(double v[3])
{
    double length;
    do {
        for (int j = 0; j < 3; j++) v[j] = between(-1.0, 1.0);
        length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    } while (length < 0.1 || length > 1.0);
    for (int j = 0; j < 3; j++) v[j] /= length;
}

/* A ball of radius 1 whose weight is 1, with fingers all around it. All numbers are of the order of one, so that every
 * solver may have the same tolerance without units. */
static void draw_grasp(int count, pinch_finger *fingers, pinch_grasp *grasp)
{
    *grasp = (pinch_grasp){.finger_count = count, .fingers = fingers, .radius = 1.0};
    for (int i = 0; i < count; i++) {
        double out[3], side[3];
        draw_direction(out);
        draw_direction(side);
        double along = side[0] * out[0] + side[1] * out[1] + side[2] * out[2], length2 = 0.0;
        for (int j = 0; j < 3; j++) {
            side[j] -= along * out[j];
            length2 += side[j] * side[j];
        }
        double kn = between(0.5, 2.0);
        fingers[i] = (pinch_finger){.model = PINCH_CONTACT_HARD,
                                    .stiffness = {kn, kn * between(0.4, 1.0)},
                                    .friction = between(0.3, 0.8),
                                    .closing = between(0.0, 4.0 / sqrt(count)),
                                    .max_force = INFINITY};
        for (int j = 0; j < 3; j++) {
            fingers[i].point[j] = out[j];
            fingers[i].normal[j] = -out[j];
            fingers[i].tangent1[j] = side[j] / sqrt(length2);
        }
    }
    draw_direction(grasp->wrench);
}

typedef struct tally {
    const char *solver;
    int tried, solved;
    double iterations, times[GRASPS];
} tally;

typedef struct field {
    pinch_statics *with_lcp, *without; /* for up to MOST_LCP_FINGERS and MOST_FINGERS */
    pinch_finger *fingers;
    pinch_finger_result *results;
} field;

enum { DEFAULT_MODE, ADMM, FIRST_LCP, METHODS = FIRST_LCP + PINCH_SOLVER_COUNT };

static pinch_solver_result solve(const field *f, const pinch_grasp *grasp, int method)
{
    pinch_statics_result r = {.solve = {.status = PINCH_SOLVE_DIVERGED}};
    pinch_statics_settings settings = pinch_default_statics_settings();
    if (method == ADMM) return paper_admm(grasp, TOLERANCE, ITERATIONS, f->results);
    if (method == DEFAULT_MODE) {
        settings.one_step = true;
        pinch_statics_solve(f->without, grasp, &settings, f->results, &r);
        return r.solve;
    }
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = FACES;
    settings.solver.solver = (pinch_solver)(method - FIRST_LCP);
    settings.solver.newton_finish = false;
    settings.solver.tolerance = TOLERANCE;
    settings.solver.goal = 0.0;
    settings.solver.max_iterations = ITERATIONS;
    pinch_statics_solve(f->with_lcp, grasp, &settings, f->results, &r);
    return r.solve;
}

static void try_all(const field *f, const pinch_grasp *grasp, tally *tallies)
{
    for (int k = 0; k < METHODS; k++) {
        if (k >= FIRST_LCP && grasp->finger_count > MOST_LCP_FINGERS) continue;
        double start = clock_thread_seconds();
        pinch_solver_result r = solve(f, grasp, k);
        tallies[k].times[tallies[k].tried++] = clock_thread_seconds() - start;
        tallies[k].iterations += (double)r.iterations / GRASPS;
        tallies[k].solved += r.status == PINCH_SOLVE_CONVERGED;
    }
}

static json_t *size_document(const field *f, int count)
{
    tally tallies[METHODS] = {{.solver = "default, exact cone"}, {.solver = "admm, exact cone"}};
    json_t *list = json_array();
    for (int k = FIRST_LCP; k < METHODS; k++) tallies[k].solver = pinch_solver_name((pinch_solver)(k - FIRST_LCP));
    for (int i = 0; i < GRASPS; i++) {
        pinch_grasp grasp;
        draw_grasp(count, f->fingers, &grasp);
        try_all(f, &grasp, tallies);
    }
    for (int k = 0; k < METHODS; k++)
        if (tallies[k].tried > 0)
            json_array_append_new(list, json_pack("{s:s, s:i, s:i, s:o, s:o}", "solver", tallies[k].solver, "grasps",
                                                  tallies[k].tried, "solved", tallies[k].solved, "iterations",
                                                  json_number(tallies[k].iterations), "time_s",
                                                  json_number(median(tallies[k].times, tallies[k].tried))));
    return json_pack("{s:i, s:o}", "fingers", count, "results", list);
}

json_t *paper_random_document(const bench_request *o)
{
    field f = {.fingers = calloc(MOST_FINGERS, sizeof *f.fingers), .results = calloc(MOST_FINGERS, sizeof *f.results)};
    json_t *list = NULL;
    if (f.fingers && f.results && pinch_statics_create(MOST_LCP_FINGERS, FACES, &f.with_lcp) == PINCH_OK &&
        pinch_statics_create(MOST_FINGERS, 0, &f.without) == PINCH_OK) {
        list = json_array();
        bench_seed_ode(o->seed);
        for (int i = 0; i < PAPER_RANDOM_SIZES; i++) {
            progress_part(o->line, "random grasps");
            json_array_append_new(list, size_document(&f, sizes[i]));
        }
    }
    pinch_statics_destroy(f.with_lcp);
    pinch_statics_destroy(f.without);
    free(f.fingers);
    free(f.results);
    return list ? json_pack("{s:i, s:i, s:f, s:i, s:o}", "faces", FACES, "most_iterations", ITERATIONS, "tolerance",
                            1e-6, "grasps_of_each_size", GRASPS, "sizes", list)
                : NULL;
}
