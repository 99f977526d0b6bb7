/*
 * pinch bench collide: what contacts of two geoms cost by fingertip geometry and by ODE, where it has a collider,
 * beside ODE's own box-box, for all the ways in which they meet.
 */
#include "bench.h"

#include "clock.h"
#include "collide_pairs.h"
#include "json_output.h"

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

static bool report(const options *o, entry *entries, int count, int rounds)
{
    double box_box = median(entries[0].odes, rounds);
    json_t *rows = json_array();
    bool print = !o->json && !o->quiet;
    if (print) printf("%-44s %10s %10s %22s %10s\n", "pair", "Pinch ns", "ODE ns", "Pinch/ODE's box-box", "contacts");
    for (int i = 0; i < count; i++) {
        char name[80];
        entry *e = &entries[i];
        double ours = median(e->ours, rounds), odes = e->pair->odes_too ? median(e->odes, rounds) : NAN;
        double contacts = (double)e->contacts / COLLIDE_POSES;
        snprintf(name, sizeof name, "%s, %s", e->pair->name, e->how->name);
        if (print) printf("%-44s %10.0f ", name, 1e9 * ours);
        if (print && e->pair->odes_too) printf("%10.0f %22.2f %10.2f\n", 1e9 * odes, ours / box_box, contacts);
        if (print && !e->pair->odes_too) printf("%10s %22.2f %10.2f\n", "-", ours / box_box, contacts);
        json_array_append_new(rows,
                              json_pack("{s:s, s:s, s:f, s:o, s:f, s:f}", "pair", e->pair->name, "case", e->how->name,
                                        "time_s", ours, "ode_time_s", e->pair->odes_too ? json_real(odes) : json_null(),
                                        "of_ode_box_box", ours / box_box, "contacts_mean", contacts));
    }
    json_t *document = json_pack("{s:s, s:s, s:o}", "command", "bench", "benchmark", "collide", "rows", rows);
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
    good = good && report(o, entries, count, rounds);
    collide_free_pairs(pairs);
    dCloseODE();
    pinch_close_tips();
    free(entries);
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}
