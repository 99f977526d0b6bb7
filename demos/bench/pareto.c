/*
 * pinch bench pareto: what accuracy costs.
 *
 * Every setting makes the same step from the same state: in each round the worlds of ODE's solvers get the state of
 * Pinch's. In it two errors of its forces are measured: how far they are from the contact law that it was asked for
 * (residual.c), and how far the forces between pairs of geoms are from the exact answer of the step. The latter has the
 * friction cone and the elasticity of fingertips, which ODE's contacts cannot express. In the step after it the time of
 * the contact part and that of the whole step with collision detection are measured.
 *
 * A setting lies below Pinch's point where it is faster and no less accurate. Errors below a billionth of the largest
 * force are rounding, and count as none.
 */
#include "bench.h"
#include "pair_forces.h"
#include "world.h"

#include "common/measure.h"
#include "common/output.h"
#include "view/plot.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 6, FEWEST = 12, MOST = 1001, WARM_UP = 4, SAMPLES = 4 };
static const double ROUNDING = 1e-9; /* of the largest force */

/* Worlds of a kind. In piles a contact may be solved softer than it is, and the exact answer would take too long. */
typedef struct pareto_series {
    const char *name;
    void (*build)(bench_world *w, int size);
    double step; /* s */
    int settle;  /* steps */
    bool cold, pile;
    int sizes[SIZES + 1]; /* 0: no more */
} pareto_series;

#define GRASP(name, build, settle, cold, ...)                                                                          \
    {                                                                                                                  \
        name, build, 1e-3, settle, cold, false,                                                                        \
        {                                                                                                              \
            __VA_ARGS__                                                                                                \
        }                                                                                                              \
    }
#define PILE(name, build, settle, ...)                                                                                 \
    {                                                                                                                  \
        name, build, 1e-2, settle, false, true,                                                                        \
        {                                                                                                              \
            __VA_ARGS__                                                                                                \
        }                                                                                                              \
    }
static const pareto_series all_series[] = {
    GRASP("step", bench_build_object, 200, false, 2, 3, 5, 10, 100),
    GRASP("hands", bench_build_hands, 200, false, 1, 10, 100),
    GRASP("carried", bench_build_carried, 200, false, 1, 10, 100),
    GRASP("articulated", bench_build_articulated, 1000, false, 1, 10),
    GRASP("slip", bench_build_slip, 200, false, 1, 10, 100),
    GRASP("cold", bench_build_hands, 200, true, 1, 10, 100),
    PILE("wall", bench_build_wall, 20, 60, 600, 2000), /* these settle, */
    PILE("boxes", bench_build_boxes, 60, 20, 60, 600, 2000),
    PILE("spheres", bench_build_spheres, 80, 60, 600, 2000),
    PILE("pyramid", bench_build_pyramid, 20, 210, 820, 5050),
    PILE("touching", bench_build_touching, 20, 210, 820, 5050),
    PILE("wall-rest", bench_build_wall, 400, 60, 600), /* and these have settled */
    PILE("boxes-rest", bench_build_boxes, 1000, 60, 600),
    PILE("balls-rest", bench_build_spheres, 1000, 60, 600),
};
#undef GRASP
#undef PILE

enum { MOST_FOR_WORLDSTEP = 100 }; /* bodies of a pile: it takes a second or so for a step there */

typedef struct side {
    const char *name;
    bench_solver solver;
    int iterations; /* of quickstep */
} side;

static const side sides[] = {
    {"Pinch", BENCH_PINCH, 0},
    {"worldstep", BENCH_WORLDSTEP, 0},
    {"quickstep 10", BENCH_QUICKSTEP, 10},
    {"quickstep 20", BENCH_QUICKSTEP, 20},
    {"quickstep 50", BENCH_QUICKSTEP, 50},
    {"quickstep 100", BENCH_QUICKSTEP, 100},
    {"quickstep 200", BENCH_QUICKSTEP, 200},
    {"quickstep 500", BENCH_QUICKSTEP, 500},
    {"quickstep 1000", BENCH_QUICKSTEP, 1000},
};
enum { SIDES = sizeof sides / sizeof sides[0], FIRST_QUICKSTEP = 2 };

/* What is timed, and what the forces are compared with. */
enum { CONTACT = 0, WHOLE, TIMES };
enum { LAW = 0, EXACT, ERRORS };
static const char *const time_names[TIMES] = {"contact", "whole"}, *const error_names[ERRORS] = {"law", "exact"};

