/* pinch replay: one recorded solve of an island, solved again. */
#include "command.h"

#include "common/output.h"
#include "common/terminal.h"
#include "replay/island_file.h"

#include <math.h>
#include <string.h>

typedef enum bits { BITS_SAME, BITS_OTHER, BITS_NOT_COMPARED } bits;

/* Compares lists of numbers; in a recording every number that is not finite is the same one. */
static bool same(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++)
        if (isfinite(a[i]) ? memcmp(&a[i], &b[i], sizeof a[i]) != 0 : isfinite(b[i])) return false;
    return true;
}

static bool ended_the_same(const island_file *file, const pinch_step_result *result)
{
    const pinch_problem *p = &file->problem;
    const pinch_solver_result *now = &result->solve, *then = &file->ended.solve;
    bool equal = now->status == then->status && now->iterations == then->iterations &&
                 now->newton_steps == then->newton_steps && same(&now->residual, &then->residual, 1);
    for (int i = 0; i < p->body_count && equal; i++)
        equal = same(p->bodies[i].velocity_end, file->velocities + 6 * i, 6);
    for (int i = 0; i < p->contact_count && equal; i++)
        equal = same(p->contacts[i].force, file->contact_forces + 4 * i, 4);
    for (int i = 0; i < p->row_count && equal; i++) equal = same(&p->rows[i].force, file->row_forces + i, 1);
    return equal;
}

/* The settings of the recording under the options. Returns whether they are those of the recording. */
static bool choose_settings(const options *o, const island_file *file, pinch_solver_settings *settings)
{
    *settings = file->settings;
    if (o->given[OPTION_SOLVER]) settings->solver = o->solver;
    if (o->given[OPTION_TOLERANCE]) settings->tolerance = o->tolerance;
    if (o->given[OPTION_MAX_ITERATIONS]) settings->max_iterations = o->max_iterations;
    if (o->given[OPTION_SEED]) settings->seed = o->seed;
    if (o->no_newton) settings->newton_finish = false;
    settings->goal = fmin(settings->goal, settings->tolerance);
    return settings->solver == file->settings.solver && settings->tolerance == file->settings.tolerance &&
           settings->max_iterations == file->settings.max_iterations && settings->seed == file->settings.seed &&
           settings->newton_finish == file->settings.newton_finish && !o->cold_start;
}

static void forget(pinch_problem *p)
{
    p->memory = NULL;
    for (int i = 0; i < p->contact_count; i++) {
        memset(p->contacts[i].force, 0, sizeof p->contacts[i].force);
        memset(p->contacts[i].rolling_moment, 0, sizeof p->contacts[i].rolling_moment);
    }
    for (int i = 0; i < p->row_count; i++) p->rows[i].force = 0;
}

/* ---- What is printed. ---- */

static json_t *append(json_t *list, json_t *item)
{
    if (list && json_array_append_new(list, item)) {
        json_decref(list);
        return NULL;
    }
    return list;
}

static json_t *contact_documents(const pinch_problem *p)
{
    json_t *list = json_array();
    for (int i = 0; i < p->contact_count && list; i++) {
        const pinch_contact *c = &p->contacts[i];
        list = append(list, json_pack("{s:[i,i], s:s, s:o, s:o, s:o}", "bodies", c->body1, c->body2, "state",
                                      pinch_contact_state_text(c->state), "force", json_numbers(c->force, 4),
                                      "rolling_moment", json_numbers(c->rolling_moment, 2), "relative_velocity",
                                      json_numbers(c->relative_velocity, 4)));
    }
    return list;
}

static json_t *row_documents(const pinch_problem *p)
{
    json_t *list = json_array();
    for (int i = 0; i < p->row_count && list; i++) {
        const pinch_joint_row *row = &p->rows[i];
        list = append(list, json_pack("{s:[i,i], s:o, s:o}", "bodies", row->body1, row->body2, "force",
                                      json_number(row->force), "violation", json_number(row->violation)));
    }
    return list;
}

static json_t *velocity_documents(const pinch_problem *p)
{
    json_t *list = json_array();
    for (int i = 0; i < p->body_count && list; i++) list = append(list, json_numbers(p->bodies[i].velocity_end, 6));
    return list;
}

static json_t *bits_document(bits compared)
{
    return compared == BITS_NOT_COMPARED ? json_null() : json_boolean(compared == BITS_SAME);
}

static json_t *replay_document(const island_file *file, const pinch_solver_settings *settings,
                               const pinch_step_result *r, bits compared)
{
    const pinch_problem *p = &file->problem;
    const pinch_solver_result *then = &file->ended.solve;
    json_t *recorded = json_pack("{s:I, s:i, s:s, s:s, s:o, s:i}", "step_number", (json_int_t)file->step_number,
                                 "island", file->island, "solver", pinch_solver_name(file->settings.solver), "status",
                                 pinch_solve_status_text(then->status), "residual", json_number(then->residual),
                                 "iterations", then->iterations);
    return json_pack(
        "{s:s, s:s, s:b, s:s, s:o, s:i, s:i, s:i, s:i, s:i, s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}",
        "command", "replay", "status", pinch_solve_status_text(r->solve.status), "verified",
        r->solve.status == PINCH_SOLVE_CONVERGED, "solver", pinch_solver_name(settings->solver), "residual",
        json_number(r->solve.residual), "iterations", r->solve.iterations, "newton_steps", r->solve.newton_steps,
        "unknowns", r->unknowns, "dependent_rows", r->dependent_rows, "floor_level", r->floor_level, "too_soft",
        r->too_soft, "floor_residual", json_number(r->floor_residual), "residual_max", json_number(r->residual_max),
        "cone", json_number(r->cone), "complementarity", json_number(r->complementarity), "slip_direction",
        json_number(r->slip_direction), "recorded", recorded, "same_bits", bits_document(compared), "contacts",
        contact_documents(p), "joint_rows", row_documents(p), "velocities", velocity_documents(p));
}

