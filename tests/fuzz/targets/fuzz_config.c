/* Configuration files of pinch exec: each is taken or refused with one line, and leaves options within their ranges. */
#include "cli/command.h"
#include "cli/exec_config.h"
#include "target.h"

#include <math.h>

extern const command command_exec; /* the table of all would draw in the benches' allocator */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    options o = {.command = &command_exec, .config = target_file(data, size)};
    json_t *document = NULL;
    o.given[OPTION_CONFIG] = true;
    target_listen();
    command_status status = exec_config_read(&o, &document);
    target_heard(status != COMMAND_DONE);
    if (status == COMMAND_DONE && !document) target_found("options out of nothing");
    if (o.given[OPTION_TOLERANCE] && !(o.tolerance > 0 && isfinite(o.tolerance)))
        target_found("a tolerance of %g", o.tolerance);
    if (o.given[OPTION_KT_RATIO] && !(o.kt_ratio > 0 && o.kt_ratio <= 10)) target_found("a ratio of %g", o.kt_ratio);
    if (o.given[OPTION_MAX_ITERATIONS] && o.max_iterations < 1) target_found("%d iterations", o.max_iterations);
    if (o.given[OPTION_EXEC_SOLVER] && !scene_pair_exists(SCENE_FOR_RUN, o.solver, SCENE_COULOMB))
        target_found("a solver that cannot step");
    json_decref(document);
    return 0;
}
