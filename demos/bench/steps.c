/* pinch bench step, hands, carried, articulated, slip, cold, pile, pyramid: what a step costs against size, beside
 * ODE's solvers. */
#include "allocations.h"
#include "bench.h"
#include "common/output.h"
#include "side_by_side.h"
#include "view/plot.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 8, SERIES = 3, FIT_FROM = 100 };

typedef struct series {
    const char *name;
    timing_plan plan;
    int sizes[SIZES + 1]; /* 0: no more */
    int worldstep_up_to;  /* the largest size at which worldstep settles in some seconds */
} series;

/* A grasp settles in 0.2 s. Pinch settles it, because only Pinch has tangential elasticity. */
#define GRASP(builder, is_cold)                                                                                        \
    {                                                                                                                  \
        .build = (builder), .step = 1e-3, .settle = 200, .settler = BENCH_PINCH, .cold = (is_cold), .budget = 1        \
    }
/* Links on hinges take longer to settle: the last of 1,000 hands lies still after 640 steps. */
#define JOINTED(builder)                                                                                               \
    {                                                                                                                  \
        .build = (builder), .step = 1e-3, .settle = 700, .settler = BENCH_PINCH, .budget = 1                           \
    }
/* A wall is built in its final place, and each solver settles its own: a wall that another solver has left would have
 * to be mended first. */
#define WALL(builder)                                                                                                  \
    {                                                                                                                  \
        .build = (builder), .step = 0.01, .settle = 400, .each_settles = true, .settler = BENCH_PINCH, .stands = 0.05, \
        .budget = 2                                                                                                    \
    }
/* Heaps have 10 s to come to rest, each solver its own. */
#define HEAP(builder)                                                                                                  \
    {                                                                                                                  \
        .build = (builder), .step = 0.01, .settle = 1000, .each_settles = true, .settler = BENCH_PINCH, .budget = 2    \
    }

typedef struct benchmark {
    const char *name;
    const char *unit; /* what `size` counts */
    series series[SERIES];
} benchmark;

static const benchmark benchmarks[] = {
    {"step",
     "fingertips on one object",
     {{"object", GRASP(bench_build_object, false), {2, 3, 5, 10, 100, 1000, 10000}, 100}}},
    {"hands",
     "grasps of five fingertips",
     {{"hands", GRASP(bench_build_hands, false), {1, 10, 100, 1000, 10000}, 10000}}},
    {"carried",
     "the same, carried up and down",
     {{"carried", GRASP(bench_build_carried, false), {1, 10, 100, 1000, 10000}, 10000}}},
    {"articulated",
     "hands of five fingers with three hinges each",
     {{"articulated", JOINTED(bench_build_articulated), {1, 10, 100, 1000}, 1000}}},
    {"slip", "cubes rubbed by four fingertips", {{"slip", GRASP(bench_build_slip, false), {1, 10, 100, 1000}, 1000}}},
    {"cold",
     "grasps of five fingertips, no warm start",
     {{"cold", GRASP(bench_build_hands, true), {1, 10, 100, 1000}, 1000}}},
    {"pile",
     "bodies",
     {{"wall", WALL(bench_build_wall), {60, 200, 600, 2000}, 0},
      {"boxes", HEAP(bench_build_boxes), {60, 200, 600, 2000}, 60},
      {"spheres", HEAP(bench_build_spheres), {60, 200, 600, 2000}, 0}}},
    {"pyramid",
     "boxes",
     {{"pyramid", WALL(bench_build_pyramid), {55, 210, 820, 5050}, 0},
      {"touching", WALL(bench_build_touching), {55, 210, 820, 5050}, 0}}},
};

/* The results of one series. */
typedef struct results {
    const series *of;
    int count;
    side_by_side rows[SIZES];
    double exponent[BENCH_SOLVERS]; /* exponent of cost against size; NAN: too few sizes */
} results;

/* The slope of log cost against log size by least squares, over the sizes from FIT_FROM on. NAN where there are fewer
 * than two of them, or a cost is missing. */
