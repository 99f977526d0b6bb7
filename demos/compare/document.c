/* The JSON document of a compared scene. */
#define _POSIX_C_SOURCE 200809L

#include "sample.h"
#include "scene_compare.h"
#include "solver_run.h"

#include "common/measure.h"
#include "common/output.h"
#include "common/vector.h"
#include "scenes/shape/shape.h"
#include "scenes/world/world_hand.h"
#include "view/page.h"
#include "view/thumbnail.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* Curves and contacts are for looking at, not for calculating: seven digits will do. */
static json_t *short_number(double value)
{
    char text[32];
    if (!isfinite(value)) return json_null();
    snprintf(text, sizeof text, "%.7g", value);
    return json_real(strtod(text, NULL));
}

static json_t *short_numbers(const double *values, int count, int stride)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) (void)json_array_append_new(list, short_number(values[i * stride]));
    return list;
}

static json_t *metrics_document(const solver_run *c)
{
    json_t *document = json_object();
    for (int m = 0; m < METRIC_COUNT; m++) {
        const metric_info *about = metric_about((metric)m);
        double value = c->metrics[m];
        json_t *entry = *about->unit || isnan(value) ? json_number(value) : json_boolean(value != 0);
        (void)json_object_set_new(document, about->key, entry);
    }
    return document;
}

/* What happened, and to whom: a finger, a joint of a hand, or an object where there are several. */
static json_t *event_document(const world *w, const simulation_event *e)
{
    json_t *finger = e->finger >= 0 ? json_string(w->fingers[e->finger].finger->name) : json_null();
    json_t *event = json_pack("{s:o, s:o, s:s}", "time", json_number(e->time), "finger", finger, "type",
                              simulation_event_name(e->type));
    if (event && e->type == EVENT_LIMIT)
        (void)json_object_set_new(event, "joint", json_string(w->hands[e->hand].joints[e->joint].name));
    if (event && e->type == EVENT_DROPPED && w->object_count > 1)
        (void)json_object_set_new(event, "object", json_string(w->scene->objects[e->object].name));
    return event;
}

static json_t *event_documents(const solver_run *c)
{
    json_t *list = json_array();
    for (int i = 0; i < c->result.event_count; i++)
        (void)json_array_append_new(list, event_document(c->w, &c->result.events[i]));
    return list;
}

static json_t *finger_documents(const solver_run *c)
{
    json_t *list = json_array();
    for (int i = 0; i < c->w->finger_count; i++) {
        const world_finger *finger = &c->w->fingers[i];
        const world_finger_state *s = &finger->state;
        (void)json_array_append_new(
            list,
            json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "name", finger->finger->name, "state",
                      pinch_contact_state_text(s->state), "force", json_numbers(s->force, 3), "normal_force",
                      json_number(s->normal_force), "tangential_force", json_number(scene_norm(s->tangential_force)),
                      "slip", json_number(s->slip_total), "slip_margin", json_number(world_slip_margin(c->w, finger))));
    }
    return list;
}

static json_t *curve_documents(const solver_run *c)
{
    const observer *r = &c->observer;
    json_t *fingers = json_array();
    for (int f = 0; f < c->w->finger_count; f++) {
        const double *part = r->curve + OBSERVER_FINGERS + OBSERVER_PER_FINGER * f;
        (void)json_array_append_new(fingers,
                                    json_pack("{s:s, s:o, s:o, s:o}", "name", c->w->fingers[f].finger->name, "normal",
                                              short_numbers(part + OBSERVER_NORMAL, r->rows, r->columns), "tangential",
                                              short_numbers(part + OBSERVER_TANGENTIAL, r->rows, r->columns), "slip",
                                              short_numbers(part + OBSERVER_SLIP, r->rows, r->columns)));
    }
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "time",
                     short_numbers(r->curve + OBSERVER_TIME, r->rows, r->columns), "x",
                     short_numbers(r->curve + OBSERVER_POSITION, r->rows, r->columns), "y",
                     short_numbers(r->curve + OBSERVER_POSITION + 1, r->rows, r->columns), "z",
                     short_numbers(r->curve + OBSERVER_POSITION + 2, r->rows, r->columns), "rotation",
                     short_numbers(r->curve + OBSERVER_ROTATION, r->rows, r->columns), "divergence",
                     short_numbers(r->curve + OBSERVER_DIVERGENCE, r->rows, r->columns), "balance",
                     short_numbers(r->curve + OBSERVER_BALANCE, r->rows, r->columns), "fingers", fingers);
}

