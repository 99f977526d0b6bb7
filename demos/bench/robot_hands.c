/*
 * pinch bench robots: what a step of robot hands costs that hold a cube, at rest and shaken, beside quickstep with its
 * own joints and motors. The worlds are those of `pinch compare`, with a shipped scene's hand as often as `size` says.
 */
#include "allocations.h"
#include "bench.h"
#include "common/measure.h"
#include "common/output.h"
#include "common/own_place.h"
#include "scenes/world/world_hand.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 20000, FEWEST = 50, WORLDS = 2 };
static const double PITCH = 0.6; /* m, from hand to hand */

static const struct robot {
    const char *name, *scene;
    bool shaken;
    double settled; /* s, from here on it is measured */
} robots[] = {
    {"16 joints, at rest", "scenes/hands/allegro-like-shake.json", false, 4},
    {"16 joints, shaken", "scenes/hands/allegro-like-shake.json", true, 2},
    {"24 joints, at rest", "scenes/hands/shadow-like-shake.json", false, 6},
    {"24 joints, shaken", "scenes/hands/shadow-like-shake.json", true, 2},
};
static const int sizes[] = {1, 4, 16, 0};

typedef struct robot_timing {
    int size, bodies, joints, contacts, rounds;
    double seconds[WORLDS], ratio, iterations, allocations;
    long unsolved, fallbacks;
    bool held;
} robot_timing;

/* ---- The scene. ---- */

static bool shift(json_t *body, const char *key, double by)
{
    json_t *position = json_object_get(body, key);
    double x = json_number_value(json_array_get(position, 0));
    return json_array_set_new(position, 0, json_real(x + by)) == 0;
}

/* Puts `count` copies of a hand and its object beside each other, which gravity is kept from until the hands have
 * closed. */
static bool multiply(json_t *document, int count, bool shaken)
{
    json_t *from = json_object_get(document, "hand"), *object = json_object_get(document, "object");
    json_t *hands = json_array(), *objects = json_array();
    bool fine = hands && objects;
    for (int k = 0; k < count && fine; k++) {
        json_t *h = json_deep_copy(from), *o = json_deep_copy(object);
        char name[2][16];
        snprintf(name[0], sizeof name[0], "hand%d", k + 1);
        snprintf(name[1], sizeof name[1], "cube%d", k + 1);
        fine = h && o && shift(json_object_get(h, "base"), "position", PITCH * k) && shift(o, "position", PITCH * k) &&
               json_object_set_new(h, "name", json_string(name[0])) == 0 &&
               json_object_set_new(o, "name", json_string(name[1])) == 0;
        fine = json_array_append_new(hands, h) == 0 && json_array_append_new(objects, o) == 0 && fine;
    }
    json_t *schedule = json_pack("[{s:f, s:[i,i,i]}, {s:f, s:[i,i,i]}, {s:f, s:[i,i,f]}]", "time", 0.0, "gravity", 0, 0,
                                 0, "time", 0.8, "gravity", 0, 0, 0, "time", 1.2, "gravity", 0, 0, -9.81);
    json_t *motion = json_pack("{s:f, s:{s:{s:[f,f,f], s:f, s:f}}}", "time", 1.5, "hand", "translation", "amplitude",
                               0.01, 0.005, 0.01, "frequency", 3.0, "fade", 0.5);
    fine = fine && motion && (!shaken || json_array_append(schedule, motion) == 0);
    json_decref(motion);
    fine = json_object_set_new(document, "schedule", schedule) == 0 &&
           json_object_set_new(document, "hands", hands) == 0 &&
           json_object_set_new(document, "objects", objects) == 0 && fine;
    (void)json_object_del(document, "hand");
    (void)json_object_del(document, "object");
    return fine;
}

/* NULL, with a message, where the scene is not there or memory ran out. */
static scene *load(const struct robot *robot, int count)
{
    char path[1024];
    scene *s = NULL;
    scene_error error = {"its scene is not in its place, or memory ran out"};
    json_error_t syntax;
    json_t *document = own_place_data(robot->scene, path, sizeof path) ? json_load_file(path, 0, &syntax) : NULL;
    if (document && multiply(document, count, robot->shaken))
        (void)scene_load_document(path, "", 0, document, &s, &error);
    if (!s) command_error("bench", "%s: %s", robot->name, error.text);
    json_decref(document);
    return s;
}

/* ---- The steps. ---- */

/* Makes a step. Returns the seconds from the first contact handed over to its end, or a negative number. */
static double step(world *w)
{
    double before = w->step_s;
    return world_advance(w) == WORLD_OK ? w->step_s - before : -1;
}

static bool held(const world *w, const scene *s)
{
    static const double FALLEN = 0.05; /* m */
    for (int k = 0; k < w->object_count; k++)
        if (!(fabs(dBodyGetPosition(w->objects[k].body)[2] - s->objects[k].position[2]) < FALLEN)) return false;
    return true;
}

