#include "sample.h"

#include "common/vector.h"
#include "exact/exact.h"
#include "scenes/world/world_hand.h"

#include <stdlib.h>
#include <string.h>

/* ---- Which steps are sampled. ---- */

const char *sample_reason_text(sample_reason reason)
{
    static const char *const texts[] = {"even", "state change", "load change"};
    return texts[reason];
}

bool step_chooser_start(step_chooser *c, const world *w, long steps)
{
    size_t n = (size_t)steps + 1, fingers = (size_t)w->finger_count;
    memset(c, 0, sizeof *c);
    c->w = w;
    c->steps = steps;
    c->change = calloc(n, sizeof *c->change);
    c->state_changed = calloc(n, sizeof *c->state_changed);
    c->last = calloc(3 * fingers, sizeof *c->last);
    c->state = calloc(fingers, sizeof *c->state);
    return c->change && c->state_changed && c->last && c->state;
}

void step_chooser_free(step_chooser *c)
{
    free(c->change);
    free(c->state_changed);
    free(c->last);
    free(c->state);
}

void step_chooser_after_step(step_chooser *c)
{
    long step = c->w->steps;
    for (int f = 0; f < c->w->finger_count; f++) {
        const world_finger_state *s = &c->w->fingers[f].state;
        double change[3];
        scene_subtract(s->force, c->last + 3 * f, change);
        c->change[step - 1] += scene_norm(change);
        if (step > 1 && s->state != c->state[f]) c->state_changed[step - 1] = true;
        scene_copy(s->force, c->last + 3 * f);
        c->state[f] = s->state;
    }
}

static bool near_one(const chosen_step *chosen, int count, long step, long gap)
{
    for (int i = 0; i < count; i++)
        if (labs(chosen[i].step - step) <= gap) return true;
    return false;
}

static int by_step(const void *a, const void *b)
{
    long x = ((const chosen_step *)a)->step, y = ((const chosen_step *)b)->step;
    return (x > y) - (x < y);
}

int step_chooser_choose(const step_chooser *c, int most, chosen_step *chosen)
{
    int count = 0, even = (most + 1) / 2, with_changes = even + (most - even) / 2;
    long gap = c->steps / (8L * most + 1);
    for (int i = 1; i <= even; i++) { /* the last of them is the run's last step */
        long step = (c->steps * i + even - 1) / even;
        if (step >= 1 && !near_one(chosen, count, step, 0)) chosen[count++] = (chosen_step){step, SAMPLE_EVEN};
    }
    for (long step = 1; step <= c->steps && count < with_changes; step++)
        if (c->state_changed[step - 1] && !near_one(chosen, count, step, gap))
            chosen[count++] = (chosen_step){step, SAMPLE_STATE_CHANGE};
    while (count < most) {
        long best = 0;
        for (long step = 1; step <= c->steps; step++)
            if (c->change[step - 1] > (best ? c->change[best - 1] : 0) && !near_one(chosen, count, step, gap))
                best = step;
        if (!best) break;
        chosen[count++] = (chosen_step){best, SAMPLE_LOAD_CHANGE};
    }
    qsort(chosen, (size_t)count, sizeof *chosen, by_step);
    return count;
}

/* ---- One step by one of ODE's own solvers. ---- */

/* What one of ODE's own solvers makes of a step of Pinch's run. A world of its own gets the bodies' state of that step
 * and its contact points with their stiffness, damping and friction, and makes the one step. What ODE's contacts cannot
 * express (tangential stiffness, torsion, force limits) is lost, and a slider stands in for force control. */

/* The contact points of a step as ODE contacts of the geoms and bodies of Pinch's world. */
typedef struct ode_contact_list {
    int count;
    world_contact *contacts;
    pinch_material *materials; /* one per contact */
} ode_contact_list;

static void copy_body(dBodyID from, dBodyID to)
{
    const double *x = dBodyGetPosition(from), *v = dBodyGetLinearVel(from), *w = dBodyGetAngularVel(from);
    dBodySetPosition(to, x[0], x[1], x[2]);
    dBodySetQuaternion(to, dBodyGetQuaternion(from));
    dBodySetLinearVel(to, v[0], v[1], v[2]);
    dBodySetAngularVel(to, w[0], w[1], w[2]);
}

