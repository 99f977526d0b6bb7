#include "sample.h"

#include "common/vector.h"
#include "exact/exact.h"

#include <stdlib.h>
#include <string.h>

const int sample_counts[SAMPLE_COUNTS] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};

static int geom_index(const world *w, dGeomID geom)
{
    for (int i = 0; i < w->geom_count; i++)
        if (w->geoms[i] == geom) return i;
    return -1;
}

static int points_of_pair(const pinch_ode_contact *list, int count, const pinch_ode_contact *of)
{
    int points = 0;
    for (int k = 0; k < count; k++) points += list[k].geom1 == of->geom1 && list[k].geom2 == of->geom2;
    return points;
}

/* One contact of the problem as ODE's solvers get it: its own stiffness, damping and friction. */
static void give_ode(const pinch_contact *c, const pinch_ode_contact *from, int sharing, world_contact *to,
                     pinch_material *material)
{
    memset(to, 0, sizeof *to);
    to->contact.geom.g1 = from->geom1;
    to->contact.geom.g2 = from->geom2;
    to->contact.geom.depth = c->depth;
    for (int i = 0; i < 3; i++) {
        to->contact.geom.pos[i] = c->position[i];
        to->contact.geom.normal[i] = c->normal[i];
    }
    to->body[0] = from->body1;
    to->body[1] = from->body2;
    to->sharing = sharing;
    *material = pinch_default_material();
    material->model = c->model;
    material->friction = c->friction[0];
    material->stiffness[0] = sharing * c->stiffness[0];
    material->damping[0] = sharing * c->damping[0];
}

/* The contact itself, with the exact force and Pinch's. */
static void fill_contact(const world *w, const pinch_contact *c, const pinch_ode_contact *from, const double *exact,
                         sample_contact *to)
{
    double t2[3], sign = from->geom2 == w->object_geom ? -1 : 1;
    dGeomID other = from->geom1 == w->object_geom ? from->geom2 : from->geom1;
    bool of_object = from->geom1 == w->object_geom || from->geom2 == w->object_geom;
    int index = geom_index(w, other);
    to->finger = of_object && index >= 0 ? w->categories[index] : -1;
    to->friction = c->model == PINCH_CONTACT_FRICTIONLESS ? 0 : c->friction[0];
    to->depth = c->depth;
    to->exact_torsion = sign * exact[3];
    to->torsion[0] = sign * from->torsion;
    scene_cross(c->normal, c->tangent1, t2);
    for (int i = 0; i < 3; i++) {
        to->position[i] = c->position[i];
        to->normal[i] = sign * c->normal[i];
        to->exact[i] = sign * (exact[0] * c->normal[i] + exact[1] * c->tangent1[i] + exact[2] * t2[i]);
        to->force[0][i] = sign * from->force[i];
    }
}

/* One island's contacts; places: theirs in the read-out. */
static sample_status solve_island(const world *w, const pinch_problem *problem, const int *places, sample *s,
                                  probe_contacts *ode)
{
    const pinch_ode_contact *list;
    int count;
    exact_answer answer;
    pinch_ode_contacts(w->plugin, &list, &count);
    for (int i = 0; i < problem->body_count; i++)
        if (isnan(problem->bodies[i].velocity_end[0])) return SAMPLE_NOT_SOLVED;
    exact_status status = exact_solve(problem, &answer);
    if (status == EXACT_NO_MEMORY) return SAMPLE_NO_MEMORY;
    if (status != EXACT_OK) return SAMPLE_NO_EXACT;
    s->residual = fmax(s->residual, answer.residual);
    for (int i = 0; i < problem->contact_count; i++) {
        int place = places[i];
        fill_contact(w, &problem->contacts[i], &list[place], answer.force + 4 * i, &s->contacts[place]);
        give_ode(&problem->contacts[i], &list[place], points_of_pair(list, count, &list[place]), &ode->contacts[place],
                 &ode->materials[place]);
    }
    exact_free(&answer);
    return SAMPLE_OK;
}

static sample_status solve_exactly(const world *w, sample *s, probe_contacts *ode)
{
    int *places = calloc((size_t)s->contact_count, sizeof *places);
    sample_status status = places ? SAMPLE_OK : SAMPLE_NO_MEMORY;
    for (int k = 0; k < pinch_ode_island_count(w->plugin) && status == SAMPLE_OK; k++) {
        pinch_problem problem;
        status = pinch_ode_read_island(w->plugin, k, &problem, places) == PINCH_OK
                     ? solve_island(w, &problem, places, s, ode)
                     : SAMPLE_NO_EXACT;
    }
    free(places);
    return status;
}