typedef struct point {
    double seconds[TIMES], ratio[TIMES]; /* medians over the rounds; ratio: over Pinch's in the same round */
    double error[ERRORS];                /* N, the largest; NAN: there is none */
    bool below[TIMES][ERRORS];           /* than Pinch's point */
} point;

typedef struct pareto {
    const pareto_series *of;
    int size, contacts, rounds;
    double largest; /* N, of the exact answers */
    point points[SIDES];
} pareto;

/* The worlds of one size, and what is measured in them. The referee is a second world of Pinch's, whose islands are
 * read between solve and step; piles have none. */
typedef struct pareto_buffer {
    bench_world worlds[SIDES], referee;
    bool runs[SIDES], refereed;
    bool sampling;
    pair_forces exact, found;
    double seconds[SIDES][TIMES][MOST], ratio[SIDES][TIMES][MOST];
} pareto_buffer;

static void solve_exactly(void *context, bench_world *w)
{
    pareto_buffer *b = context;
    if (b->sampling) pair_forces_solve(w, &b->exact);
}

static bool prepare_and_step(bench_world *w, double seconds[TIMES])
{
    double detected = bench_prepare(w);
    seconds[CONTACT] = w->failed ? -1 : bench_step(w);
    seconds[WHOLE] = detected + seconds[CONTACT];
    return seconds[CONTACT] >= 0;
}

static bool set_up(pareto_buffer *b, const pareto_series *g, int size)
{
    bool fine = true;
    double seconds[TIMES];
    b->refereed = !g->pile;
    for (int k = 0; k < SIDES; k++)
        b->runs[k] = !g->pile || sides[k].solver != BENCH_WORLDSTEP || size <= MOST_FOR_WORLDSTEP;
    for (int k = 0; k <= SIDES; k++) {
        if (k < SIDES ? !b->runs[k] : !b->refereed) continue;
        bench_world *w = k < SIDES ? &b->worlds[k] : &b->referee;
        const side *s = &sides[k % SIDES]; /* the referee is Pinch, too */
        bench_settings settings = {
            .solver = s->solver, .cold = g->cold, .threads = 1, .iterations = s->iterations, .watched = k == SIDES};
        bench_world_make(w, &settings, g->step);
        g->build(w, size);
        fine = fine && !w->failed;
    }
    b->referee.watch = solve_exactly;
    b->referee.watch_context = b;
    for (int i = 0; i < g->settle && fine; i++)
        fine = prepare_and_step(&b->worlds[0], seconds) && (!b->refereed || prepare_and_step(&b->referee, seconds));
    return fine;
}

/* Keeps the largest; what is not known once is not known. */
static void keep_larger(double *kept, double value)
{
    if (!(value <= *kept)) *kept = value;
}

static void keep_errors(pareto_buffer *b, int k, pareto *result)
{
    double *error = result->points[k].error;
    keep_larger(&error[LAW], bench_residual(&b->worlds[k]));
    if (!b->sampling) return;
    pair_forces_read(k ? &b->worlds[k] : &b->referee, &b->found);
    if (!isnan(error[EXACT])) keep_larger(&error[EXACT], pair_forces_difference(&b->found, &b->exact));
}

/* Makes two steps in every world, all from where Pinch's own world is. Errors are those of the first. The second is
 * timed: it finds in the caches what the first has left there, as the steps of a run do. */
static bool step_all(pareto_buffer *b, bool sampling, double seconds[SIDES][TIMES], pareto *result)
{
    double unused[TIMES];
    b->sampling = sampling;
    for (int k = 1; k < SIDES; k++)
        if (b->runs[k]) bench_copy_state(&b->worlds[0], &b->worlds[k]);
    bool fine = !b->refereed || prepare_and_step(&b->referee, unused);
    for (int k = 0; k < SIDES && fine; k++) {
        if (!b->runs[k]) continue;
        fine = prepare_and_step(&b->worlds[k], unused);
        if (fine && result) keep_errors(b, k, result);
        fine = fine && prepare_and_step(&b->worlds[k], seconds[k]);
    }
    if (sampling && fine) keep_larger(&result->largest, pair_forces_largest(&b->exact));
    b->sampling = false;
    return fine && (!b->refereed || prepare_and_step(&b->referee, unused));
}