static double fit_exponent(const double *size, const double *cost, int count)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < count; i++) {
        if (size[i] < FIT_FROM) continue;
        double a = log(size[i]), b = log(cost[i]);
        n++, x += a, y += b, xx += a * a, xy += a * b;
    }
    return n < 2 ? NAN : (n * xy - x * y) / (n * xx - x * x);
}

static void fit(results *r)
{
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        double size[SIZES], seconds[SIZES];
        for (int i = 0; i < r->count; i++) {
            size[i] = r->rows[i].size;
            seconds[i] = r->rows[i].of[k].seconds;
        }
        r->exponent[k] = fit_exponent(size, seconds, r->count);
    }
}

static json_t *side_document(const series *of, const solver_timing *s)
{
    bool is_to_stand = of->plan.stands > 0 && !isnan(s->seconds);
    return json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "fastest_m_s",
        json_number(isnan(s->seconds) ? NAN : s->fastest), "step_us", json_number(1e6 * s->seconds), "whole_us",
        json_number(1e6 * s->whole), "residual_N", json_number(isnan(s->seconds) ? NAN : s->residual), "iterations",
        json_number(s->iterations), "allocations_per_step", json_number(isnan(s->seconds) ? NAN : s->allocations),
        "kinetic_energy_J", json_number(isnan(s->seconds) ? NAN : s->energy), "moved_m",
        json_number(isnan(s->seconds) ? NAN : s->moved), "stands", is_to_stand ? json_boolean(s->stands) : json_null());
}

static json_t *row_document(const series *s, const side_by_side *d)
{
    const solver_timing *ours = &d->of[BENCH_PINCH];
    return json_pack("{s:s, s:i, s:i, s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:o, s:o}", "series",
                     s->name, "size", d->size, "bodies", d->bodies, "contacts", d->contacts, "rounds", d->rounds,
                     "ratio_quickstep", json_number(d->ratio[0]), "ratio_worldstep", json_number(d->worldstep_ratio[0]),
                     "whole_ratio_quickstep", json_number(d->ratio[1]), "whole_ratio_worldstep",
                     json_number(d->worldstep_ratio[1]), "residual_max", json_number(ours->solver_residual),
                     "memory_bytes", json_integer((json_int_t)ours->memory), "memory_per_contact_bytes",
                     json_number((double)ours->memory / d->contacts), "memory_per_body_bytes",
                     json_number((double)ours->memory / d->bodies), "unsolved_steps", (int)ours->unsolved, "pinch",
                     side_document(s, ours), "quickstep", side_document(s, &d->of[BENCH_QUICKSTEP]));
}

static json_t *series_document(const results *r)
{
    return json_pack("{s:s, s:o, s:o, s:o}", "series", r->of->name, "exponent_pinch",
                     json_number(r->exponent[BENCH_PINCH]), "exponent_quickstep",
                     json_number(r->exponent[BENCH_QUICKSTEP]), "exponent_worldstep",
                     json_number(r->exponent[BENCH_WORLDSTEP]));
}

static bool print_document(const benchmark *b, const results *all, int count)
{
    json_t *rows = json_array(), *fits = json_array();
    for (int s = 0; s < count; s++) {
        for (int i = 0; i < all[s].count; i++) {
            json_t *row = row_document(all[s].of, &all[s].rows[i]);
            json_object_set_new(row, "worldstep", side_document(all[s].of, &all[s].rows[i].of[BENCH_WORLDSTEP]));
            json_array_append_new(rows, row);
        }
        json_array_append_new(fits, series_document(&all[s]));
    }
    json_t *document = json_pack("{s:s, s:s, s:s, s:o, s:o}", "command", "bench", "benchmark", b->name, "size_counts",
                                 b->unit, "rows", rows, "fits", fits);
    return json_print_new(document, stdout);
}

