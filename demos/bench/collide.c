/* pinch bench collide: the cost of contacts between two geoms by Pinch's collision detection and by ODE's collider,
 * where it has one, beside ODE's own box-box, for all the ways in which the geoms meet. */
#include "bench.h"

#include "common/measure.h"
#include "common/output.h"

#include <jansson.h>
#include <math.h>
#include <pinch/fingertip.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- The pairs of geoms, about 1 m large, and the ways in which they meet. ---- */

enum { COLLIDE_CASES = 9, COLLIDE_PAIRS = 23, COLLIDE_POSES = 500 };

/* A way to meet. The upper geom comes down on the lower one's top. */
typedef enum collide_turn {
    COLLIDE_TUMBLED, /* at random angles, half of them nearly upright */
    COLLIDE_UPRIGHT, /* its axis is the vertical, turned about it at random */
    COLLIDE_LYING    /* its axis is level */
} collide_turn;

typedef struct collide_case {
    const char *name;
    collide_turn turn;
    double overlap;   /* m, of the bounding boxes */
    bool border;      /* at the border of the lower one's top; otherwise well inside it */
    bool lower_lying; /* the lower geom lies on its side */
} collide_case;

typedef struct collide_pair {
    const char *name;  /* the upper geom, then the lower one */
    bool ode_collides; /* ODE has a collider */
    dGeomID upper, lower;
    double border;               /* m, from the lower geom's axis; 0: its top is round */
    bool has_turns, lower_turns; /* does turning it make a difference? */
} collide_pair;

/* A pose of the upper geom. */
typedef struct collide_pose {
    dQuaternion turn;
    double x, y, z;
} collide_pose;

static const double TOUCHING = 1e-6, SHALLOW = 1e-3, DEEP = 0.15; /* m */

static const collide_case collide_cases[COLLIDE_CASES] = {
    {"shallow", COLLIDE_TUMBLED, SHALLOW, false, false},
    {"touching", COLLIDE_TUMBLED, TOUCHING, false, false},
    {"deep", COLLIDE_TUMBLED, DEEP, false, false},
    {"at the border", COLLIDE_TUMBLED, SHALLOW, true, false},
    {"deep at the border", COLLIDE_TUMBLED, DEEP, true, false},
    {"standing", COLLIDE_UPRIGHT, SHALLOW, false, false},
    {"standing over the border", COLLIDE_UPRIGHT, SHALLOW, true, false},
    {"lying", COLLIDE_LYING, SHALLOW, false, false},
    {"both lying", COLLIDE_LYING, SHALLOW, false, true},
};

static dGeomID ellipsoid(double a, double b, double c)
{
    dGeomID geom;
    pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
    tip.size[0] = a;
    tip.size[1] = b;
    tip.size[2] = c;
    return pinch_create_tip(NULL, &tip, &geom) == PINCH_OK ? geom : NULL;
}

/* A prism over a regular hexagon. dCreateConvex keeps the arrays, so they must stay. */
enum { SIDES = 6 };
typedef struct prism {
    double planes[4 * (SIDES + 2)], points[6 * SIDES];
    unsigned polygons[5 * SIDES + 2 * (SIDES + 1)];
} prism;

static prism small_prism, large_prism;

static dGeomID convex(prism *p, double radius, double height)
{
    static const double TURN = 1.0471975511965976; /* rad */
    unsigned *polygon = p->polygons;
    double *plane = p->planes;
    memset(p, 0, sizeof *p);
    for (unsigned k = 0; k < 2 * SIDES; k++) {
        double *x = p->points + 3 * k;
        x[0] = radius * cos(TURN * k);
        x[1] = radius * sin(TURN * k);
        x[2] = k < SIDES ? -0.5 * height : 0.5 * height;
    }
    for (unsigned k = 0; k < SIDES; k++, plane += 4) {
        const unsigned next = (k + 1) % SIDES, corners[5] = {4, k, next, SIDES + next, SIDES + k};
        memcpy(polygon, corners, sizeof corners);
        polygon += 5;
        plane[0] = cos(TURN * (k + 0.5));
        plane[1] = sin(TURN * (k + 0.5));
        plane[3] = radius * cos(0.5 * TURN);
    }
    for (unsigned top = 0; top < 2; top++, plane += 4) {
        *polygon++ = SIDES;
        for (unsigned k = 0; k < SIDES; k++) *polygon++ = top ? SIDES + k : SIDES - 1 - k;
        plane[2] = top ? 1 : -1;
        plane[3] = 0.5 * height;
    }
    const pinch_convex known = {p->planes, SIDES + 2, p->points, p->polygons, 2 * SIDES};
    dGeomID geom = dCreateConvex(NULL, p->planes, SIDES + 2, p->points, 2 * SIDES, p->polygons);
    return pinch_tip_know_convex(geom, &known) == PINCH_OK ? geom : NULL;
}

