#include "statistics.h"

#include <string.h>

static _Thread_local pinch_tip_stats counters;

pinch_tip_stats *pinch_tip_counters(void)
{
    return &counters;
}

pinch_tip_stats pinch_tip_statistics(void)
{
    return counters;
}

void pinch_tip_reset_statistics(void)
{
    memset(&counters, 0, sizeof counters);
}
