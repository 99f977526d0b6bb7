/*
 * The tables of limits in tests/README.md, cell by cell: each is a run of `pinch run`, whose forces and places are held
 * against closed forms. A cell says how exact they are, or what happens instead.
 */
#define _GNU_SOURCE

#include "support/cmocka_all.h"
#include "support/program.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double GRAVITY = 9.81;

/* A run, and what it must come to. */
typedef struct trial {
    json_t *scene;
    double steps;
    double normal_force, weight; /* of the first object's fingers, N; 0: not looked at */
    double height, sag;          /* of the last object, m, and the depth at rest that its error is a part of; 0: none */
} trial;

/* ---- A cube between a thumb and two fingers. ---- */

typedef struct grip {
    double size, mass, stiffness, friction, normal_force, step;
} grip;

static double time_constant(const grip *g)
{
    return sqrt(g->mass / g->stiffness) / 0.6;
}

static json_t *finger(const grip *g, const char *name, double x, double y, double share, double ramp)
{
    double k = share * g->stiffness, c = 0.6 * share * sqrt(g->stiffness * g->mass);
    return json_pack("{s:s, s:[f,f,f], s:[f,f,f], s:{s:s, s:f}, s:s, s:{s:f, s:f}, s:{s:f, s:f}, s:f, s:f, s:f}", "name",
                     name, "point", x * g->size, y * g->size, 0.0, "normal", x < 0 ? 1.0 : -1.0, 0.0, 0.0, "tip", "type",
                     "sphere", "radius", 0.16 * g->size, "model", "hard", "stiffness", "normal", k, "tangential",
                     k * 2 / 3, "damping", "normal", c, "tangential", c * 2 / 3, "friction", g->friction, "closing",
                     g->normal_force / g->stiffness, "ramp", ramp);
}

static json_t *gripped(const grip *g, double ramp)
{
    return json_pack("{s:s, s:{s:{s:s, s:[f,f,f]}, s:f}, s:[o,o,o], s:[]}", "format", "pinch-scene/1", "object",
                     "shape", "type", "box", "size", g->size, g->size, g->size, "mass", g->mass, "fingers",
                     finger(g, "thumb", -0.5, 0.0, 1.0, ramp), finger(g, "index", 0.5, 0.2, 0.5, ramp),
                     finger(g, "middle", 0.5, -0.2, 0.5, ramp), "schedule");
}

static void simulate(trial *t, double step, double duration)
{
    json_object_set_new(t->scene, "simulation", json_pack("{s:f, s:f}", "step", step, "duration", duration));
    t->steps = duration / step;
}

static void gravity_from(trial *t, double time, double z)
{
    json_array_append_new(json_object_get(t->scene, "schedule"),
                          json_pack("{s:f, s:[f,f,f]}", "time", time, "gravity", 0.0, 0.0, z));
}

/* The fingers close, the weight comes, and what swings has 40 time constants to die away. */
static trial held(const grip *g)
{
    double span = fmax(g->step, time_constant(g)), ramp = 10 * span;
    trial t = {.scene = gripped(g, ramp), .normal_force = g->normal_force, .weight = g->mass * GRAVITY};
    gravity_from(&t, 0, 0);
    gravity_from(&t, 1.2 * ramp, 0);
    gravity_from(&t, 2.2 * ramp, -GRAVITY);
    simulate(&t, g->step, 3 * ramp + 40 * span);
    return t;
}

/* Half as much again as what the friction needs to carry `acceleration`. */
static double enough(double mass, double friction, double acceleration)
{
    return 0.75 * mass * acceleration / friction * 2;
}

/* So soft fingers carry so little that they sag by a hundredth of the cube's size. */
static trial stiffness_trial(double stiffness, double step)
{
    grip g = {0.05, fmin(0.2, stiffness * 0.01 * 0.05 / GRAVITY), stiffness, 0.6, 0, step};
    g.normal_force = enough(g.mass, g.friction, GRAVITY);
    return held(&g);
}

static trial size_trial(double size, double step)
{
    grip g = {size, 1600 * size * size * size, 0, 0.6, 0, step};
    g.stiffness = fmax(4e5 * size, 100 * g.mass * GRAVITY / size);
    g.normal_force = enough(g.mass, g.friction, GRAVITY);
    return held(&g);
}

/* Thumb and fingers press with twice the weight each, so that it takes a coefficient of 0.25 to hold it. */
static trial friction_trial(double friction, double step)
{
    grip g = {0.05, 0.2, 2e4, friction, 2 * 0.2 * GRAVITY, step};
    return held(&g);
}