static bool measure(pareto_buffer *b, double budget, pareto *result)
{
    enum { BETWEEN_SAMPLES = FEWEST / SAMPLES };
    double seconds[SIDES][TIMES], start = clock_seconds();
    int i = 0;
    for (int k = 0; k < WARM_UP; k++)
        if (!step_all(b, false, seconds, NULL)) return false;
    for (; i < MOST && (i < FEWEST || clock_seconds() - start < budget); i++) {
        bool sampling = b->refereed && i % BETWEEN_SAMPLES == 0 && i < FEWEST;
        if (!step_all(b, sampling, seconds, result)) return false;
        for (int k = 0; k < SIDES; k++)
            for (int t = 0; t < TIMES && b->runs[k]; t++) {
                b->seconds[k][t][i] = seconds[k][t];
                b->ratio[k][t][i] = seconds[k][t] / seconds[0][t];
            }
    }
    result->rounds = i;
    result->contacts = b->worlds[0].contact_count;
    return true;
}

static void judge(pareto_buffer *b, pareto *result)
{
    double rounding = ROUNDING * result->largest;
    const point *ours = &result->points[0];
    for (int k = 0; k < SIDES; k++) {
        point *p = &result->points[k];
        if (!b->refereed) p->error[EXACT] = NAN;
        if (!b->runs[k]) *p = (point){{NAN, NAN}, {NAN, NAN}, {NAN, NAN}, {{false}}};
        for (int t = 0; t < TIMES && b->runs[k]; t++) {
            p->seconds[t] = median(b->seconds[k][t], result->rounds);
            p->ratio[t] = median(b->ratio[k][t], result->rounds);
            for (int e = 0; e < ERRORS; e++)
                p->below[t][e] = p->ratio[t] < 1 && p->error[e] <= fmax(ours->error[e], rounding);
        }
    }
}

static bool compare_settings(const pareto_series *g, int size, double budget, pareto *result)
{
    pareto_buffer *b = calloc(1, sizeof *b);
    *result = (pareto){.of = g, .size = size};
    if (!b) return false;
    bool fine = set_up(b, g, size) && measure(b, budget, result);
    if (fine) judge(b, result);
    for (int k = 0; k < SIDES; k++)
        if (b->runs[k]) bench_world_free(&b->worlds[k]);
    if (b->refereed) bench_world_free(&b->referee);
    pair_forces_free(&b->exact);
    pair_forces_free(&b->found);
    free(b);
    return fine;
}

/* ---- What is shown. ---- */

static json_t *point_document(const side *s, const point *p)
{
    json_t *below = json_array();
    for (int t = 0; t < TIMES; t++)
        for (int e = 0; e < ERRORS; e++)
            if (p->below[t][e]) json_array_append_new(below, json_sprintf("%s, %s", time_names[t], error_names[e]));
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "setting", s->name, "contact_us",
                     json_number(1e6 * p->seconds[CONTACT]), "whole_us", json_number(1e6 * p->seconds[WHOLE]),
                     "ratio_contact", json_number(p->ratio[CONTACT]), "ratio_whole", json_number(p->ratio[WHOLE]),
                     "law_error_N", json_number(p->error[LAW]), "exact_error_N", json_number(p->error[EXACT]),
                     "below_pinch", below);
}

static json_t *row_document(const pareto *r)
{
    json_t *points = json_array();
    for (int k = 0; k < SIDES; k++) json_array_append_new(points, point_document(&sides[k], &r->points[k]));
    return json_pack("{s:s, s:i, s:i, s:i, s:o, s:o}", "series", r->of->name, "size", r->size, "contacts", r->contacts,
                     "rounds", r->rounds, "largest_force_N", json_number(r->largest), "settings", points);
}

static void print_rows(const pareto *r)
{
    for (int k = 0; k < SIDES; k++) {
        const point *p = &r->points[k];
        char n[2][48], below[64] = "";
        if (isnan(p->seconds[CONTACT])) continue;
        for (int t = 0; t < TIMES; t++)
            for (int e = 0; e < ERRORS; e++)
                if (p->below[t][e])
                    snprintf(below + strlen(below), sizeof below - strlen(below), "%s%s/%s", *below ? ", " : "",
                             time_names[t], error_names[e]);
        printf("%-11s %5d  %-14s | %10.2f %10.2f | %7.2f %7.2f | %s %s | %s\n", k ? "" : r->of->name, r->size,
               sides[k].name, 1e6 * p->seconds[CONTACT], 1e6 * p->seconds[WHOLE], p->ratio[CONTACT], p->ratio[WHOLE],
               number_for_people("%9.1e", p->error[LAW], n[0]), number_for_people("%9.1e", p->error[EXACT], n[1]),
               below);
    }
    fflush(stdout);
}