static bool measure(world *const worlds[WORLDS], const struct robot *robot, double budget, robot_timing *t)
{
    static double seconds[WORLDS][MOST], ratio[MOST];
    double spent, start;
    for (int k = 0; k < WORLDS; k++)
        while (worlds[k]->time < robot->settled)
            if (step(worlds[k]) < 0) return false;
    pinch_ode_reset_statistics(worlds[0]->plugin);
    start = clock_seconds();
    long allocated = 0;
    for (t->rounds = 0; t->rounds < MOST && (t->rounds < FEWEST || clock_seconds() - start < budget); t->rounds++) {
        for (int k = 0; k < WORLDS; k++) {
            long before = allocations_counted();
            if ((spent = step(worlds[k])) < 0) return false;
            if (k == 0) allocated += allocations_counted() - before;
            seconds[k][t->rounds] = spent;
        }
        ratio[t->rounds] = seconds[0][t->rounds] / seconds[1][t->rounds];
    }
    pinch_ode_stats stats = pinch_ode_statistics(worlds[0]->plugin);
    for (int k = 0; k < WORLDS; k++) t->seconds[k] = median(seconds[k], t->rounds);
    t->ratio = median(ratio, t->rounds);
    t->allocations = (double)allocated / t->rounds;
    t->iterations = stats.islands > 0 ? (double)stats.iterations / (double)stats.islands : 0;
    t->unsolved = stats.unconverged_steps;
    t->fallbacks = stats.fallback_islands + stats.joints_left;
    return true;
}

static command_status time_robots(const struct robot *robot, int size, double budget, robot_timing *t)
{
    world *worlds[WORLDS] = {NULL};
    char error[256];
    scene *s = load(robot, size);
    if (!s) return COMMAND_SYSTEM;
    *t = (robot_timing){.size = size};
    bool fine = true;
    for (int k = 0; k < WORLDS && fine; k++) {
        world_settings settings = world_default_settings(s);
        settings.contact_solver = k ? WORLD_QUICKSTEP : WORLD_PINCH;
        fine = world_create(s, &settings, &worlds[k], error) == WORLD_OK;
    }
    fine = fine && measure(worlds, robot, budget, t);
    if (fine) {
        t->bodies = worlds[0]->body_count;
        for (int k = 0; k < worlds[0]->hand_count; k++) t->joints += worlds[0]->hands[k].joint_count;
        t->contacts = worlds[0]->contact_count;
        t->held = held(worlds[0], s);
    } else {
        command_error("bench", "%s, size %d: a step failed, or memory ran out", robot->name, size);
    }
    for (int k = 0; k < WORLDS; k++) world_free(worlds[k]);
    scene_free(s);
    return fine ? COMMAND_DONE : COMMAND_SYSTEM;
}

/* ---- What is printed. ---- */

static json_t *row_document(const struct robot *robot, const robot_timing *t)
{
    return json_pack("{s:s, s:i, s:i, s:i, s:i, s:i, s:b, s:o, s:o, s:o, s:o, s:o, s:i, s:i}", "case", robot->name,
                     "size", t->size, "bodies", t->bodies, "joints", t->joints, "contacts", t->contacts, "rounds",
                     t->rounds, "held", t->held, "step_us", json_number(1e6 * t->seconds[0]), "quickstep_us",
                     json_number(1e6 * t->seconds[1]), "ratio_quickstep", json_number(t->ratio), "iterations",
                     json_number(t->iterations), "allocations_per_step", json_number(t->allocations), "unsolved_steps",
                     (int)t->unsolved, "left_to_ode", (int)t->fallbacks);
}

command_status bench_robots(const bench_request *o)
{
    command_status status = bench_check_sizes(o, (const int *const[]){sizes}, 1);
    if (status != COMMAND_DONE) return status;
    json_t *rows = json_array();
    if (!rows) status = COMMAND_SYSTEM;
    allocations_count_ode();
    dInitODE2(0);
    bench_seed_ode(o->seed);
    bool table = !o->json && !o->quiet;
    if (table)
        printf("A step lasts from the first contact handed over to the end of the step. Times are medians of steps in\n"
               "turn; quickstep makes 20 iterations. Size counts hands, each with a cube.\n"
               "%-19s %4s %6s %8s | %9s %9s %7s | %5s %6s %7s\n",
               "", "size", "joints", "contacts", "Pinch us", "quickstep", "/quick", "iter", "alloc", "retried");
    for (size_t r = 0; r < sizeof robots / sizeof *robots; r++) {
        for (size_t i = 0; sizes[i] > 0 && status == COMMAND_DONE; i++) {
            robot_timing t;
            if (!bench_wants_size(o, sizes[i])) continue;
            status = time_robots(&robots[r], sizes[i], o->budget > 0 ? o->budget : 1, &t);
            if (status != COMMAND_DONE) break;
            if (table)
                printf("%-19s %4d %6d %8d | %9.2f %9.2f %7.2f | %5.2f %6.2f %7ld\n", robots[r].name, t.size, t.joints,
                       t.contacts, 1e6 * t.seconds[0], 1e6 * t.seconds[1], t.ratio, t.iterations, t.allocations,
                       t.unsolved);
            fflush(stdout);
            if (json_array_append_new(rows, row_document(&robots[r], &t)) != 0) status = COMMAND_SYSTEM;
        }
    }
    dCloseODE();
    json_t *document = status == COMMAND_DONE ? json_pack("{s:s, s:s, s:s, s:O}", "command", "bench", "benchmark",
                                                          "robots", "size_counts", "hands", "rows", rows)
                                              : NULL;
    json_decref(rows);
    if (status == COMMAND_DONE && o->json && !json_print_new(document, stdout)) return COMMAND_SYSTEM;
    if (!o->json) json_decref(document);
    return status;
}