/* The hand speeds up with 50 m/s^2 and goes on at this speed for a second. */
static trial carried_trial(double speed, double step)
{
    const double acceleration = 50, start = 1;
    grip g = {0.05, 0.2, 2e4, 0.6, enough(0.2, 0.6, GRAVITY + acceleration), step};
    trial t = {.scene = gripped(&g, 0.3), .normal_force = g.normal_force, .weight = g.mass * GRAVITY};
    json_t *schedule = json_object_get(t.scene, "schedule");
    gravity_from(&t, 0, 0);
    gravity_from(&t, 0.4, 0);
    gravity_from(&t, 0.7, -GRAVITY);
    long count = lround(speed / acceleration / step);
    double length = (double)count * step, z = 0;
    for (long i = 0; i <= count; i++) {
        double along = (double)i * step;
        z = acceleration * along * along / 2;
        json_array_append_new(schedule, json_pack("{s:f, s:{s:[f,f,f]}}", "time", start + along, "hand", "translation",
                                                  0.0, 0.0, z));
    }
    double end = start + length + 1;
    json_array_append_new(schedule, json_pack("{s:f, s:{s:[f,f,f]}}", "time", end, "hand", "translation", 0.0, 0.0,
                                              z + acceleration * length));
    simulate(&t, step, end);
    return t;
}

/* ---- Objects that fall and stack on a table, far from the hand. ---- */

static json_t *body(const char *name, json_t *shape, double mass, double z, double stiffness, double damping)
{
    json_t *b = json_pack("{s:s, s:o, s:[f,f,f], s:{s:f}, s:{s:f, s:f}, s:f}", "name", name, "shape", shape, "position",
                          0.0, 0.0, z, "stiffness", "normal", stiffness, "damping", "normal", damping, "tangential",
                          damping, "friction", 0.5);
    if (mass > 0) json_object_set_new(b, "mass", json_real(mass));
    return b;
}

static json_t *box(double x, double z)
{
    return json_pack("{s:s, s:[f,f,f]}", "type", "box", "size", x, x, z);
}

static trial on_table(json_t *objects, double stiffness, double damping)
{
    grip g = {0.05, 1e-3, 2e4, 0.6, 5, 0};
    trial t = {.scene = gripped(&g, 0)};
    json_object_set_new(json_object_get(t.scene, "object"), "position", json_pack("[f,f,f]", 10.0, 0.0, 0.0));
    json_t *fingers = json_object_get(t.scene, "fingers"), *f;
    size_t i;
    json_array_foreach(fingers, i, f)
    {
        json_t *point = json_object_get(f, "point");
        json_array_set_new(point, 0, json_real(10.0 + json_number_value(json_array_get(point, 0))));
    }
    json_object_set_new(t.scene, "objects", objects);
    json_object_set_new(t.scene, "environment",
                        json_pack("[o]", body("table", box(4, 0.1), 0, -0.05, stiffness, damping)));
    return t;
}

/* Two cubes, one on the other. The upper one is looked at, whose place depends on both. */
static trial stack(double lower, double upper, double step)
{
    const double size = 0.05;
    double stiffness = fmax(1e5, 1000 * fmax(lower, upper) * GRAVITY / size), pair = stiffness / 2;
    double damping = sqrt(stiffness * (lower + upper));
    trial t = on_table(json_pack("[o,o]", body("lower", box(size, size), lower, size / 2, stiffness, damping),
                                 body("upper", box(size, size), upper, 1.5 * size, stiffness, damping)),
                       stiffness, damping);
    gravity_from(&t, 0, -GRAVITY);
    t.sag = ((lower + upper) + upper) * GRAVITY / pair;
    t.height = 1.5 * size - t.sag;
    simulate(&t, step, fmax(2, 100 * step));
    return t;
}

static trial heavy_above_trial(double ratio, double step)
{
    return stack(0.2, 0.2 * ratio, step);
}

static trial heavy_below_trial(double ratio, double step)
{
    return stack(0.2 * ratio, 0.2, step);
}

/* A ball strikes a table 0.1 m thick, both so stiff that it comes in by less than half its radius. A hundredfold gravity
 * brings it to its speed within a tenth of a second. */
static trial impact_trial(double speed, double step)
{
    const double radius = 0.025, mass = 0.2, strong = 100 * GRAVITY, deep = speed / (0.4 * radius);
    double stiffness = fmax(1e5, 2 * mass * deep * deep), damping = 2.8 * sqrt(stiffness * mass), fall = speed / strong;
    json_t *ball = json_pack("{s:s, s:f}", "type", "sphere", "radius", radius);
    trial t = on_table(json_pack("[o]", body("ball", ball, mass, radius + speed * fall / 2, stiffness, damping)),
                       stiffness, damping);
    gravity_from(&t, 0, -strong);
    gravity_from(&t, fall, -strong);
    gravity_from(&t, fall, -GRAVITY);
    t.sag = mass * GRAVITY / (stiffness / 2);
    t.height = radius - t.sag;
    simulate(&t, step, fall + 3);
    return t;
}

/* ---- What a run came to. ---- */

typedef struct outcome {
    char word[16]; /* "": the errors say it */
    double error;
} outcome;

static double normal_forces(const json_t *fingers, double *lift)
{
    json_t *f;
    size_t i;
    *lift = 0;
    json_array_foreach(fingers, i, f) *lift += json_number_value(json_array_get(json_object_get(f, "force"), 2));
    return json_number_value(json_object_get(json_array_get(fingers, 0), "normal_force"));
}

static bool is_dropped(const trial *t, const json_t *document)
{
    const char *said = json_string_value(json_object_get(document, "outcome"));
    return t->weight > 0 && said && strcmp(said, "dropped") == 0;
}

