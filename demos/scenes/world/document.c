/* A run as a JSON document. */
#include "simulation.h"

#include "world_hand.h"

#include "common/output.h"
#include "common/process.h"
#include "common/vector.h"
#include "scenes/grasp.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

static pinch_ode_stats stats_of(const world *w)
{
    pinch_ode_stats none = {.steps = 0};
    return w->plugin ? pinch_ode_statistics(w->plugin) : none;
}

static json_t *finger_document(const world *w, const world_finger *finger)
{
    const world_finger_state *s = &finger->state;
    const scene_finger *f = finger->finger;
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i}", "name",
                     f->name, "state", pinch_contact_state_text(s->state), "normal_force", json_number(s->normal_force),
                     "tangential_force", json_numbers(s->tangential_force, 3), "torsional_moment",
                     json_number(s->torsional_moment), "force", json_numbers(s->force, 3), "moment",
                     json_numbers(s->moment, 3), "point", json_numbers(s->point, 3), "normal_displacement",
                     json_number(world_normal_displacement(w, finger)), "tangential_displacement",
                     json_numbers(s->elastic, 3), "slip", json_numbers(s->slip, 3), "slip_total",
                     json_number(s->slip_total), "slip_margin", json_number(world_slip_margin(w, finger)),
                     "least_margin", json_number(world_least_margin(w, finger)), "peak_normal_force",
                     json_number(s->peak_normal_force), "points", s->points);
}

static json_t *finger_documents(const world *w)
{
    json_t *list = json_array();
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *finger = &w->fingers[i];
        if (!world_finger_is_shown(finger)) continue;
        json_t *document = finger_document(w, finger);
        if (document && w->object_count > 1)
            json_object_set_new(document, "object", json_string(w->scene->objects[finger->object].name));
        if (json_array_append_new(list, document)) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *motion_document(const simulation_motion *m)
{
    return json_pack("{s:o, s:o, s:o}", "displacement", json_numbers(m->displacement, 3), "creep",
                     json_number(m->creep), "creep_angular", json_number(m->creep_angular));
}

static json_t *object_document(const world *w, const simulation_result *r, int object)
{
    dBodyID body = w->objects[object].body;
    const simulation_object *o = &r->objects[object];
    json_t *document = json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "position", json_numbers(dBodyGetPosition(body), 3),
                                 "orientation", json_numbers(dBodyGetQuaternion(body), 4), "linear_velocity",
                                 json_numbers(dBodyGetLinearVel(body), 3), "angular_velocity",
                                 json_numbers(dBodyGetAngularVel(body), 3), "speed_max", json_number(o->speed_max),
                                 "motion_in_hand", motion_document(&o->motion_in_hand));
    json_t *motion = motion_document(&o->motion);
    json_object_update(document, motion);
    json_decref(motion);
    return document;
}

/* Of several objects all, each with its name. */
static json_t *object_documents(const world *w, const simulation_result *r)
{
    json_t *list = json_array();
    for (int k = 0; k < w->object_count; k++) {
        json_t *document = object_document(w, r, k);
        json_object_set_new(document, "name", json_string(w->scene->objects[k].name));
        (void)json_array_append_new(list, document);
    }
    return list;
}

