/* Options that would do nothing: each is refused, because who gives it expects something of it. */
#include "command.h"

/* An option, and those of which one has to stand beside it. */
typedef struct option_need {
    option_id option;
    option_id one_of[3]; /* OPTION_COUNT ends them */
} option_need;

static const option_need needs[] = {
    {OPTION_FPS, {OPTION_VIEW, OPTION_GLTF, OPTION_COUNT}}, {OPTION_RECORD_ALL, {OPTION_RECORD, OPTION_COUNT}},
    {OPTION_EVERY, {OPTION_CHECKPOINT, OPTION_COUNT}},      {OPTION_REFINE, {OPTION_BESIDE, OPTION_COUNT}},
    {OPTION_UNIT, {OPTION_FAITHFUL, OPTION_COUNT}},
};

static bool is_met(const options *o, const option_need *need)
{
    if (!o->given[need->option]) return true;
    for (const option_id *id = need->one_of; *id != OPTION_COUNT; id++)
        if (o->given[*id]) return true;
    return false;
}

command_status command_check_needs(const options *o)
{
    for (size_t i = 0; i < sizeof needs / sizeof *needs; i++) {
        if (is_met(o, &needs[i])) continue;
        char list[128] = "";
        size_t used = 0;
        for (const option_id *id = needs[i].one_of; *id != OPTION_COUNT && used < sizeof list; id++) {
            int n = snprintf(list + used, sizeof list - used, "%s--%s", used ? " or " : "", options_name(*id));
            used += n > 0 ? (size_t)n : 0;
        }
        command_error(o->command->name, "--%s: expected %s with it", options_name(needs[i].option), list);
        return COMMAND_BAD_INPUT;
    }
    return COMMAND_DONE;
}

command_status command_refuse_given(const options *o, const option_id *list, const char *why)
{
    for (; *list != OPTION_COUNT; list++) {
        if (!o->given[*list]) continue;
        command_error(o->command->name, "--%s: %s", options_name(*list), why);
        return COMMAND_BAD_INPUT;
    }
    return COMMAND_DONE;
}