static outcome errors_of(const trial *t, const json_t *document)
{
    outcome o = {.error = 0};
    double lift, normal = normal_forces(json_object_get(document, "fingers"), &lift);
    if (t->weight > 0) o.error = fmax(fabs(normal / t->normal_force - 1), fabs(lift / t->weight - 1));
    if (t->sag > 0) {
        const json_t *objects = json_object_get(document, "objects");
        const json_t *last = json_array_get(objects, json_array_size(objects) - 1);
        double z = json_number_value(json_array_get(json_object_get(last, "position"), 2));
        o.error = fabs(z - t->height) / t->sag;
        if (o.error > 0.01) snprintf(o.word, sizeof o.word, z < -0.1 ? "through" : z < t->height ? "falls" : "bounces");
    } else if (!(o.error <= 0.01)) {
        snprintf(o.word, sizeof o.word, "slips");
    }
    return o;
}

static outcome run(const trial *t)
{
    outcome o = {.error = INFINITY};
    char executable[] = PINCH_EXECUTABLE, command[] = "run", name[] = "scene.json", json[] = "--json", quiet[] = "--quiet";
    char *argv[] = {executable, command, name, json, quiet, NULL}, *text = json_dumps(t->scene, 0);
    char *folder = program_make_folder(), *path = program_write_file(folder, name, text);
    program_result r = program_run(folder, argv);
    json_t *document = json_loads(r.out, 0, NULL);
    if (r.status == 2)
        snprintf(o.word, sizeof o.word, "refused");
    else if (r.status == 1 && document)
        snprintf(o.word, sizeof o.word, "reported");
    else if (r.status != 0 || !document)
        fail_msg("exit %d: %s", r.status, r.err);
    else if (is_dropped(t, document))
        snprintf(o.word, sizeof o.word, "falls");
    else
        o = errors_of(t, document);
    json_decref(document);
    program_free(&r);
    program_remove_folder(folder);
    free(path);
    free(text);
    return o;
}

/* ---- The tables. ---- */

static const struct {
    const char *title;
    trial (*make)(double value, double step);
} TABLES[] = {{"stiffness (N/m)", stiffness_trial},  {"size (m)", size_trial},
              {"friction", friction_trial},          {"mass above : below", heavy_above_trial},
              {"mass below : above", heavy_below_trial}, {"carried at (m/s)", carried_trial},
              {"impact at (m/s)", impact_trial}};
enum { TABLE_COUNT = sizeof TABLES / sizeof *TABLES, MOST_COLUMNS = 16 };

/* Cuts a row of a Markdown table into its cells. */
static int cells_of(char *line, char *cells[MOST_COLUMNS])
{
    int count = 0;
    for (char *cell = strtok(line, "|"); cell && count < MOST_COLUMNS; cell = strtok(NULL, "|")) {
        cell += strspn(cell, " ");
        size_t length = strlen(cell);
        while (length > 0 && cell[length - 1] == ' ') cell[--length] = '\0';
        cells[count++] = cell;
    }
    return count;
}

/* With sanitizers and in every build: what takes some seconds together. The rest is for full runs. */
static bool is_affordable(const trial *t)
{
    return getenv("PINCH_TEST_FULL") || t->steps <= 3500;
}

static int check_cell(const char *title, const char *value, const char *step, const char *expected,
                      trial (*make)(double, double))
{
    trial t = make(strtod(value, NULL), strtod(step, NULL));
    outcome o = {.error = 0};
    int wrong = 0;
    if (is_affordable(&t)) {
        o = run(&t);
        char *end;
        double bound = strtod(expected, &end);
        if (o.word[0] ? strcmp(o.word, expected) != 0 : *end || end == expected || !(o.error <= bound)) {
            print_error("%s %s at steps of %s s: expected %s, got %s %.2g\n", title, value, step, expected, o.word,
                        o.error);
            wrong = 1;
        }
    }
    json_decref(t.scene);
    return wrong;
}

static void every_cell_is_what_its_run_comes_to(void **state)
{
    (void)state;
    char *text = program_read_file(PINCH_SOURCE_DIR "/tests/README.md"), *rest = text, *line;
    char *head[MOST_COLUMNS], *row[MOST_COLUMNS];
    int table = -1, columns = 0, found = 0, wrong = 0;
    while ((line = strsep(&rest, "\n"))) {
        if (line[0] != '|') {
            table = -1;
            continue;
        }
        if (table < 0) {
            columns = cells_of(line, head);
            for (int i = 0; i < TABLE_COUNT && table < 0; i++)
                if (strcmp(head[0], TABLES[i].title) == 0) table = i;
            if (table < 0) table = TABLE_COUNT; /* another one */
            found += table < TABLE_COUNT;
        } else if (table < TABLE_COUNT && line[2] != '-') {
            assert_int_equal(cells_of(line, row), columns);
            for (int i = 1; i < columns; i++)
                wrong += check_cell(head[0], row[0], head[i], row[i], TABLES[table].make);
        }
    }
    free(text);
    assert_int_equal(found, TABLE_COUNT);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_cell_is_what_its_run_comes_to)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
