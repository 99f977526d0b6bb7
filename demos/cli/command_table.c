#include "command.h"

/* A row NAME stands for the `command_NAME` that pinch_NAME.c defines. */
#define COMMAND_TABLE(ROW)                                                                                             \
    ROW(solve) ROW(run) ROW(compare) ROW(study) ROW(validate) ROW(hand) ROW(lcp) ROW(friction) ROW(replay) ROW(bench) ROW(exec)

#define DECLARE(name) extern const command command_##name;
#define ADDRESS(name) &command_##name,
COMMAND_TABLE(DECLARE)
const command *const command_table[] = {COMMAND_TABLE(ADDRESS) NULL};
