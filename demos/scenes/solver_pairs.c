/* Which solvers do what. */
#include "scene.h"

#include <stddef.h>
#include <stdio.h>

/* Which solvers do the exact cone. All of them do the linearized one. */
static const bool exact_cone[2][PINCH_SOLVER_COUNT] = {
    [SCENE_FOR_STATICS] = {[PINCH_SOLVER_NSNMGK] = true, [PINCH_SOLVER_NEWTON] = true},
    [SCENE_FOR_RUN] = {[PINCH_SOLVER_NSNMGK] = true, [PINCH_SOLVER_NSNGRK] = true, [PINCH_SOLVER_NEWTON] = true},
};

bool scene_pair_exists(scene_use use, pinch_solver solver, scene_formulation formulation)
{
    return formulation == SCENE_LCP || exact_cone[use][solver];
}

bool scene_check_pair(scene_use use, const scene_solver *solver, char text[SCENE_SOLVER_TEXT])
{
    if (scene_pair_exists(use, solver->name, solver->formulation)) return true;
    int n = snprintf(text, SCENE_SOLVER_TEXT, "solver %s does not do formulation %s here; there are",
                     pinch_solver_name(solver->name), scene_formulation_name(solver->formulation));
    const char *separator = " ";
    for (int f = 0; f < SCENE_FORMULATION_COUNT; f++)
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
            if (!scene_pair_exists(use, (pinch_solver)s, (scene_formulation)f)) continue;
            if (n < 0 || n >= SCENE_SOLVER_TEXT) return false;
            n += snprintf(text + n, SCENE_SOLVER_TEXT - (size_t)n, "%s%s with %s", separator,
                          pinch_solver_name((pinch_solver)s), scene_formulation_name((scene_formulation)f));
            separator = ", ";
        }
    return false;
}

bool scene_check_solver(const scene *s, char text[SCENE_SOLVER_TEXT])
{
    if (!scene_check_pair(SCENE_FOR_RUN, &s->solver, text)) return false;
    bool lcp_only = s->solver.name >= PINCH_SOLVER_LEMKE;
    for (size_t i = 0; i < s->finger_count; i++) {
        if (!lcp_only || !s->fingers[i].has_normal_force) continue;
        snprintf(text, SCENE_SOLVER_TEXT,
                 "solver %s does not do force control, which finger %.200s asks for; nsnmgk, nsngrk and newton do",
                 pinch_solver_name(s->solver.name), s->fingers[i].name);
        return false;
    }
    return true;
}
