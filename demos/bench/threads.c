/*
 * pinch bench threads: what further threads gain.
 *
 * The same world is stepped with 1, 2, 3, ... threads in turn, in one process. Two steps of each kind are made and the
 * second is timed, which finds in the caches what the first has left there, as the steps of a run do: two whose
 * contacts the program finds and hands over itself, and two in which the threads share the collision detection, too
 * (pinch_ode_collide). All worlds must have the same bits in the end.
 */
#include "bench.h"
#include "world.h"

#include "common/measure.h"
#include "common/output.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SIZES = 3, FEWEST = 11, MOST = 2001, TURN = 2 };

static const struct threads_series {
    const char *name;
    void (*build)(bench_world *w, int size);
    double step; /* s */
    int settle;  /* steps before measuring */
    int sizes[SIZES + 1];
} all_series[] = {
    {"carried", bench_build_carried, 1e-3, 200, {100, 1000}},  /* many islands */
    {"wall", bench_build_wall, 1e-2, 20, {200, 600, 2000}},    /* one island that settles */
    {"boxes", bench_build_boxes, 1e-2, 100, {200, 600, 2000}}, /* one island that moves */
    {"touching", bench_build_touching, 1e-2, 20, {210, 820}},  /* one island, more contacts than load needs */
};
enum { ALL_SERIES = sizeof all_series / sizeof *all_series };

/* The times of one number of threads. */
typedef struct thread_times {
    bench_world world;
    double contact_part[MOST], whole[MOST];      /* s, of the steps that were timed */
    double contact_gain[MOST], whole_gain[MOST]; /* one thread's time over this one's, of each round */
} thread_times;

typedef struct thread_timing {
    int size, threads; /* 1, 2, ..., threads */
    int rounds;
    thread_times of[]; /* by number of threads less one */
} thread_timing;

/* Makes a turn of steps of one kind. Returns the seconds that the last one took, or a negative number when a step
 * failed. */
static double make_turn(bench_world *w, bool whole)
{
    double seconds = 0;
    for (int s = 0; s < TURN && seconds >= 0; s++) {
        if (!whole) bench_prepare(w);
        seconds = whole ? bench_whole_step(w) : bench_step(w);
    }
    return w->failed ? -1 : seconds;
}

static bool set_up(const struct threads_series *s, thread_timing *t)
{
    bool fine = true;
    for (int n = 0; n < t->threads && fine; n++) {
        bench_world *w = &t->of[n].world;
        bench_settings settings = {.solver = BENCH_PINCH, .threads = n + 1};
        bench_world_make(w, &settings, s->step);
        s->build(w, t->size);
        for (int i = 0; i < s->settle / TURN && fine; i++) fine = make_turn(w, true) >= 0;
    }
    return fine;
}

static bool measure(thread_timing *t, double budget)
{
    double start = clock_seconds();
    for (; t->rounds < MOST && (t->rounds < FEWEST || clock_seconds() - start < budget); t->rounds++) {
        int i = t->rounds;
        for (int n = 0; n < t->threads; n++) {
            thread_times *own = &t->of[n];
            own->contact_part[i] = make_turn(&own->world, false);
            own->whole[i] = make_turn(&own->world, true);
            if (own->contact_part[i] < 0 || own->whole[i] < 0) return false;
            own->contact_gain[i] = t->of[0].contact_part[i] / own->contact_part[i];
            own->whole_gain[i] = t->of[0].whole[i] / own->whole[i];
        }
    }
    return true;
}

static bool has_same_bits(const bench_world *a, const bench_world *b)
{
    for (int k = 0; k < a->body_count; k++) {
        dBodyID one = a->bodies[k], other = b->bodies[k];
        if (memcmp(dBodyGetPosition(one), dBodyGetPosition(other), 3 * sizeof(dReal)) != 0 ||
            memcmp(dBodyGetQuaternion(one), dBodyGetQuaternion(other), 4 * sizeof(dReal)) != 0 ||
            memcmp(dBodyGetLinearVel(one), dBodyGetLinearVel(other), 3 * sizeof(dReal)) != 0 ||
            memcmp(dBodyGetAngularVel(one), dBodyGetAngularVel(other), 3 * sizeof(dReal)) != 0)
            return false;
    }
    return a->body_count == b->body_count;
}

/* ---- What is printed. ---- */