static json_t *run_document(const solver_run *c)
{
    char hash[24];
    bool quick = c->settings.contact_solver == WORLD_QUICKSTEP, pinch = c->settings.contact_solver == WORLD_PINCH;
    json_t *not_expressed = json_array(), *remarks = json_array();
    world_not_expressed(c->w, json_append_text, not_expressed);
    simulation_remarks(c->w, &c->result, json_append_text, remarks);
    snprintf(hash, sizeof hash, "%016" PRIx64, c->hash);
    return json_pack("{s:s, s:s, s:o, s:o, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:s, s:o}", "run", c->name,
                     "contact_solver", world_solver_name(c->settings.contact_solver), "solver",
                     pinch ? json_string(pinch_solver_name(c->settings.solver.solver)) : json_null(),
                     "quickstep_iterations", quick ? json_integer(c->settings.quickstep_iterations) : json_null(),
                     "status", pinch_solve_status_text(world_solve_status(c->w)), "metrics", metrics_document(c),
                     "displacement", json_numbers(c->result.motion.displacement, 3), "fingers", finger_documents(c),
                     "events", event_documents(c), "not_expressed", not_expressed, "remarks", remarks, "hash", hash,
                     "curves", curve_documents(c));
}

/* A run in short. Three runs have one: Pinch, quickstep with the first number of iterations, and worldstep. */
static json_t *short_document(const solver_run *c)
{
    const simulation_result *r = &c->result;
    json_t *forces = json_array();
    for (int i = 0; i < c->w->finger_count; i++)
        (void)json_array_append_new(forces, json_numbers(c->w->fingers[i].state.force, 3));
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}", "contact_solver",
                     world_solver_name(c->settings.contact_solver), "status",
                     pinch_solve_status_text(world_solve_status(c->w)), "step_us", json_number(c->metrics[METRIC_COST]),
                     "displacement", json_numbers(r->motion.displacement, 3), "creep", json_number(r->motion.creep),
                     "creep_angular", json_number(r->motion.creep_angular), "force_error", json_number(r->force_error),
                     "torque_error", json_number(r->torque_error), "forces", forces, "dropped",
                     c->metrics[METRIC_DROPPED] != 0);
}

static json_t *short_documents(const scene_comparison *c)
{
    json_t *list = json_array();
    bool quick = false;
    for (int k = 0; k < c->run_count; k++) {
        bool is_quick = c->runs[k].settings.contact_solver == WORLD_QUICKSTEP;
        if (!(is_quick && quick)) (void)json_array_append_new(list, short_document(&c->runs[k]));
        quick = quick || is_quick;
    }
    return list;
}

/* Pinch's cost over that of the fastest of ODE's solvers. */
static double cost_ratio(const scene_comparison *c)
{
    double fastest = NAN;
    for (int k = 1; k < c->run_count; k++) fastest = fmin(fastest, c->runs[k].metrics[METRIC_COST]);
    return c->runs[0].metrics[METRIC_COST] / fastest;
}

static json_t *contact_document(const scene_comparison *c, const sample *s, const sample_contact *contact)
{
    json_t *forces = json_object(), *errors = json_object();
    double radius = c->s->objects[0].shape.bounding_radius;
    for (int k = 0; k < c->run_count; k++) {
        (void)json_object_set_new(forces, c->runs[k].name, short_numbers(contact->force[k], 3, 1));
        (void)json_object_set_new(errors, c->runs[k].name, short_number(sample_contact_error(s, contact, k, radius)));
    }
    json_t *finger = contact->finger >= 0 ? json_string(c->s->fingers[contact->finger].name) : json_null();
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "finger", finger, "position",
                     short_numbers(contact->position, 3, 1), "normal", short_numbers(contact->normal, 3, 1), "depth",
                     short_number(contact->depth), "friction", short_number(contact->friction), "exact",
                     short_numbers(contact->exact, 3, 1), "exact_torsion", short_number(contact->exact_torsion),
                     "forces", forces, "errors", errors);
}

static json_t *sample_document(const scene_comparison *c, const sample *s)
{
    static const char *const statuses[] = {"solved", "no contact", "no exact answer", "left to ODE", "out of memory"};
    json_t *errors = json_object(), *contacts = json_array();
    for (int k = 0; k < c->run_count; k++)
        (void)json_object_set_new(errors, c->runs[k].name,
                                  s->status == SAMPLE_OK ? json_number(s->error[k]) : json_null());
    for (int i = 0; i < s->contact_count; i++)
        (void)json_array_append_new(contacts, contact_document(c, s, &s->contacts[i]));
    bool solved = s->status == SAMPLE_OK;
    return json_pack("{s:I, s:o, s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "step", (json_int_t)s->at.step, "time",
                     json_number(s->time), "reason", sample_reason_text(s->at.reason), "status", statuses[s->status],
                     "force_scale", json_number(solved ? s->scale : NAN), "exact_residual",
                     json_number(solved ? s->residual : NAN), "errors", errors, "residuals",
                     short_numbers(s->residuals, s->residual_count, 1), "contacts", contacts);
}

