#define _POSIX_C_SOURCE 200809L

#include "progress.h"
#include "measure.h"

#include <stdio.h>
#include <unistd.h>

static const double FIRST = 1, EVERY = 0.5; /* s */

void progress_start(progress *p, bool wanted)
{
    const double now = clock_seconds();
    *p = (progress){.wanted = wanted && isatty(STDERR_FILENO), .started = now, .last = now + FIRST - EVERY};
}

void progress_show(progress *p, long done, long all, double time, double duration)
{
    /* the clock is not asked in every step */
    if (!p->wanted || done % 16 != 0) return;
    double now = clock_seconds(), spent = now - p->started;
    if (now - p->last < EVERY) return;
    p->last = now;
    p->shown = true;
    fprintf(stderr, "\r  %ld of %ld steps, %.3g s of %.3g s simulated, %.0f s so far, about %.0f s left\033[K", done,
            all, time, duration, spent, done > 0 ? spent * (double)(all - done) / (double)done : 0);
    fflush(stderr);
}

void progress_end(progress *p)
{
    if (p->shown) fputs("\r\033[K", stderr);
    p->shown = false;
}