static dGeomID make_geom(char shape, bool lower)
{
    switch (shape) {
    case 'b':
        return lower ? dCreateBox(NULL, 1, 0.8, 0.6) : dCreateBox(NULL, 0.5, 0.4, 0.3);
    case 's':
        return dCreateSphere(NULL, lower ? 0.3 : 0.15);
    case 'c':
        return lower ? dCreateCapsule(NULL, 0.3, 0.6) : dCreateCapsule(NULL, 0.15, 0.4);
    case 'y':
        return lower ? dCreateCylinder(NULL, 0.3, 0.6) : dCreateCylinder(NULL, 0.15, 0.5);
    case 'v':
        return lower ? convex(&large_prism, 0.5, 0.6) : convex(&small_prism, 0.2, 0.3);
    case 'p':
        return dCreatePlane(NULL, 0, 0, 1, 0);
    default:
        return lower ? ellipsoid(0.5, 0.4, 0.3) : ellipsoid(0.2, 0.15, 0.25);
    }
}

/* How far the border of a lower geom's top is from its axis, along x. */
static double border_of(char shape)
{
    return shape == 'b' ? 0.5 : shape == 'v' ? 0.47 : shape == 'y' ? 0.3 : 0;
}

/* Returns false when memory runs out. */
static bool make_pairs(collide_pair pairs[COLLIDE_PAIRS])
{
    static const struct {
        const char *name, shapes[3]; /* upper, lower: b box, s sphere, c capsule, y cylinder, v convex, p plane,
                                      * e ellipsoid */
    } rows[COLLIDE_PAIRS] = {
        {"box-box", "bb"},
        {"sphere-sphere", "ss"},
        {"sphere-box", "sb"},
        {"sphere-capsule", "sc"},
        {"sphere-cylinder", "sy"},
        {"sphere-convex", "sv"},
        {"sphere-plane", "sp"},
        {"capsule-box", "cb"},
        {"capsule-capsule", "cc"},
        {"capsule-cylinder", "cy"},
        {"capsule-convex", "cv"},
        {"capsule-plane", "cp"},
        {"box-convex", "bv"},
        {"box-plane", "bp"},
        {"cylinder-box", "yb"},
        {"cylinder-cylinder", "yy"},
        {"cylinder-convex", "yv"},
        {"cylinder-plane", "yp"},
        {"convex-convex", "vv"},
        {"convex-plane", "vp"},
        {"ellipsoid-box", "eb"},
        {"ellipsoid-cylinder", "ey"},
        {"ellipsoid-ellipsoid", "ee"},
    };
    for (int i = 0; i < COLLIDE_PAIRS; i++) {
        char upper = rows[i].shapes[0], lower = rows[i].shapes[1];
        pairs[i].name = rows[i].name;
        pairs[i].ode_collides = upper != 'e';
        pairs[i].upper = make_geom(upper, false);
        pairs[i].lower = make_geom(lower, true);
        pairs[i].border = border_of(lower);
        pairs[i].has_turns = upper != 's' && upper != 'e';
        pairs[i].lower_turns = lower == 'y' || lower == 'c';
        if (!pairs[i].upper || !pairs[i].lower) return false;
    }
    return true;
}

static void free_pairs(collide_pair pairs[COLLIDE_PAIRS])
{
    for (int i = 0; i < COLLIDE_PAIRS; i++) {
        if (pairs[i].upper) dGeomDestroy(pairs[i].upper);
        if (pairs[i].lower) dGeomDestroy(pairs[i].lower);
    }
}

/* Can the pair meet like that? */
static bool has_case(const collide_pair *pair, const collide_case *c)
{
    if (!pair->ode_collides && (c->border || c->turn != COLLIDE_TUMBLED)) return false;
    return (c->turn == COLLIDE_TUMBLED || pair->has_turns) && (!c->border || pair->border > 0) &&
           (!c->lower_lying || pair->lower_turns);
}

static void draw_turn(collide_turn turn, bool loose, double *q)
{
    dQuaternion about, level;
    double length = 0, spread = loose ? 1 : 1e-3;
    dQFromAxisAndAngle(about, 0, 0, 1, 2 * M_PI * dRandReal());
    dQFromAxisAndAngle(level, 0, 1, 0, 0.5 * M_PI);
    switch (turn) {
    case COLLIDE_UPRIGHT:
        memcpy(q, about, sizeof about);
        return;
    case COLLIDE_LYING:
        dQMultiply0(q, about, level);
        return;
    default:
        for (int i = 0; i < 4; i++) q[i] = (i == 0 ? 1 : spread) * (dRandReal() - (i ? 0.5 : 0));
        for (int i = 0; i < 4; i++) length = hypot(length, q[i]);
        for (int i = 0; i < 4; i++) q[i] /= length;
    }
}

/* Turns the lower geom, which is about the origin. */
static void set_lower(collide_pair *pair, const collide_case *c)
{
    dMatrix3 R;
    if (dGeomGetClass(pair->lower) == dPlaneClass) return;
    dRFromAxisAndAngle(R, 1, 0, 0, c->lower_lying ? 0.5 * M_PI : 0);
    dGeomSetRotation(pair->lower, R);
}