static json_t *event_documents(const world *w, const simulation_result *r)
{
    json_t *list = json_array();
    for (int i = 0; i < r->event_count; i++) {
        const simulation_event *e = &r->events[i];
        json_t *finger = e->finger >= 0 ? json_string(w->fingers[e->finger].finger->name) : json_null();
        json_t *event =
            json_pack("{s:o, s:o, s:s, s:o, s:o}", "time", json_number(e->time), "finger", finger, "type",
                      simulation_event_name(e->type), "value", json_number(e->value), "limit", json_number(e->limit));
        if (event && e->type == EVENT_LIMIT)
            json_object_set_new(event, "joint", json_string(w->hands[e->hand].joints[e->joint].name));
        if (event && e->type == EVENT_DROPPED && w->object_count > 1)
            json_object_set_new(event, "object", json_string(w->scene->objects[e->object].name));
        if (json_array_append_new(list, event)) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t *verification_document(const pinch_ode_stats *stats, bool pinch, bool passed)
{
    if (!pinch) return json_pack("{s:n, s:n, s:n, s:n}", "passed", "cone", "complementarity", "slip_direction");
    return json_pack("{s:o, s:o, s:o, s:o}", "passed", stats->steps > 0 ? json_boolean(passed) : json_null(), "cone",
                     json_number(stats->cone), "complementarity", json_number(stats->complementarity), "slip_direction",
                     json_number(stats->slip_direction));
}

/* A number that only Pinch has; null for ODE's own solvers. */
static json_t *pinch_number(bool pinch, double value)
{
    return json_number(pinch ? value : NAN);
}

static json_t *pinch_count(bool pinch, long value)
{
    return pinch ? json_integer(value) : json_null();
}

static json_t *energy_document(const world *w)
{
    const energy_ledger *l = &w->ledger;
    bool pinch = w->plugin != NULL;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "kinetic", pinch_number(pinch, l->kinetic),
                     "gravity", pinch_number(pinch, l->gravity), "elastic", pinch_number(pinch, l->elastic),
                     "work_drives", pinch_number(pinch, l->work_drives), "work_external",
                     pinch_number(pinch, l->work_external), "friction", pinch_number(pinch, l->friction), "damping",
                     pinch_number(pinch, l->damping), "integrator", pinch_number(pinch, l->integrator), "closure",
                     pinch_number(pinch, l->closure), "work_size", pinch_number(pinch, l->work_size));
}

const char *simulation_outcome(const simulation_result *r)
{
    static const char *const outcomes[EVENT_COUNT + 1] = {
        [EVENT_DROPPED] = "dropped", [EVENT_CRUSH] = "crushed", [EVENT_SLIP] = "slipped", [EVENT_COUNT] = "held"};
    static const simulation_event_type worst_first[] = {EVENT_DROPPED, EVENT_CRUSH, EVENT_SLIP};
    for (size_t k = 0; k < sizeof worst_first / sizeof *worst_first; k++)
        for (int i = 0; i < r->event_count; i++)
            if (r->events[i].type == worst_first[k]) return outcomes[worst_first[k]];
    return outcomes[EVENT_COUNT];
}

/* The largest difference between a finger's force in the run and in the statics, N. */
static double statics_difference(const world *w, const pinch_finger_result *results)
{
    double largest = 0;
    for (int i = 0; i < w->finger_count; i++) {
        double d[3];
        scene_subtract(w->fingers[i].state.force, results[i].force, d);
        largest = fmax(largest, scene_norm(d));
    }
    return largest;
}

static json_t *solve_statics(const world *w, pinch_statics *statics, pinch_finger *fingers,
                             pinch_finger_result *results)
{
    pinch_grasp grasp;
    pinch_statics_result r;
    pinch_statics_settings settings = pinch_default_statics_settings();
    json_t *list = json_array();
    scene_static_grasp_at(w->scene, w->time, fingers, &grasp);
    if (pinch_statics_solve(statics, &grasp, &settings, results, &r) != PINCH_OK) {
        json_decref(list);
        return json_null();
    }
    bool solved = r.solve.status == PINCH_SOLVE_CONVERGED;
    for (int i = 0; i < w->finger_count; i++)
        (void)json_array_append_new(list, json_pack("{s:s, s:o, s:o}", "name", w->fingers[i].finger->name,
                                                    "normal_force", json_number(results[i].r[0]), "force",
                                                    json_numbers(results[i].force, 3)));
    return json_pack("{s:s, s:o, s:o, s:o}", "status", pinch_solve_status_text(r.solve.status), "moment_s",
                     json_number(w->time), "fingers", list, "difference",
                     json_number(solved ? statics_difference(w, results) : NAN));
}

/* What the statics say of the moment at which the run has ended, as `pinch solve --time` does. Null where a path has
 * moved a finger, so that the grasp is another one. */
static json_t *statics_document(const world *w)
{
    if (w->hand_count > 0) return json_null();
    if (w->diverged || scene_finger_on_path(w->scene, w->time)) return json_null();
    pinch_statics *statics;
    if (pinch_statics_create(w->finger_count, 0, &statics) != PINCH_OK) return NULL;
    pinch_finger *fingers = calloc((size_t)w->finger_count, sizeof *fingers);
    pinch_finger_result *results = calloc((size_t)w->finger_count, sizeof *results);
    json_t *document = fingers && results ? solve_statics(w, statics, fingers, results) : NULL;
    free(fingers);
    free(results);
    pinch_statics_destroy(statics);
    return document;
}

static bool add_hands(json_t *document, const world *w, const simulation_result *r)
{
    json_t *equilibrium = json_object_get(document, "equilibrium");
    return !json_object_set_new(document, "joints", world_joint_documents(w)) &&
           !json_object_set_new(document, "ties", world_tie_documents(w)) &&
           !json_object_set_new(equilibrium, "joint_error", json_number(r->joint_error)) &&
           !json_object_set_new(equilibrium, "loop_gap", json_number(r->loop_gap));
}

json_t *simulation_document(const world *w, const simulation_result *r, bool with_statics)
{
    pinch_ode_stats stats = stats_of(w);
    bool pinch = w->plugin != NULL;
    char hash[24];
    snprintf(hash, sizeof hash, "%016" PRIx64, world_hash(w));
    json_t *not_expressed = json_array();
    world_not_expressed(w, json_append_text, not_expressed);
    json_t *remarks = json_array();
    simulation_remarks(w, r, json_append_text, remarks);
    double islands = stats.islands > 0 ? (double)stats.islands : NAN;
    json_t *head = json_pack(
        "{s:s, s:o, s:s, s:s, s:s, s:s, s:I, s:o, s:o, s:o, s:o}", "command", "run", "scene", json_text(w->scene->file),
        "status", pinch_solve_status_text(world_solve_status(w)), "contact_solver",
        world_solver_name(w->settings.contact_solver), "solver",
        pinch ? pinch_solver_name(w->settings.solver.solver) : world_solver_name(w->settings.contact_solver),
        "formulation", scene_formulation_name(w->scene->solver.formulation), "steps", (json_int_t)w->steps, "time_s",
        json_number(w->time), "step_us", json_number(world_us_a_step(w, w->step_s)), "collide_us",
        json_number(world_us_a_step(w, w->collide_s)), "solve_us", json_number(world_us_a_step(w, w->solve_s)));
    json_t *solve = json_pack(
        "{s:o, s:{s:o, s:o, s:o, s:o}, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "iterations_mean",
        pinch_number(pinch, (double)stats.iterations / islands), "islands_by", "projections",
        pinch_count(pinch, stats.islands_by_projections), "newton", pinch_count(pinch, stats.islands_by_newton), "flow",
        pinch_count(pinch, stats.islands_by_flow), "lcp", pinch_count(pinch, stats.islands_by_lcp), "iterations_max",
        pinch_count(pinch, stats.iterations_max), "unconverged_steps", pinch_count(pinch, stats.unconverged_steps),
        "retried_islands", pinch_count(pinch, stats.retried_islands), "fallback_islands",
        pinch_count(pinch, stats.fallback_islands), "too_soft_islands", pinch_count(pinch, stats.too_soft_islands),
        "floor_residual_max", pinch_number(pinch, stats.floor_residual_max), "residual_max",
        pinch_number(pinch, stats.residual_max), "step_mismatch", pinch_number(pinch, stats.step_mismatch),
        "step_mismatch_angular", pinch_number(pinch, stats.step_mismatch_angular));
    json_t *tail = json_pack(
        "{s:b, s:s?, s:b, s:o, s:{s:o, s:o}, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:s}", "interrupted",
        process_interrupted() != 0, "outcome", w->diverged ? NULL : simulation_outcome(r), "touched", r->touched,
        "verification", verification_document(&stats, pinch, world_solve_status(w) == PINCH_SOLVE_CONVERGED),
        "equilibrium", "force_error", json_number(r->force_error), "torque_error", json_number(r->torque_error),
        "fingers", finger_documents(w), "object", object_document(w, r, 0), "max_penetration",
        json_number(r->max_penetration), "energy", energy_document(w), "events", event_documents(w, r), "statics",
        with_statics ? statics_document(w) : json_null(), "not_expressed", not_expressed, "remarks", remarks, "hash",
        hash);
    bool failed = !head || !solve || !tail || json_object_update(head, solve) || json_object_update(head, tail);
    if (!failed && w->object_count > 1) json_object_set_new(head, "objects", object_documents(w, r));
    if (!failed && w->hand_count > 0) failed = !add_hands(head, w, r);
    json_decref(solve);
    json_decref(tail);
    if (!failed) return head;
    json_decref(head);
    return NULL;
}