double sample_contact_error(const sample *s, const sample_contact *c, int run, double radius)
{
    double off[3];
    scene_subtract(c->force[run], c->exact, off);
    return hypot(scene_norm(off), (c->torsion[run] - c->exact_torsion) / radius) / s->scale;
}

static double largest_error(const sample *s, int run, double radius)
{
    double largest = 0;
    for (int k = 0; k < s->contact_count; k++) {
        double error = sample_contact_error(s, &s->contacts[k], run, radius);
        if (!(error <= largest)) largest = error;
    }
    return largest;
}

/* ODE's answer into a run's place of the contacts. */
static bool ask_ode(const world *w, const world_settings *settings, const probe_contacts *ode, int run, sample *s)
{
    double *force = calloc(3 * (size_t)ode->count + 1, sizeof *force);
    bool done = force && probe_step(w, settings, ode, force);
    for (int k = 0; k < ode->count && done; k++) {
        sample_contact *c = &s->contacts[k];
        double sign = ode->contacts[k].contact.geom.g2 == w->object_geom ? -1 : 1;
        for (int i = 0; i < 3; i++) c->force[run][i] = sign * force[3 * k + i];
        c->torsion[run] = 0;
    }
    free(force);
    return done;
}

static sample_status ask_all(const world *w, const world_settings *runs, int run_count, const probe_contacts *ode,
                             sample *s)
{
    double radius = w->scene->object.shape.bounding_radius;
    s->error[0] = largest_error(s, 0, radius);
    for (int run = 1; run < run_count; run++) {
        world_settings settings = runs[run];
        settings.manifolds = false; /* the points are given */
        if (!ask_ode(w, &settings, ode, run, s)) return SAMPLE_NO_MEMORY;
        s->error[run] = largest_error(s, run, radius);
    }
    for (int i = 0; i < SAMPLE_COUNTS && run_count > 1; i++) {
        world_settings settings = runs[0];
        settings.contact_solver = WORLD_QUICKSTEP;
        settings.quickstep_iterations = sample_counts[i];
        if (!ask_ode(w, &settings, ode, SAMPLE_RUNS - 1, s)) return SAMPLE_NO_MEMORY;
        s->count_error[i] = largest_error(s, SAMPLE_RUNS - 1, radius);
    }
    return SAMPLE_OK;
}

static void keep_poses(const world *w, sample *s)
{
    for (int i = 0; i <= w->finger_count && i <= SAMPLE_FINGERS; i++) {
        dBodyID body = i ? w->fingers[i - 1].body : w->object;
        memcpy(s->poses[i], dBodyGetPosition(body), 3 * sizeof(double));
        memcpy(s->poses[i] + 3, dBodyGetQuaternion(body), 4 * sizeof(double));
    }
}

static void measure_scale(const world *w, sample *s)
{
    double force[3], torque[3];
    world_external_wrench(w, force, torque);
    s->scale = fmax(scene_norm(force), scene_norm(torque) / w->scene->object.shape.bounding_radius);
    for (int k = 0; k < s->contact_count; k++) s->scale = fmax(s->scale, scene_norm(s->contacts[k].exact));
}

void sample_take(const world *w, const world_settings *runs, int run_count, sample *s)
{
    const pinch_ode_contact *list;
    probe_contacts ode = {0};
    pinch_ode_contacts(w->plugin, &list, &ode.count);
    s->time = (double)(w->steps + 1) * w->scene->step;
    s->contact_count = ode.count;
    s->status = SAMPLE_NO_CONTACT;
    keep_poses(w, s);
    if (ode.count == 0) return;
    s->contacts = calloc((size_t)ode.count, sizeof *s->contacts);
    ode.contacts = calloc((size_t)ode.count, sizeof *ode.contacts);
    ode.materials = calloc((size_t)ode.count, sizeof *ode.materials);
    s->status = s->contacts && ode.contacts && ode.materials ? solve_exactly(w, s, &ode) : SAMPLE_NO_MEMORY;
    if (s->status == SAMPLE_OK) {
        measure_scale(w, s);
        s->status = s->scale > 0 ? ask_all(w, runs, run_count, &ode, s) : SAMPLE_NO_CONTACT;
    }
    if (s->status != SAMPLE_OK) s->contact_count = 0;
    free(ode.contacts);
    free(ode.materials);
}

void sample_free(sample *s)
{
    free(s->contacts);
    s->contacts = NULL;
}