static void print_head(const benchmark *b)
{
    printf(
        "A step lasts from the first contact handed over to the end of the step and the emptying of the contacts. The\n"
        "whole step has collision detection, too, by pinch_ode_each_pair for Pinch and dSpaceCollide for the others.\n"
        "Times are medians of steps in turn. Size counts %s. Residual: forces against the contact law, N.\n%s\n",
        b->unit,
        b->series[0].plan.stands > 0 ? "A wall or pyramid stands when nothing is more than 5 cm from where it was laid."
                                       " Of a heap, the last column says how\nfast its fastest body is by Pinch and by "
                                       "quickstep.\n"
                                     : "");
    printf("%-11s %6s %8s | %10s %10s %10s | %7s %7s | %10s %7s %7s | %9s %9s %9s | %6s %6s %6s %6s %s\n", "", "size",
           "contacts", "Pinch us", "quickstep", "worldstep", "/quick", "/world", "whole us", "/quick", "/world",
           "residual", "quickstep", "worldstep", "iter", "alloc", "B/cont", "retried",
           b->series[0].plan.stands > 0 ? "stands" : "");
}

/* Says of a wall who stands, and of a heap how fast it still moves under Pinch and under quickstep. */
static const char *what_became(const series *s, const side_by_side *d, char speeds[48])
{
    bool ours = d->of[BENCH_PINCH].stands, quick = d->of[BENCH_QUICKSTEP].stands;
    if (!(s->plan.stands > 0) && !s->plan.each_settles) return "";
    if (!(s->plan.stands > 0)) {
        snprintf(speeds, 48, "%.1e, %.1e m/s", d->of[BENCH_PINCH].fastest, d->of[BENCH_QUICKSTEP].fastest);
        return speeds;
    }
    return ours ? quick ? "both" : "Pinch's" : quick ? "quickstep's" : "none";
}

static void print_row(const series *s, const side_by_side *d)
{
    const solver_timing *ours = &d->of[BENCH_PINCH], *quick = &d->of[BENCH_QUICKSTEP], *full = &d->of[BENCH_WORLDSTEP];
    char n[13][48];
    printf("%-11s %6d %8d | %s %s %s | %s %s | %s %s %s | %s %s %s | %s %6.2f %6.0f %6ld %s\n", s->name, d->size,
           d->contacts, number_for_people("%10.2f", 1e6 * ours->seconds, n[0]),
           number_for_people("%10.2f", 1e6 * quick->seconds, n[1]),
           number_for_people("%10.2f", 1e6 * full->seconds, n[2]), number_for_people("%7.2f", d->ratio[0], n[3]),
           number_for_people("%7.2f", d->worldstep_ratio[0], n[4]),
           number_for_people("%10.2f", 1e6 * ours->whole, n[10]), number_for_people("%7.2f", d->ratio[1], n[11]),
           number_for_people("%7.2f", d->worldstep_ratio[1], n[12]), number_for_people("%9.1e", ours->residual, n[5]),
           number_for_people("%9.1e", quick->residual, n[6]),
           number_for_people("%9.1e", isnan(full->seconds) ? NAN : full->residual, n[7]),
           number_for_people("%6.2f", ours->iterations, n[8]), ours->allocations, (double)ours->memory / d->contacts,
           ours->unsolved, what_became(s, d, n[9]));
    fflush(stdout);
}

/* Plots cost against size on logarithmic axes, each solver with its fitted exponent. */
static command_status draw(const char *folder, const benchmark *b, const results *r)
{
    static const char *const names[BENCH_SOLVERS] = {"Pinch", "quickstep (20)", "worldstep"};
    char title[128], stem[64], labels[BENCH_SOLVERS][64];
    size_t count = (size_t)r->count;
    double *values = calloc((BENCH_SOLVERS + 1) * (count + 1), sizeof *values);
    if (!values) {
        command_error("bench", "out of memory");
        return COMMAND_SYSTEM;
    }
    double *sizes = values + BENCH_SOLVERS * count;
    snprintf(stem, sizeof stem, "bench-%s", r->of->name);
    snprintf(title, sizeof title, "pinch bench %s: %s", b->name, r->of->name);
    plot p = {.title = title, .x_label = b->unit, .y_label = "us a step", .log_x = true, .log_y = true};
    for (size_t i = 0; i < count; i++) sizes[i] = r->rows[i].size;
    for (int k = 0; k < BENCH_SOLVERS; k++) {
        for (size_t i = 0; i < count; i++) values[(size_t)k * count + i] = 1e6 * r->rows[i].of[k].seconds;
        if (isnan(r->exponent[k]))
            snprintf(labels[k], sizeof labels[k], "%s", names[k]);
        else
            snprintf(labels[k], sizeof labels[k], "%s, ~ n^%.2f", names[k], r->exponent[k]);
        p.lines[p.count++] = (plot_line){labels[k], count, sizes, values + (size_t)k * count, k > 0, true};
    }
    command_status status = plot_write("bench", folder, stem, &p);
    free(values);
    return status;
}

