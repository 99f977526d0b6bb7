#define _POSIX_C_SOURCE 200809L

#include "progress.h"
#include "measure.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

static const double FIRST = 1, EVERY = 1e-3 * PROGRESS_EVERY_MS; /* s */

void progress_start(progress *p, bool wanted)
{
    const double now = clock_seconds();
    *p = (progress){.wanted = wanted && isatty(STDERR_FILENO), .started = now, .last = now + FIRST - EVERY};
}

bool progress_is_due(progress *p)
{
    return p->wanted && clock_seconds() - p->last >= EVERY;
}

static void print_span(double seconds)
{
    if (seconds >= 3600)
        fprintf(stderr, "%.1f h", seconds / 3600);
    else if (seconds >= 120)
        fprintf(stderr, "%.0f min", seconds / 60);
    else
        fprintf(stderr, "%.0f s", seconds);
}

void progress_tell(progress *p, const char *what, double part)
{
    if (!progress_is_due(p)) return;
    double now = clock_seconds(), spent = now - p->started;
    p->last = now;
    p->shown = true;
    fprintf(stderr, "\r  %s, ", what);
    print_span(spent);
    fputs(" so far", stderr);
    if (part > 0) {
        fputs(", about ", stderr);
        print_span(spent * fmax(0, 1 - part) / part);
        fputs(" left", stderr);
    }
    fputs("\033[K", stderr);
    fflush(stderr);
}

void progress_part(progress *p, const char *what)
{
    progress_tell(p, what, p->parts > 0 ? fmin(1, (double)p->done / p->parts) : 0);
    p->done++;
}

void progress_show(progress *p, long done, long all, double time, double duration)
{
    /* the clock is not asked in every step */
    if (!p->wanted || done % 16 != 0 || !progress_is_due(p)) return;
    char what[128];
    snprintf(what, sizeof what, "%ld of %ld steps, %.3g s of %.3g s simulated", done, all, time, duration);
    progress_tell(p, what, all > 0 ? (double)done / (double)all : 0);
}

void progress_end(progress *p)
{
    if (p->shown) fputs("\r\033[K", stderr);
    p->shown = false;
}
