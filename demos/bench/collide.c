/*
 * pinch bench collide: what contacts of two geoms cost by fingertip geometry and by ODE, where it has a collider,
 * beside ODE's own box-box, for all the ways in which they meet.
 */
#include "bench.h"

#include "collide_pairs.h"
#include "common/clock.h"
#include "common/json_output.h"

#include <jansson.h>
#include <math.h>
#include <pinch/fingertip.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROUNDS = 21, AGAIN = 4, CONTACTS = 8 };

/* One pair, one way to meet. */
typedef struct entry {
    collide_pair *pair;
    const collide_case *how;
    collide_pose poses[COLLIDE_POSES];
    double ours[MOST_ROUNDS], odes[MOST_ROUNDS]; /* s per pair */
    double our_time, ode_time;                   /* their medians; NAN: ODE has no collider */
    int contacts;                                /* by ours, of all poses */
} entry;

static double round_of(entry *e, bool ours)
{
    dContactGeom c[CONTACTS];
    dGeomID upper = e->pair->upper, lower = e->pair->lower;
    double spent = 0;
    int contacts = 0;
    collide_set_lower(e->pair, e->how);
    for (int k = 0; k < COLLIDE_POSES; k++) {
        const collide_pose *pose = &e->poses[k];
        dGeomSetQuaternion(upper, pose->turn);
        dGeomSetPosition(upper, pose->x, pose->y, pose->z);
        double start = clock_seconds();
        for (int again = 0; again < AGAIN; again++) {
            if (ours)
                contacts += pinch_tip_collide(upper, lower, CONTACTS, c, sizeof c[0]);
            else
                (void)dCollide(upper, lower, CONTACTS, c, sizeof c[0]);
        }
        spent += clock_seconds() - start;
    }
    if (ours) e->contacts = contacts / AGAIN;
    return spent / (AGAIN * COLLIDE_POSES);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

/* Of one pair over all the ways in which it meets. */
typedef struct pair_mean {
    double ours, odes; /* s per pair */
    int ways;
} pair_mean;

static pair_mean mean_of(const entry *entries, int count, const collide_pair *pair)
{
    pair_mean m = {0, 0, 0};
    for (int i = 0; i < count; i++) {
        if (entries[i].pair != pair) continue;
        m.ours += entries[i].our_time;
        m.odes += entries[i].ode_time;
        m.ways++;
    }
    return (pair_mean){m.ours / m.ways, m.odes / m.ways, m.ways};
}

static void print_row(const char *name, double ours, double odes, double of_box_box)
{
    printf("%-44s %10.0f ", name, 1e9 * ours);
    if (isnan(odes))
        printf("%10s ", "-");
    else
        printf("%10.0f ", 1e9 * odes);
    printf("%22.2f", of_box_box);
}

static json_t *json_or_null(double value)
{
    return isnan(value) ? json_null() : json_real(value);
}

/* Every way in which every pair meets, over ODE's box-box at its first, shallow. */
static json_t *report_ways(const entry *entries, int count, bool print)
{
    json_t *rows = json_array();
    if (print) printf("%-44s %10s %10s %22s %10s\n", "pair", "Pinch ns", "ODE ns", "Pinch/ODE's box-box", "contacts");
    for (int i = 0; i < count; i++) {
        const entry *e = &entries[i];
        double of_box_box = e->our_time / entries[0].ode_time, contacts = (double)e->contacts / COLLIDE_POSES;
        char name[80];
        snprintf(name, sizeof name, "%s, %s", e->pair->name, e->how->name);
        if (print) print_row(name, e->our_time, e->ode_time, of_box_box);
        if (print) printf(" %10.2f\n", contacts);
        json_array_append_new(rows,
                              json_pack("{s:s, s:s, s:f, s:o, s:f, s:f}", "pair", e->pair->name, "case", e->how->name,
                                        "time_s", e->our_time, "ode_time_s", json_or_null(e->ode_time),
                                        "of_ode_box_box", of_box_box, "contacts_mean", contacts));
    }
    return rows;
}

/* The mean over the ways in which a pair meets, over the same of ODE's box-box. */
static json_t *report_pairs(const entry *entries, int count, const collide_pair *pairs, bool print)
{
    double box_box = mean_of(entries, count, &pairs[0]).odes;
    json_t *rows = json_array();
    if (print) printf("\n%-44s %10s %10s %22s\n", "mean of all ways", "Pinch ns", "ODE ns", "Pinch/ODE's box-box");
    for (int i = 0; i < COLLIDE_PAIRS; i++) {
        pair_mean m = mean_of(entries, count, &pairs[i]);
        if (print) print_row(pairs[i].name, m.ours, m.odes, m.ours / box_box);
        if (print) printf("\n");
        json_array_append_new(rows, json_pack("{s:s, s:f, s:o, s:f}", "pair", pairs[i].name, "time_s", m.ours,
                                              "ode_time_s", json_or_null(m.odes), "of_ode_box_box", m.ours / box_box));
    }
    return rows;
}

static bool report(const options *o, entry *entries, int count, int rounds, const collide_pair *pairs)
{
    bool print = !o->json && !o->quiet;
    for (int i = 0; i < count; i++) {
        entries[i].our_time = median(entries[i].ours, rounds);
        entries[i].ode_time = entries[i].pair->odes_too ? median(entries[i].odes, rounds) : NAN;
    }
    json_t *ways = report_ways(entries, count, print), *means = report_pairs(entries, count, pairs, print);
    json_t *document =
        json_pack("{s:s, s:s, s:o, s:o}", "command", "bench", "benchmark", "collide", "rows", ways, "pairs", means);
    if (document && o->json) json_print(document, stdout);
    json_decref(document);
    return document != NULL;
}

static int make_entries(collide_pair *pairs, entry *entries)
{
    int count = 0;
    for (int i = 0; i < COLLIDE_PAIRS; i++)
        for (int c = 0; c < COLLIDE_CASES; c++) {
            if (!collide_has_case(&pairs[i], &collide_cases[c])) continue;
            entry *e = &entries[count++];
            e->pair = &pairs[i];
            e->how = &collide_cases[c];
            collide_set_lower(e->pair, e->how);
            collide_draw_poses(e->pair, e->how, e->poses);
        }
    return count;
}

command_status bench_collide(const options *o)
{
    collide_pair pairs[COLLIDE_PAIRS];
    entry *entries = calloc((size_t)COLLIDE_PAIRS * COLLIDE_CASES, sizeof *entries);
    if (!entries) return COMMAND_SYSTEM;
    memset(pairs, 0, sizeof pairs);
    dInitODE2(0);
    bench_seed_ode(o->seed);
    bool good = collide_make_pairs(pairs);
    int count = good ? make_entries(pairs, entries) : 0;
    double start = clock_seconds(), budget = o->given[OPTION_BUDGET] ? o->budget : INFINITY;
    int rounds = 0;
    do /* taking turns: what slows the machine slows all */
        for (int i = 0; i < count; i++) {
            entries[i].ours[rounds] = round_of(&entries[i], true);
            if (entries[i].pair->odes_too) entries[i].odes[rounds] = round_of(&entries[i], false);
        }
    while (++rounds < MOST_ROUNDS && clock_seconds() - start < budget);
    good = good && report(o, entries, count, rounds, pairs);
    collide_free_pairs(pairs);
    dCloseODE();
    pinch_close_tips();
    free(entries);
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}
