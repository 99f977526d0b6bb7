#define _GNU_SOURCE

#include "measure.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#ifdef __linux__
#include <linux/perf_event.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

static double seconds_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double clock_seconds(void)
{
    return seconds_of(CLOCK_MONOTONIC);
}

double clock_thread_seconds(void)
{
    return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double median(double *values, int count)
{
    if (count == 0) return NAN;
    qsort(values, (size_t)count, sizeof *values, ascending);
    return values[count / 2];
}

#ifdef __linux__
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
