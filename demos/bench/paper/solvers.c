/* Every solver on one example, and on random grasps of many fingers. */
#include "paper.h"

#include "common/measure.h"
#include "common/output.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static json_t *entry_document(const char *solver, const char *problem, const pinch_solver_result *r, double time,
                              double force_error)
{
    bool solved = r->status == PINCH_SOLVE_CONVERGED;
    return json_pack("{s:s, s:s, s:s, s:i, s:o, s:o, s:o}", "solver", solver, "problem", problem, "status",
                     pinch_solve_status_text(r->status), "iterations", r->iterations, "residual",
                     json_number(r->residual), "time_s", json_number(time), "force_error_N",
                     json_number(solved ? force_error : NAN));
}

/* The largest distance of a finger's force from the exact one; where there is none, NaN. */
static double force_error(const pinch_grasp *grasp, const pinch_finger_result *fingers,
                          const pinch_finger_result *exact)
{
    double worst = 0.0;
    for (int i = 0; i < grasp->finger_count; i++) {
        double sum2 = 0.0;
        for (int j = 0; j < 3; j++) sum2 += pow(fingers[i].r[j] - exact[i].r[j], 2.0);
        worst = sum2 >= 0.0 ? fmax(worst, sqrt(sum2)) : NAN;
    }
    return worst;
}

/* pinch_statics_solve with the settings: its best time of three and what it found, which goes to `fingers`. */
static pinch_solver_result solve_statics(pinch_statics *statics, const pinch_grasp *grasp,
                                         const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                         double *time)
{
    enum { REPEATS = 3 };
    double times[REPEATS];
    pinch_statics_result r = {.solve = {.status = PINCH_SOLVE_DIVERGED}};
    for (int k = 0; k < REPEATS; k++) {
        double start = clock_thread_seconds();
        pinch_statics_solve(statics, grasp, settings, fingers, &r);
        times[k] = clock_thread_seconds() - start;
    }
    *time = median(times, REPEATS);
    return r.solve;
}

/* Newton, Lemke's method and projected Gauss-Seidel on the paper's complementarity problem, to its tolerance. */
static void add_paper_solvers(json_t *list, pinch_statics *statics, paper_example *e, int faces,
                              const pinch_finger_result *exact)
{
    static const pinch_solver solvers[] = {PINCH_SOLVER_NSNGRK, PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NEWTON,
                                           PINCH_SOLVER_LEMKE, PINCH_SOLVER_PGS};
    for (size_t k = 0; k < sizeof solvers / sizeof *solvers; k++) {
        pinch_statics_settings settings = paper_settings(faces, solvers[k], 1);
        double time;
        pinch_solver_result r = solve_statics(statics, &e->grasp, &settings, e->results, &time);
        json_array_append_new(list, entry_document(pinch_solver_name(solvers[k]), "the paper's", &r, time,
                                                   force_error(&e->grasp, e->results, exact)));
    }
}

static void add_modulus(json_t *list, pinch_statics *statics, paper_example *e, int faces)
{
    paper_problem problem;
    if (paper_problem_create(statics, e, faces, &problem)) {
        double start = clock_thread_seconds();
        pinch_solver_result r = paper_modulus(&problem.lcp, 1e-4, 20000, problem.z, problem.w);
        json_array_append_new(list, entry_document("modulus", "the paper's", &r, clock_thread_seconds() - start, NAN));
    }
    paper_problem_free(&problem);
}

static void add_default(json_t *list, pinch_statics *statics, paper_example *e, pinch_formulation formulation,
                        int faces, pinch_finger_result *exact)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    double time;
    settings.formulation = formulation;
    settings.faces = faces;
    settings.one_step = true; /* as the paper: all loads at once */
    pinch_solver_result r = solve_statics(statics, &e->grasp, &settings, exact, &time);
    json_array_append_new(
        list,
        entry_document("default", formulation == PINCH_FORMULATION_LCP ? "pyramid" : "exact cone", &r, time, 0.0));
}

json_t *paper_solvers_document(paper_example *e, pinch_statics *statics, int faces)
{
    pinch_finger_result exact[PAPER_MOST_FINGERS];
    json_t *list = json_array();
    add_default(list, statics, e, PINCH_FORMULATION_LCP, faces, exact);
    add_paper_solvers(list, statics, e, faces, exact);
    add_modulus(list, statics, e, faces);
    add_default(list, statics, e, PINCH_FORMULATION_COULOMB, faces, exact);
    double start = clock_thread_seconds();
    pinch_solver_result r = paper_admm(&e->grasp, 1e-4, 20000, e->results);
    double time = clock_thread_seconds() - start;
    json_array_append_new(list,
                          entry_document("admm", "exact cone", &r, time, force_error(&e->grasp, e->results, exact)));
    return json_pack("{s:s, s:o, s:o}", "example", e->name, "faces", e->frictional ? json_integer(faces) : json_null(),
                     "results", list);
}