static void copy_state(const world *from, world *to)
{
    for (int i = 0; i < from->object_count; i++) copy_body(from->objects[i].body, to->objects[i].body);
    for (int i = 0; i < from->finger_count; i++) {
        copy_body(from->fingers[i].body, to->fingers[i].body);
        if (from->fingers[i].rail && to->fingers[i].rail) copy_body(from->fingers[i].rail, to->fingers[i].rail);
    }
    for (int k = 0; k < from->hand_count; k++) {
        copy_body(from->hands[k].base, to->hands[k].base);
        for (int i = 0; i < from->hands[k].joint_count; i++)
            copy_body(from->hands[k].joints[i].body, to->hands[k].joints[i].body);
    }
    to->steps = from->steps;
    to->time = from->time;
}

static dBodyID body_in(const world *from, const world *to, dBodyID body)
{
    for (int i = 0; i < from->object_count; i++)
        if (from->objects[i].body == body) return to->objects[i].body;
    for (int i = 0; i < from->finger_count; i++)
        if (from->fingers[i].body == body) return to->fingers[i].body;
    for (int k = 0; k < from->hand_count; k++)
        for (int i = 0; i < from->hands[k].joint_count; i++)
            if (from->hands[k].joints[i].body == body) return to->hands[k].joints[i].body;
    return NULL;
}

static dGeomID geom_in(const world *from, const world *to, dGeomID geom)
{
    for (int i = 0; i < from->geom_count; i++)
        if (from->geoms[i] == geom) return to->geoms[i];
    int object = world_object_of(from, geom);
    return to->objects[object < 0 ? 0 : object].geom;
}

/* Hands the same contacts to the other world, in terms of its own bodies. */
static bool hand_over_contacts(const world *from, world *to, const ode_contact_list *contacts)
{
    world_contact *list = calloc((size_t)contacts->count + 1, sizeof *list);
    if (!list) return false;
    for (int k = 0; k < contacts->count; k++) {
        world_contact *c = &list[k];
        *c = contacts->contacts[k];
        c->material = &contacts->materials[k];
        c->contact.geom.g1 = geom_in(from, to, c->contact.geom.g1);
        c->contact.geom.g2 = geom_in(from, to, c->contact.geom.g2);
        for (int side = 0; side < 2; side++) c->body[side] = body_in(from, to, c->body[side]);
    }
    bool given = world_give_contacts(to, list, contacts->count);
    free(list);
    return given;
}

/* Makes the step. `settings` has the solver and its iterations; `w` is in the step, before anything has moved
 * (world.observe). `force` gets 3 numbers per contact, on its body 1, in N; NaN where the step could not be made.
 * Returns false when memory runs out. */
static bool make_ode_step(const world *w, const world_settings *settings, const ode_contact_list *contacts,
                          double *force)
{
    char error[256];
    world *probe;
    if (world_create(w->scene, settings, &probe, error) != WORLD_OK) return false;
    copy_state(w, probe);
    dRandSetSeed(0);
    bool given = hand_over_contacts(w, probe, contacts);
    world_status status = given ? world_advance(probe) : WORLD_NO_MEMORY;
    for (int k = 0; k < contacts->count; k++) {
        const world_contact *c = &probe->contacts[k];
        for (int i = 0; i < 3; i++) /* attached as (0, body), ODE writes the force on the body first */
            force[3 * k + i] = status == WORLD_OK ? (c->body[0] ? 1 : -1) * c->feedback.f1[i] : NAN;
    }
    world_free(probe);
    return given && status != WORLD_NO_MEMORY;
}

/* ---- A sampled step. ---- */

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