/* Plots errors over the time of the contact part. */
static command_status draw(const char *folder, const pareto *r)
{
    static const double LEAST = 1e-17; /* N, for the logarithmic axis */
    static const char *const names[] = {"Pinch", "worldstep", "quickstep"};
    char title[96], stem[64], labels[3 * ERRORS][64];
    double seconds[SIDES], errors[ERRORS][SIDES];
    snprintf(title, sizeof title, "pinch bench pareto: %s, %d", r->of->name, r->size);
    snprintf(stem, sizeof stem, "bench-pareto-%s-%d", r->of->name, r->size);
    plot p = {.title = title, .x_label = "us a step", .y_label = "force error, N", .log_x = true, .log_y = true};
    for (int k = 0; k < SIDES; k++) {
        seconds[k] = 1e6 * r->points[k].seconds[CONTACT];
        for (int e = 0; e < ERRORS; e++) errors[e][k] = fmax(r->points[k].error[e], LEAST);
    }
    for (int e = 0; e < ERRORS; e++)
        for (int k = 0; k <= FIRST_QUICKSTEP; k++) {
            if (isnan(seconds[k]) || isnan(r->points[k].error[e])) continue;
            char *label = labels[p.count];
            snprintf(label, sizeof labels[0], "%s, %s", names[k], error_names[e]);
            size_t count = k < FIRST_QUICKSTEP ? 1 : SIDES - FIRST_QUICKSTEP;
            p.lines[p.count++] = (plot_line){label, count, seconds + k, errors[e] + k, e == EXACT, true};
        }
    return plot_write("bench", folder, stem, &p);
}

static command_status run_size(const bench_request *o, const pareto_series *g, int size, json_t *rows)
{
    pareto r;
    char what[64];
    snprintf(what, sizeof what, "%s, size %d", g->name, size);
    progress_tell(o->line, what, NAN);
    if (!compare_settings(g, size, o->budget > 0 ? o->budget : 2, &r)) {
        command_error("bench", "%s: a step failed, or memory ran out", what);
        return COMMAND_SYSTEM;
    }
    progress_end(o->line);
    if (!o->json && !o->quiet) print_rows(&r);
    if (json_array_append_new(rows, row_document(&r)) != 0) return COMMAND_SYSTEM;
    return o->plot ? draw(o->plot, &r) : COMMAND_DONE;
}

/* Worldstep reports every slipping contact. */
static void ignore_message(int number, const char *format, va_list arguments)
{
    (void)number, (void)format, (void)arguments;
}

static void print_head(void)
{
    printf("Errors are the largest of steps in turn, all from the same state, N: of the law that a setting was asked\n"
           "for, and of the forces between pairs beside the exact answer. Times are medians of the steps after these;\n"
           "whole: with collision detection; / Pinch: over Pinch's in the same round. Below Pinch: faster and no less\n"
           "accurate.\n\n"
           "%-11s %5s  %-14s | %10s %10s | %7s %7s | %9s %9s | %s\n",
           "", "size", "", "contact us", "whole us", "/ Pinch", "whole", "law", "exact", "below Pinch");
}

command_status bench_pareto(const bench_request *o)
{
    enum { SERIES = sizeof all_series / sizeof *all_series };
    const int *lists[SERIES];
    for (int k = 0; k < SERIES; k++) lists[k] = all_series[k].sizes;
    command_status status = bench_check_sizes(o, lists, SERIES);
    if (status != COMMAND_DONE) return status;
    json_t *rows = json_array();
    status = !rows ? COMMAND_SYSTEM : o->plot ? plot_folder("bench", o->plot) : COMMAND_DONE;
    dInitODE2(0);
    bench_seed_ode(o->seed);
    dSetMessageHandler(ignore_message);
    if (!o->json && !o->quiet) print_head();
    for (int k = 0; k < SERIES; k++)
        for (int i = 0; i < SIZES && all_series[k].sizes[i] > 0 && status == COMMAND_DONE; i++) {
            int size = all_series[k].sizes[i];
            if (bench_wants_size(o, size)) status = run_size(o, &all_series[k], size, rows);
        }
    dCloseODE();
    json_t *document = json_pack("{s:s, s:s, s:s, s:O}", "command", "bench", "benchmark", "pareto", "size_counts",
                                 "fingertips on one object, grasps, or bodies of a pile", "rows", rows);
    json_decref(rows);
    if (status == COMMAND_DONE && o->json && !json_print_new(document, stdout)) return COMMAND_SYSTEM;
    if (status != COMMAND_DONE || !o->json) json_decref(document);
    return status;
}
