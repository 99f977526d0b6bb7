/* Recording the solves of islands: a problem is kept as it was before the solve, and shown to the recorder after. */
#include "islands/island_life.h"

void pinch_begin_recording(const pinch_step_context *context, pinch_solver_thread *thread, const pinch_problem *problem,
                           pinch_problem *before)
{
    before->body_count = 0; /* nothing is recorded */
    if (!context->settings.recorder || !pinch_copy_problem(problem, &thread->before, before)) return;
    before->memory = NULL;
    if (!problem->memory) return;
    pinch_step_factors factors = pinch_step_memory_read(problem->memory);
    bool kept = thread->memory_before || pinch_step_memory_create(&thread->memory_before) == PINCH_OK;
    if (kept && pinch_step_memory_write(thread->memory_before, &factors) == PINCH_OK)
        before->memory = thread->memory_before;
    else
        before->body_count = 0;
}

void pinch_end_recording(const pinch_step_context *context, int island, const pinch_solver_settings *solver,
                         const pinch_problem *before, const pinch_problem *after, const pinch_step_result *result)
{
    const pinch_ode_settings *settings = &context->settings;
    bool solved = result->solve.status == PINCH_SOLVE_CONVERGED && !result->too_soft;
    if (before->body_count == 0 || (solved && !settings->record_all)) return;
    pinch_ode_recording recording = {.step = context->number,
                                     .island = island,
                                     .settings = solver,
                                     .problem = before,
                                     .ended = after,
                                     .result = result};
    settings->recorder(settings->recorder_context, &recording);
}