static void print_text(const island_file *file, const pinch_solver_settings *settings, const pinch_step_result *r,
                       bits compared)
{
    static const char *const comparison[] = {"the same bits as recorded", "other bits than recorded",
                                             "with other settings than recorded"};
    const pinch_problem *p = &file->problem;
    bool verified = r->solve.status == PINCH_SOLVE_CONVERGED;
    char n[48];
    printf("island %d of step %ld: %d bodies, %d contacts, %d joint rows, %d unknowns\n", file->island,
           file->step_number, p->body_count, p->contact_count, p->row_count, r->unknowns);
    printf("  recorded: %s by %s after %d iterations, residual %s\n", pinch_solve_status_text(file->ended.solve.status),
           pinch_solver_name(file->settings.solver), file->ended.solve.iterations,
           number_for_people("%.3g", file->ended.solve.residual, n));
    printf("  replayed: %s by %s after %d iterations, residual %s; verified: %s; %s\n",
           pinch_solve_status_text(r->solve.status), pinch_solver_name(settings->solver), r->solve.iterations,
           number_for_people("%.3g", r->solve.residual, n), verified ? "yes" : "no", comparison[compared]);
    if (p->contact_count > 0)
        printf("  %8s %8s %-6s %15s %15s %15s %15s\n", "body 1", "body 2", "state", "normal N", "tangent 1 N",
               "tangent 2 N", "torsion N m");
    for (int i = 0; i < p->contact_count; i++) {
        const pinch_contact *c = &p->contacts[i];
        char f[4][48];
        for (int k = 0; k < 4; k++) number_for_people("%15.8g", c->force[k], f[k]);
        printf("  %8d %8d %-6s %s %s %s %s\n", c->body1, c->body2, verified ? pinch_contact_state_text(c->state) : "?",
               f[0], f[1], f[2], f[3]);
    }
    if (p->row_count > 0) printf("  %8s %8s %15s %15s %15s\n", "body 1", "body 2", "joint force", "low", "high");
    for (int i = 0; i < p->row_count; i++) {
        const pinch_joint_row *row = &p->rows[i];
        char f[3][48];
        printf("  %8d %8d %s %s %s\n", row->body1, row->body2, number_for_people("%15.8g", row->force, f[0]),
               number_for_people("%15.8g", row->low, f[1]), number_for_people("%15.8g", row->high, f[2]));
    }
}

/* ---- The replay. ---- */

static command_status refuse_status(const char *file, pinch_status status)
{
    if (status == PINCH_OUT_OF_MEMORY) {
        command_error("replay", "out of memory");
        return COMMAND_SYSTEM;
    }
    if (status == PINCH_UNSUPPORTED)
        command_error("replay", "%s: this solver has no laws for the island; nsnmgk and newton have", file);
    else
        command_error("replay", "%s: problem: expected values in the ranges that <pinch/problem.h> gives", file);
    return COMMAND_BAD_INPUT;
}

static command_status replay(const options *o, island_file *file)
{
    pinch_step_solver *solver;
    pinch_step_result result;
    pinch_solver_settings settings;
    pinch_problem *p = &file->problem;
    pinch_step_memory *memory = p->memory;
    bits compared = choose_settings(o, file, &settings) ? BITS_SAME : BITS_NOT_COMPARED;
    if (o->cold_start) forget(p);
    p->keep_trial = true;
    if (pinch_step_solver_create(&solver) != PINCH_OK) return refuse_status(o->arguments[0], PINCH_OUT_OF_MEMORY);
    pinch_status status = pinch_step_solve(solver, p, &settings, &result);
    pinch_step_solver_destroy(solver);
    p->memory = memory;
    if (status != PINCH_OK) return refuse_status(o->arguments[0], status);
    if (compared == BITS_SAME && !ended_the_same(file, &result)) compared = BITS_OTHER;
    if (o->json) {
        if (!json_print_new(replay_document(file, &settings, &result, compared), stdout))
            return refuse_status(o->arguments[0], PINCH_OUT_OF_MEMORY);
    } else if (!o->quiet) {
        print_text(file, &settings, &result, compared);
    }
    return result.solve.status == PINCH_SOLVE_CONVERGED ? COMMAND_DONE : COMMAND_FAILED;
}

static command_status run_replay(const options *o)
{
    island_file *file;
    scene_error error;
    scene_status status = island_file_load(o->arguments[0], &file, &error);
    if (status != SCENE_OK) {
        terminal_print(stderr, "%s\n", error.text);
        return status == SCENE_NO_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
    }
    command_status ended = replay(o, file);
    island_file_free(file);
    return ended;
}

static const option_id replay_options[] = {OPTION_SOLVER, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS,
                                           OPTION_SEED,   OPTION_NO_NEWTON, OPTION_COLD_START,
                                           OPTION_JSON,   OPTION_QUIET,     OPTION_COUNT};

const command command_replay = {
    .name = "replay",
    .arguments = "FILE",
    .summary = "solves an island again that pinch run or pinch exec has recorded",
    .notes =
        "The file is one of those that --record writes. Without options that change the solve, the answer has the\n"
        "same bits as the recorded one on the same machine, and the document's same_bits tells so. Where the solve\n"
        "fails, the forces are those that the solver ended with.\n"
        "Of the solvers, nsnmgk and newton do every island. nsngrk does not do some of hands, as those with mimics;\n"
        "lemke and pgs do only those of the linearized cone (formulation lcp), and none with mimics or tendons.",
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "json",
    .options = replay_options,
    .run = run_replay,
};