/* Adds the sizes of a series from the i-th on that the request does not leave out. */
static void add_later(const bench_request *o, const series *s, int i, timing_progress *p)
{
    for (; i < SIZES && s->sizes[i] > 0; i++) {
        if (!bench_wants_size(o, s->sizes[i])) continue;
        p->later++;
        p->later_size += s->sizes[i];
    }
}

static void count_later(const bench_request *o, const benchmark *b, const series *s, int i, timing_progress *p)
{
    p->later = 0;
    p->later_size = 0;
    add_later(o, s, i + 1, p);
    for (const series *other = s + 1; other < b->series + SERIES && other->name; other++) add_later(o, other, 0, p);
}

static command_status run_series(const bench_request *o, const benchmark *b, const series *s, results *r)
{
    timing_progress advance = {.line = o->line, .series = s->name};
    r->of = s;
    timing_plan plan = s->plan;
    if (o->budget > 0) plan.budget = o->budget;
    plan.threads = o->threads > 0 ? o->threads : 1;
    plan.progress = &advance;
    for (int i = 0; i < SIZES && s->sizes[i] > 0; i++) {
        if (!bench_wants_size(o, s->sizes[i])) continue;
        side_by_side *d = &r->rows[r->count];
        plan.worldstep = s->sizes[i] <= s->worldstep_up_to;
        count_later(o, b, s, i, &advance);
        if (!time_side_by_side(&plan, s->sizes[i], d)) {
            command_error("bench", "%s, size %d: a step failed, or memory ran out", s->name, s->sizes[i]);
            return COMMAND_SYSTEM;
        }
        r->count++;
        progress_end(o->line);
        if (!o->json && !o->quiet) print_row(s, d);
    }
    fit(r);
    char n[48];
    if (!o->json && !o->quiet && !isnan(r->exponent[BENCH_PINCH]))
        printf("%-11s cost grows as size to the power of %.2f (quickstep %s), from %d on\n", s->name,
               r->exponent[BENCH_PINCH], number_for_people("%.2f", r->exponent[BENCH_QUICKSTEP], n), FIT_FROM);
    return COMMAND_DONE;
}

/* Worldstep reports every slipping contact. The residuals say the same. */
static void ignore_message(int number, const char *format, va_list arguments)
{
    (void)number, (void)format, (void)arguments;
}

static command_status run(const bench_request *o, const benchmark *b)
{
    const int *lists[SERIES];
    int listed = 0;
    while (listed < SERIES && b->series[listed].name) {
        lists[listed] = b->series[listed].sizes;
        listed++;
    }
    command_status status = bench_check_sizes(o, lists, listed);
    if (status != COMMAND_DONE) return status;
    results *all = calloc(SERIES, sizeof *all);
    if (!all) {
        command_error("bench", "out of memory");
        return COMMAND_SYSTEM;
    }
    if (o->plot) status = plot_folder("bench", o->plot);
    int count = 0;
    allocations_count_ode();
    dInitODE2(0);
    bench_seed_ode(o->seed);
    dSetMessageHandler(ignore_message);
    if (!o->json && !o->quiet) print_head(b);
    for (; count < SERIES && b->series[count].name && status == COMMAND_DONE; count++) {
        status = run_series(o, b, &b->series[count], &all[count]);
        if (status == COMMAND_DONE && o->plot) status = draw(o->plot, b, &all[count]);
    }
    dCloseODE();
    if (status == COMMAND_DONE && o->json && !print_document(b, all, count)) status = COMMAND_SYSTEM;
    free(all);
    return status;
}

command_status bench_steps(const bench_request *request)
{
    const benchmark *b = benchmarks;
    while (strcmp(b->name, request->name) != 0) b++; /* cli/pinch_bench.c calls with names from this table only */
    return run(request, b);
}