/* Appends a row for each number of threads to `rows`, and prints it where there is a table. */
static command_status print_rows(const struct threads_series *s, thread_timing *t, json_t *rows, bool table)
{
    command_status status = COMMAND_DONE;
    for (int n = 0; n < t->threads; n++) {
        thread_times *own = &t->of[n];
        bool same = has_same_bits(&t->of[0].world, &own->world);
        double contact = median(own->contact_part, t->rounds), whole = median(own->whole, t->rounds);
        double contact_gain = median(own->contact_gain, t->rounds), whole_gain = median(own->whole_gain, t->rounds);
        /* sorted by the median */
        double low = own->whole_gain[t->rounds / 4], high = own->whole_gain[3 * t->rounds / 4];
        json_t *row = json_pack("{s:s, s:i, s:i, s:i, s:i, s:i, s:o, s:o, s:o, s:o, s:[o, o], s:b}", "series", s->name,
                                "size", t->size, "bodies", own->world.body_count, "contacts", own->world.contact_count,
                                "threads", n + 1, "rounds", t->rounds, "contact_us", json_number(1e6 * contact),
                                "whole_us", json_number(1e6 * whole), "contact_gain", json_number(contact_gain),
                                "whole_gain", json_number(whole_gain), "whole_gain_quartiles", json_number(low),
                                json_number(high), "same_bits", same);
        if (json_array_append_new(rows, row) != 0) return COMMAND_SYSTEM;
        if (table)
            printf("%-9s %6d %8d %8d | %10.2f %7.2f | %10.2f %7.2f  %5.2f to %4.2f | %s\n", s->name, t->size,
                   own->world.contact_count, n + 1, 1e6 * contact, contact_gain, 1e6 * whole, whole_gain, low, high,
                   same ? "same" : "DIFFERENT");
        if (same) continue;
        command_error("bench", "%s, size %d: %d threads do not give the bits of one", s->name, t->size, n + 1);
        status = COMMAND_FAILED;
    }
    fflush(stdout);
    return status;
}

static command_status time_size(const bench_request *o, const struct threads_series *s, int size, int threads,
                                json_t *rows)
{
    char what[64];
    thread_timing *t = calloc(1, sizeof *t + (size_t)threads * sizeof *t->of);
    bool fine = t != NULL;
    command_status status = COMMAND_SYSTEM;
    snprintf(what, sizeof what, "%s, size %d", s->name, size);
    progress_part(o->line, what);
    if (t) {
        t->size = size;
        t->threads = threads;
        fine = set_up(s, t) && measure(t, o->budget > 0 ? o->budget : 4);
        progress_end(o->line);
        if (fine) status = print_rows(s, t, rows, !o->json && !o->quiet);
        for (int n = 0; n < threads; n++)
            if (t->of[n].world.ode) bench_world_free(&t->of[n].world);
    }
    if (!fine) command_error("bench", "%s: a step failed, or memory ran out", what);
    free(t);
    return status;
}

/* As many as the machine has processors, but at least two, and no more than four unless they were asked for. */
static int threads_wanted(const bench_request *o)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (o->threads > 0) return o->threads;
    return processors < 2 ? 2 : processors > 4 ? 4 : (int)processors;
}

static command_status run_series(const bench_request *o, int threads, json_t *rows)
{
    command_status status = COMMAND_DONE;
    o->line->parts = 0;
    for (int k = 0; k < ALL_SERIES; k++)
        for (const int *size = all_series[k].sizes; *size > 0; size++) o->line->parts += bench_wants_size(o, *size);
    for (int k = 0; k < ALL_SERIES; k++) {
        for (const int *size = all_series[k].sizes; *size > 0; size++) {
            if (!bench_wants_size(o, *size)) continue;
            command_status one = time_size(o, &all_series[k], *size, threads, rows);
            if (one == COMMAND_SYSTEM) return one;
            if (one != COMMAND_DONE) status = one;
        }
    }
    return status;
}

command_status bench_threads(const bench_request *o)
{
    const int *lists[ALL_SERIES];
    for (int k = 0; k < ALL_SERIES; k++) lists[k] = all_series[k].sizes;
    command_status status = bench_check_sizes(o, lists, ALL_SERIES);
    if (status != COMMAND_DONE) return status;
    json_t *rows = json_array();
    dInitODE2(0);
    bench_seed_ode(o->seed);
    if (!o->json && !o->quiet)
        printf("The same world with 1, 2, ... threads in turn. The contact part lasts from the first contact handed "
               "over to the\nend of the step; the whole step includes collision detection, which the threads share. "
               "Times are medians of\nsteps, gains medians of one thread's time over that of more in each round, "
               "followed by their quartiles.\n"
               "%-9s %6s %8s %8s | %10s %7s | %10s %7s  %-13s | %s\n",
               "", "size", "contacts", "threads", "contact us", "gain", "whole us", "gain", "quartiles", "bits");
    if (rows) status = run_series(o, threads_wanted(o), rows);
    dCloseODE();
    json_t *document = rows && o->json && status != COMMAND_SYSTEM
                           ? json_pack("{s:s, s:s, s:s, s:O}", "command", "bench", "benchmark", "threads",
                                       "size_counts", "hands, bricks or boxes", "rows", rows)
                           : NULL;
    json_decref(rows);
    if (!rows || (o->json && !json_print_new(document, stdout))) return COMMAND_SYSTEM;
    return status;
}