/* quickstep's force error against its iterations, as the median over the samples. */
static json_t *convergence_document(const scene_comparison *c)
{
    json_t *iterations = json_array(), *errors = json_array();
    for (int i = 0; i < SAMPLE_COUNTS && c->run_count > 1; i++) {
        double values[COMPARE_MOST_SAMPLES];
        int count = 0;
        for (int k = 0; k < c->sample_count; k++)
            if (c->samples[k].status == SAMPLE_OK) values[count++] = c->samples[k].count_error[i];
        (void)json_array_append_new(iterations, json_integer(sample_counts[i]));
        (void)json_array_append_new(errors, json_number(median(values, count)));
    }
    return json_pack("{s:o, s:o}", "iterations", iterations, "quickstep", errors);
}

/* ---- The scene's outlines, for pictures. ---- */

enum { DIRECTIONS = 72 };

/* The corner of the hull that lies farthest along `direction`. */
static void farthest_corner(const scene_hull *hull, const double direction[3], double corner[3])
{
    size_t best = 0;
    for (size_t i = 1; i < hull->vertex_count; i++)
        if (scene_dot(hull->vertices + 3 * i, direction) > scene_dot(hull->vertices + 3 * best, direction)) best = i;
    scene_copy(hull->vertices + 3 * best, corner);
}

/* The point of a shape that lies farthest along a world direction. `piece` is the piece of a mesh. */
static void farthest(const scene_shape *shape, size_t piece, const double pose[7], const double direction[3],
                     double point[3])
{
    double local[3], found[3];
    scene_rotate_back(pose + 3, direction, local);
    if (shape->type == SCENE_MESH)
        farthest_corner(&shape->pieces[piece], local, found);
    else
        scene_shape_support(shape, local, found);
    scene_rotate(pose + 3, found, point);
    scene_add_scaled(point, 1, pose);
}

/* The silhouette of a shape: its farthest points along directions all around. The directions are turned slightly out of
 * the view's plane, so that faces and edges seen edge on give their corners instead of their middles. */
static json_t *silhouette(const scene_shape *shape, size_t piece, const double pose[7], const int axes[2])
{
    json_t *points = json_array();
    double last[2] = {NAN, NAN};
    for (int k = 0; k < DIRECTIONS; k++) {
        double angle = 2 * SCENE_PI * (k + 0.3183) / DIRECTIONS, direction[3] = {1e-7, 2e-7, 3e-7}, point[3];
        direction[axes[0]] += cos(angle);
        direction[axes[1]] += sin(angle);
        scene_add_scaled(direction, 1 / scene_norm(direction) - 1, direction);
        farthest(shape, piece, pose, direction, point);
        const double seen[2] = {point[axes[0]], point[axes[1]]};
        double near_by = 1e-6 * shape->bounding_radius;
        if (fabs(seen[0] - last[0]) <= near_by && fabs(seen[1] - last[1]) <= near_by) continue;
        (void)json_array_append_new(points, json_numbers(seen, 2));
        memcpy(last, seen, sizeof last);
    }
    return points;
}

static void add_outlines(json_t *list, const char *kind, const char *name, const scene_shape *shape,
                         const double pose[7], const int axes[2])
{
    size_t pieces = shape->type == SCENE_MESH ? shape->piece_count : 1;
    for (size_t piece = 0; piece < pieces; piece++)
        (void)json_array_append_new(list, json_pack("{s:s, s:s, s:o}", "kind", kind, "name", name, "points",
                                                    silhouette(shape, piece, pose, axes)));
}