/* One contact of the problem as ODE's solvers get it, with its own stiffness, damping and friction. */
static void ode_contact_of(const pinch_contact *c, const pinch_ode_contact *from, int sharing, world_contact *to,
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

/* The contact itself, with the exact force and Pinch's force. */
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

/* Solves one island exactly. `places` says where its contacts stand in the read-out. */
static sample_status solve_island(const world *w, const pinch_problem *problem, const int *places, sample *s,
                                  ode_contact_list *ode)
{
    const pinch_ode_contact *list;
    int count;
    exact_answer answer;
    pinch_ode_contacts(w->plugin, &list, &count);
    exact_status status = exact_solve(problem, &answer);
    if (status == EXACT_NO_MEMORY) return SAMPLE_NO_MEMORY;
    if (status != EXACT_OK) return SAMPLE_NO_EXACT;
    s->residual = fmax(s->residual, answer.residual);
    for (int i = 0; i < problem->contact_count; i++) {
        int place = places[i];
        fill_contact(w, &problem->contacts[i], &list[place], answer.force + 4 * i, &s->contacts[place]);
        ode_contact_of(&problem->contacts[i], &list[place], points_of_pair(list, count, &list[place]),
                       &ode->contacts[place], &ode->materials[place]);
    }
    exact_free(&answer);
    return SAMPLE_OK;
}

/* Tells whether Pinch has an answer for the island. One that is reused was solved in an earlier step. */
static bool is_solved(const world *w, int island)
{
    pinch_ode_outcome outcome;
    return pinch_ode_read_outcome(w->plugin, island, &outcome) == PINCH_OK && outcome.solved;
}

static sample_status solve_exactly(const world *w, sample *s, ode_contact_list *ode)
{
    int *places = calloc((size_t)s->contact_count, sizeof *places);
    sample_status status = places ? SAMPLE_OK : SAMPLE_NO_MEMORY;
    for (int k = 0; k < pinch_ode_island_count(w->plugin) && status == SAMPLE_OK; k++) {
        pinch_problem problem;
        if (!is_solved(w, k)) {
            status = SAMPLE_NOT_SOLVED;
            break;
        }
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

/* Writes the forces of one of ODE's solvers into the run's place of the contacts. */
static bool solve_by_ode(const world *w, const world_settings *settings, const ode_contact_list *ode, int run,
                         sample *s)
{
    double *force = calloc(3 * (size_t)ode->count + 1, sizeof *force);
    bool done = force && make_ode_step(w, settings, ode, force);
    for (int k = 0; k < ode->count && done; k++) {
        sample_contact *c = &s->contacts[k];
        double sign = ode->contacts[k].contact.geom.g2 == w->object_geom ? -1 : 1;
        for (int i = 0; i < 3; i++) c->force[run][i] = sign * force[3 * k + i];
        c->torsion[run] = 0;
    }
    free(force);
    return done;
}

static sample_status solve_by_all(const world *w, const world_settings *runs, int run_count,
                                  const ode_contact_list *ode, sample *s)
{
    double radius = w->scene->objects[0].shape.bounding_radius;
    s->error[0] = largest_error(s, 0, radius);
    for (int run = 1; run < run_count; run++) {
        world_settings settings = runs[run];
        settings.manifolds = false; /* the points are given to it */
        if (!solve_by_ode(w, &settings, ode, run, s)) return SAMPLE_NO_MEMORY;
        s->error[run] = largest_error(s, run, radius);
    }
    for (int i = 0; i < SAMPLE_COUNTS && run_count > 1; i++) {
        world_settings settings = runs[0];
        settings.contact_solver = WORLD_QUICKSTEP;
        settings.quickstep_iterations = sample_counts[i];
        if (!solve_by_ode(w, &settings, ode, SAMPLE_RUNS - 1, s)) return SAMPLE_NO_MEMORY;
        s->count_error[i] = largest_error(s, SAMPLE_RUNS - 1, radius);
    }
    return SAMPLE_OK;
}

static void record_poses(const world *w, sample *s)
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
    world_external_wrench(w, 0, force, torque);
    s->scale = fmax(scene_norm(force), scene_norm(torque) / w->scene->objects[0].shape.bounding_radius);
    for (int k = 0; k < s->contact_count; k++) s->scale = fmax(s->scale, scene_norm(s->contacts[k].exact));
}

void sample_take(const world *w, const world_settings *runs, int run_count, sample *s)
{
    const pinch_ode_contact *list;
    ode_contact_list ode = {0};
    pinch_ode_contacts(w->plugin, &list, &ode.count);
    s->time = (double)(w->steps + 1) * w->scene->step;
    s->contact_count = ode.count;
    s->status = SAMPLE_NO_CONTACT;
    record_poses(w, s);
    if (ode.count == 0) return;
    s->contacts = calloc((size_t)ode.count, sizeof *s->contacts);
    ode.contacts = calloc((size_t)ode.count, sizeof *ode.contacts);
    ode.materials = calloc((size_t)ode.count, sizeof *ode.materials);
    s->status = s->contacts && ode.contacts && ode.materials ? solve_exactly(w, s, &ode) : SAMPLE_NO_MEMORY;
    if (s->status == SAMPLE_OK) {
        measure_scale(w, s);
        s->status = s->scale > 0 ? solve_by_all(w, runs, run_count, &ode, s) : SAMPLE_NO_CONTACT;
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
