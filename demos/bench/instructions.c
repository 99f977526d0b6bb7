#define _GNU_SOURCE

#include "instructions.h"

#include <math.h>

#ifdef __linux__
#include <linux/perf_event.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <unistd.h>

/* -2: not opened yet, -1: not permitted, or the machine has no such counter */
static int counter = -2;

static void open_counter(void)
{
    struct perf_event_attr wanted = {.type = PERF_TYPE_HARDWARE,
                                     .size = sizeof wanted,
                                     .config = PERF_COUNT_HW_INSTRUCTIONS,
                                     .exclude_kernel = 1,
                                     .exclude_hv = 1};
    counter = (int)syscall(SYS_perf_event_open, &wanted, 0, -1, -1, 0);
}

bool instructions_counted(void)
{
    if (counter == -2) open_counter();
    return counter >= 0;
}

double instructions_now(void)
{
    uint64_t count;
    if (!instructions_counted() || read(counter, &count, sizeof count) != (long)sizeof count) return NAN;
    return (double)count;
}
#else
bool instructions_counted(void)
{
    return false;
}

double instructions_now(void)
{
    return NAN;
}
#endif