static json_t *view_document(const world *w, const sample *s, const int axes[2])
{
    const scene *scene_of = w->scene;
    json_t *outlines = json_array();
    double centre[2] = {s->poses[0][axes[0]], s->poses[0][axes[1]]}, size = scene_of->objects[0].shape.bounding_radius;
    for (size_t i = 0; i < scene_of->environment_count; i++) {
        const scene_environment *e = &scene_of->environment[i];
        double pose[7];
        memcpy(pose, e->position, sizeof e->position);
        memcpy(pose + 3, e->orientation, sizeof e->orientation);
        add_outlines(outlines, "environment", e->name, &e->shape, pose, axes);
    }
    add_outlines(outlines, "object", "object", &scene_of->objects[0].shape, s->poses[0], axes);
    for (int i = 0; i < w->finger_count && i < SAMPLE_FINGERS; i++) {
        const scene_finger *f = w->fingers[i].finger;
        add_outlines(outlines, "finger", f->name, &f->tip, s->poses[1 + i], axes);
        for (int a = 0; a < 2; a++) /* shows small tips as a whole, and of large ones the part that touches */
            size = fmax(size, fmin(fabs(s->poses[1 + i][axes[a]] - centre[a]) + f->tip.bounding_radius,
                                   1.8 * scene_of->objects[0].shape.bounding_radius));
    }
    return json_pack("{s:[i,i], s:o, s:f, s:o}", "axes", axes[0], axes[1], "centre", json_numbers(centre, 2), "size",
                     1.1 * size, "outlines", outlines);
}

/* The scene at the start of a sampled step as outlines seen from two sides, in m: {"time", "views": [{"axes": [2],
 * "centre": [2], "size", "outlines": [{"kind": "object|finger|environment", "name", "points": [[..2]..]}]}]}. NULL when
 * memory runs out. */
static json_t *drawing_document(const world *w, const sample *s)
{
    static const int sides[2][2][2] = {{{0, 2}, {1, 2}}, {{0, 1}, {2, 1}}};
    const int(*side)[2] = sides[w->scene->dimension == 2];
    return json_pack("{s:f, s:i, s:[o, o]}", "time", s->time, "step", (int)s->at.step, "views",
                     view_document(w, s, side[0]), view_document(w, s, side[1]));
}

/* ---- The whole. ---- */

/* The sample that is drawn: the last one with a loaded contact. */
static const sample *to_draw(const scene_comparison *c)
{
    for (int k = c->sample_count - 1; k >= 0; k--)
        if (c->samples[k].status == SAMPLE_OK) return &c->samples[k];
    return NULL;
}

/* Pinch's run as a small drawing, for pages. NULL when memory runs out. */
static json_t *thumb_document(const film *pictures)
{
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return NULL;
    thumbnail_write(pictures, thumbnail_last_touch(pictures), stream);
    json_t *thumb = fclose(stream) == 0 ? json_string(text) : NULL;
    free(text);
    return thumb;
}

/* The films of Pinch's run, which has the shapes, and of those that are shown beside it. */
static json_t *films_document(const scene_comparison *c)
{
    json_t *films = json_array();
    for (int k = 0; k < c->run_count; k++) {
        if (!c->runs[k].pictures) continue;
        json_t *of_run = film_finish(c->runs[k].pictures, c->runs[k].w) ? page_film(c->runs[k].pictures, k == 0) : NULL;
        if (!of_run || json_array_append_new(films, of_run)) {
            json_decref(films);
            return NULL;
        }
    }
    return films;
}

json_t *scene_comparison_document(const scene_comparison *c)
{
    const scene *s = c->s;
    const world *w = c->runs[0].w;
    json_t *runs = json_array(), *samples = json_array();
    for (int k = 0; k < c->run_count; k++) (void)json_array_append_new(runs, run_document(&c->runs[k]));
    for (int k = 0; k < c->sample_count; k++) (void)json_array_append_new(samples, sample_document(c, &c->samples[k]));
    const sample *drawn = to_draw(c);
    json_t *document = json_pack(
        "{s:o, s:s, s:i, s:I, s:o, s:o, s:o, s:o, s:s, s:i, s:b, s:o, s:o, s:o, s:o, s:o, s:o}", "scene",
        json_text(s->file), "name", s->name, "dimension", s->dimension, "steps", (json_int_t)w->steps, "time_s",
        json_number(w->time), "step_s", json_number(s->step), "radius",
        json_number(s->objects[0].shape.bounding_radius), "mass", json_number(s->objects[0].mass), "contacts",
        c->settings->manifolds ? "pinch" : "ode", "points", c->settings->points, "cold_start", c->settings->cold_start,
        "cost_ratio", json_number(cost_ratio(c)), "contact_solvers", short_documents(c), "runs", runs, "samples",
        samples, "convergence", convergence_document(c), "drawing", drawn ? drawing_document(w, drawn) : json_null());
    if (document && c->settings->films) {
        json_object_set_new(document, "films", films_document(c));
        json_object_set_new(document, "thumb", c->runs[0].pictures ? thumb_document(c->runs[0].pictures) : NULL);
    }
    return document;
}
