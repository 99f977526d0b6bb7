#include "paper.h"

#include "common/output.h"
#include "common/own_place.h"
#include "common/terminal.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_PATH = 4096 };

static const char *const names[PAPER_EXAMPLES] = {"1", "1b", "2", "3", "4"};

void paper_unload(paper_example examples[PAPER_EXAMPLES])
{
    for (int i = 0; i < PAPER_EXAMPLES; i++) {
        if (examples[i].s) scene_free(examples[i].s);
        free(examples[i].fingers);
        free(examples[i].results);
    }
}

/* Finds FIRST SECOND.json in the data that the command comes with. */
static bool find_data(const char *first, const char *second, char path[MOST_PATH])
{
    char name[64];
    snprintf(name, sizeof name, "%s%s.json", first, second);
    bool found = own_place_data(name, path, MOST_PATH);
    if (!found) command_error("bench", "%s, which belongs to this command, is not where it was installed", name);
    return found;
}

static command_status load_one(const char *name, paper_example *e)
{
    char file[MOST_PATH];
    scene_error error;
    if (!find_data("scenes/paper/example-", name, file)) return COMMAND_SYSTEM;
    scene_status loaded = scene_load(file, &e->s, &error);
    if (loaded != SCENE_OK) {
        terminal_text(error.text, stderr);
        fputc('\n', stderr);
        return loaded == SCENE_NO_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
    }
    e->name = name;
    e->fingers = calloc(e->s->finger_count, sizeof *e->fingers);
    e->results = calloc(e->s->finger_count, sizeof *e->results);
    if (!e->fingers || !e->results) return COMMAND_SYSTEM;
    scene_static_grasp(e->s, e->fingers, &e->grasp);
    for (int f = 0; f < e->grasp.finger_count; f++)
        if (e->fingers[f].model != PINCH_CONTACT_FRICTIONLESS) e->frictional = true;
    return COMMAND_DONE;
}

command_status paper_load(paper_example examples[PAPER_EXAMPLES])
{
    command_status status = COMMAND_DONE;
    memset(examples, 0, PAPER_EXAMPLES * sizeof *examples);
    for (int i = 0; i < PAPER_EXAMPLES && status == COMMAND_DONE; i++) status = load_one(names[i], &examples[i]);
    return status;
}

json_t *paper_published(void)
{
    json_error_t error;
    char file[MOST_PATH];
    if (!find_data("reference/paper", "", file)) return NULL;
    json_t *published = json_load_file(file, JSON_REJECT_DUPLICATES, &error);
    if (!published) command_error("bench", "%s:%d: %s", file, error.line, error.text);
    return published;
}

pinch_statics_settings paper_settings(int faces, pinch_solver solver, uint64_t seed)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = faces;
    settings.solver.solver = solver;
    settings.solver.seed = seed;
    settings.solver.tolerance = 1e-4;
    settings.solver.goal = 0.0;
    settings.solver.max_iterations = 20000;
    settings.solver.newton_finish = false;
    settings.faithful = true;
    return settings;
}

bool paper_problem_create(pinch_statics *statics, const paper_example *example, int faces, paper_problem *problem)
{
    *problem = (paper_problem){.example = example, .faces = faces};
    pinch_statics_settings settings = paper_settings(faces, PINCH_SOLVER_NSNMGK, 1);
    pinch_static_form form = PINCH_FORM_CONDENSED;
    int size = pinch_statics_lcp_size(statics, &example->grasp, &settings, form);
    if (size == 0) {
        form = PINCH_FORM_SPLIT;
        size = pinch_statics_lcp_size(statics, &example->grasp, &settings, form);
    }
    size_t n = (size_t)size;
    if (size == 0) return false;
    problem->memory = malloc((n * n + 3 * n) * sizeof *problem->memory);
    problem->free_rows = malloc(n * sizeof *problem->free_rows);
    if (!problem->memory || !problem->free_rows || pinch_lcp_workspace_create(size, &problem->workspace) != PINCH_OK)
        return false;
    double *m = problem->memory, *q = m + n * n;
    problem->z = q + n;
    problem->w = problem->z + n;
    problem->lcp = (pinch_lcp){.size = size, .m = m, .q = q};
    return pinch_statics_lcp(statics, &example->grasp, &settings, form, m, q, problem->free_rows) == PINCH_OK;
}

void paper_problem_free(paper_problem *problem)
{
    pinch_lcp_workspace_destroy(problem->workspace);
    free(problem->memory);
    free(problem->free_rows);
}

pinch_solver_result paper_problem_solve(paper_problem *problem, const pinch_solver_settings *settings)
{
    pinch_solver_result result = {.status = PINCH_SOLVE_DIVERGED};
    memset(problem->z, 0, (size_t)problem->lcp.size * sizeof *problem->z);
    pinch_lcp_solve(&problem->lcp, settings, problem->workspace, problem->z, problem->w, &result);
    return result;
}
