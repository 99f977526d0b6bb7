#include "bench.h"

pinch_statics_settings paper_settings(int faces, pinch_solver solver, uint64_t seed)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = faces;
    settings.solver.solver = solver;
    settings.solver.seed = seed;
    settings.faithful = true;
    return settings;
}
