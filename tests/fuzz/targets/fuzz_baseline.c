/* Baselines of pinch compare: each is taken or refused with one line, and what is taken can be checked against. */
#include "compare/baseline.h"
#include "target.h"

/* A comparison of one scene, as far as a baseline looks at it. */
static json_t *comparison(void)
{
    json_t *run = json_pack("{s:s, s:s, s:{s:f, s:b}}", "run", "pinch", "contact_solver", "pinch", "metrics",
                            "max_penetration", 1e-3, "held", 1);
    return json_pack("{s:[{s:s, s:i, s:f, s:[o]}]}", "scenes", "scene", "roll.json", "steps", 100, "step_s", 1e-3,
                     "runs", run);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static json_t *document;
    static char scene[] = "roll.json";
    char *scenes[] = {scene};
    json_t *baseline = NULL;
    if (!document) document = comparison();
    target_listen();
    command_status status = baseline_load(target_file(data, size), scenes, 1, &baseline);
    target_heard(status != COMMAND_DONE);
    if ((status == COMMAND_DONE) != (baseline != NULL)) target_found("status %d", (int)status);
    if (!baseline) return 0;
    json_t *moves = baseline_check(baseline, document);
    if (!json_is_array(moves)) target_found("no list of what has moved");
    json_decref(moves);
    json_decref(baseline);
    return 0;
}