/* Draws the upper geom's poses from dRand. The lower one has been turned before. */
static void draw_poses(collide_pair *pair, const collide_case *c, collide_pose poses[COLLIDE_POSES])
{
    dReal upper[6], lower[6] = {0, 0, 0, 0, 0, 0};
    bool dome = pair->border == 0 && dGeomGetClass(pair->lower) != dPlaneClass;
    if (dGeomGetClass(pair->lower) != dPlaneClass) dGeomGetAABB(pair->lower, lower);
    dGeomSetPosition(pair->upper, 0, 0, 0);
    for (int k = 0; k < COLLIDE_POSES; k++) {
        draw_turn(c->turn, k % 2, poses[k].turn);
        dGeomSetQuaternion(pair->upper, poses[k].turn);
        dGeomGetAABB(pair->upper, upper);
        poses[k].x = c->border ? pair->border : dome || c->lower_lying ? 0 : 0.1;
        poses[k].y = dome && !c->lower_lying ? 0 : 0.05;
        poses[k].z = lower[5] - upper[4] - c->overlap;
    }
}

/* ---- Measuring them. ---- */

enum { MOST_ROUNDS = 21, AGAIN = 4, CONTACTS = 8 };

/* One pair in one way to meet. */
typedef struct entry {
    collide_pair *pair;
    const collide_case *how;
    collide_pose poses[COLLIDE_POSES];
    double ours[MOST_ROUNDS], odes[MOST_ROUNDS]; /* s per pair */
    double our_time, ode_time;                   /* their medians; NAN: ODE has no collider */
    int contacts;                                /* by Pinch, over all poses */
} entry;

static double round_of(entry *e, bool ours)
{
    dContactGeom c[CONTACTS];
    dGeomID upper = e->pair->upper, lower = e->pair->lower;
    double spent = 0;
    int contacts = 0;
    set_lower(e->pair, e->how);
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

/* The mean of one pair over all the ways in which it meets. */
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

/* Reports every way in which every pair meets, over ODE's box-box in its first way, shallow. */
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

/* Reports the mean over the ways in which a pair meets, over the same mean of ODE's box-box. */
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

static bool report(const bench_request *o, entry *entries, int count, int rounds, const collide_pair *pairs)
{
    bool print = !o->json && !o->quiet;
    for (int i = 0; i < count; i++) {
        entries[i].our_time = median(entries[i].ours, rounds);
        entries[i].ode_time = entries[i].pair->ode_collides ? median(entries[i].odes, rounds) : NAN;
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
            if (!has_case(&pairs[i], &collide_cases[c])) continue;
            entry *e = &entries[count++];
            e->pair = &pairs[i];
            e->how = &collide_cases[c];
            set_lower(e->pair, e->how);
            draw_poses(e->pair, e->how, e->poses);
        }
    return count;
}

static void tell(const bench_request *o, int round, int pair, int pairs, double spent)
{
    char what[128];
    if (!progress_is_due(o->line)) return;
    double by_rounds = (round + (double)(pair + 1) / pairs) / MOST_ROUNDS,
           by_time = o->budget > 0 ? spent / o->budget : 0;
    snprintf(what, sizeof what, "round %d of %s%d, %d of %d ways to meet", round + 1, o->budget > 0 ? "at most " : "",
             MOST_ROUNDS, pair + 1, pairs);
    progress_tell(o->line, what, fmin(1, fmax(by_rounds, by_time)));
}

command_status bench_collide(const bench_request *o)
{
    collide_pair pairs[COLLIDE_PAIRS];
    entry *entries = calloc((size_t)COLLIDE_PAIRS * COLLIDE_CASES, sizeof *entries);
    memset(pairs, 0, sizeof pairs);
    dInitODE2(0);
    bench_seed_ode(o->seed);
    bool good = entries && make_pairs(pairs);
    if (!good) command_error("bench", "out of memory");
    int count = good ? make_entries(pairs, entries) : 0;
    double start = clock_seconds(), budget = o->budget > 0 ? o->budget : INFINITY;
    int rounds = 0;
    do /* the pairs take turns, so that what slows the machine slows all */
        for (int i = 0; i < count; i++) {
            entries[i].ours[rounds] = round_of(&entries[i], true);
            if (entries[i].pair->ode_collides) entries[i].odes[rounds] = round_of(&entries[i], false);
            tell(o, rounds, i, count, clock_seconds() - start);
        }
    while (++rounds < MOST_ROUNDS && clock_seconds() - start < budget);
    progress_end(o->line);
    good = good && report(o, entries, count, rounds, pairs);
    free_pairs(pairs);
    dCloseODE();
    pinch_close_tips();
    free(entries);
    return good ? COMMAND_DONE : COMMAND_SYSTEM;
}
