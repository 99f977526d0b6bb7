/* pinch run: a scene in ODE, with Pinch or one of ODE's own solvers for the contacts. */
#include "command.h"

#include "common/output.h"
#include "common/process.h"
#include "common/vector.h"
#include "common/whole_file.h"
#include "scenes/grasp.h"
#include "scenes/world/simulation.h"
#include "view/gltf.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

/* ---- The JSON document. ---- */

static pinch_ode_stats stats_of(const world *w)
{
    pinch_ode_stats none = {.steps = 0};
    return w->plugin ? pinch_ode_statistics(w->plugin) : none;
}

static double per_step(const world *w, double seconds)
{
    return w->steps > 0 ? seconds / (double)w->steps * 1e6 : NAN;
}

static json_t *finger_document(const world_finger *finger)
{
    const world_finger_state *s = &finger->state;
    const scene_finger *f = finger->finger;
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i}", "name", f->name,
                     "state", pinch_contact_state_text(s->state), "normal_force", json_number(s->normal_force),
                     "tangential_force", json_numbers(s->tangential_force, 3), "torsional_moment",
                     json_number(s->torsional_moment), "force", json_numbers(s->force, 3), "moment",
                     json_numbers(s->moment, 3), "point", json_numbers(s->point, 3), "normal_displacement",
                     json_number(s->normal_force / f->stiffness.normal), "tangential_displacement",
                     json_numbers(s->elastic, 3), "slip", json_numbers(s->slip, 3), "slip_total",
                     json_number(s->slip_total), "slip_margin", json_number(world_slip_margin(finger)),
                     "peak_normal_force", json_number(s->peak_normal_force), "points", s->points);
}

static json_t *finger_documents(const world *w)
{
    json_t *list = json_array();
    for (int i = 0; i < w->finger_count; i++)
        if (json_array_append_new(list, finger_document(&w->fingers[i]))) {
            json_decref(list);
            return NULL;
        }
    return list;
}

static json_t *motion_document(const simulation_motion *m)
{
    return json_pack("{s:o, s:o, s:o}", "displacement", json_numbers(m->displacement, 3), "creep",
                     json_number(m->creep), "creep_angular", json_number(m->creep_angular));
}

static json_t *object_document(const world *w, const simulation_result *r)
{
    json_t *document =
        json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "position", json_numbers(dBodyGetPosition(w->object), 3),
                  "orientation", json_numbers(dBodyGetQuaternion(w->object), 4), "linear_velocity",
                  json_numbers(dBodyGetLinearVel(w->object), 3), "angular_velocity",
                  json_numbers(dBodyGetAngularVel(w->object), 3), "speed_max", json_number(r->speed_max),
                  "motion_in_hand", motion_document(&r->motion_in_hand));
    json_t *motion = motion_document(&r->motion);
    json_object_update(document, motion);
    json_decref(motion);
    return document;
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

/* In one word how the grasp went: the worst of its events. */
static const char *outcome_of(const simulation_result *r)
{
    static const char *const outcomes[EVENT_COUNT + 1] = {
        [EVENT_DROPPED] = "dropped", [EVENT_CRUSH] = "crushed", [EVENT_SLIP] = "slipped", [EVENT_COUNT] = "held"};
    static const simulation_event_type worst_first[] = {EVENT_DROPPED, EVENT_CRUSH, EVENT_SLIP};
    for (int k = 0; k < EVENT_COUNT; k++)
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

static json_t *run_document(const world *w, const simulation_result *r)
{
    pinch_ode_stats stats = stats_of(w);
    bool pinch = w->plugin != NULL;
    char hash[24];
    snprintf(hash, sizeof hash, "%016" PRIx64, world_hash(w));
    json_t *not_expressed = json_array();
    world_not_expressed(w, json_append_text, not_expressed);
    double islands = stats.islands > 0 ? (double)stats.islands : NAN;
    json_t *head = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:s, s:I, s:o, s:o, s:o, s:o}", "command", "run", "scene", w->scene->file, "status",
        pinch_solve_status_text(world_solve_status(w)), "contact_solver", world_solver_name(w->settings.contact_solver),
        "solver", pinch ? pinch_solver_name(w->settings.solver.solver) : world_solver_name(w->settings.contact_solver),
        "formulation", scene_formulation_name(w->scene->solver.formulation), "steps", (json_int_t)w->steps, "time_s",
        json_number(w->time), "step_us", json_number(per_step(w, w->step_s)), "collide_us",
        json_number(per_step(w, w->collide_s)), "solve_us", json_number(per_step(w, w->solve_s)));
    json_t *solve = json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "iterations_mean",
        pinch_number(pinch, (double)stats.iterations / islands), "iterations_max",
        pinch_count(pinch, stats.iterations_max), "unconverged_steps", pinch_count(pinch, stats.unconverged_steps),
        "retried_islands", pinch_count(pinch, stats.retried_islands), "fallback_islands",
        pinch_count(pinch, stats.fallback_islands), "residual_max", pinch_number(pinch, stats.residual_max),
        "step_mismatch", pinch_number(pinch, stats.step_mismatch), "step_mismatch_angular",
        pinch_number(pinch, stats.step_mismatch_angular));
    json_t *tail =
        json_pack("{s:b, s:s?, s:o, s:{s:o, s:o}, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:s}", "interrupted",
                  process_interrupted() != 0, "outcome", w->diverged ? NULL : outcome_of(r), "verification",
                  verification_document(&stats, pinch, world_solve_status(w) == PINCH_SOLVE_CONVERGED), "equilibrium",
                  "force_error", json_number(r->force_error), "torque_error", json_number(r->torque_error), "fingers",
                  finger_documents(w), "object", object_document(w, r), "max_penetration",
                  json_number(r->max_penetration), "energy", energy_document(w), "events", event_documents(w, r),
                  "statics", statics_document(w), "not_expressed", not_expressed, "hash", hash);
    bool failed = !head || !solve || !tail || json_object_update(head, solve) || json_object_update(head, tail);
    json_decref(solve);
    json_decref(tail);
    if (!failed) return head;
    json_decref(head);
    return NULL;
}

/* ---- The table that a person reads. ---- */

static void print_table(const world *w, const simulation_result *r, FILE *stream)
{
    pinch_ode_stats stats = stats_of(w);
    fprintf(stream, "%s: %g s in %ld steps, contacts by %s\n", w->scene->name, w->time, w->steps,
            world_solver_name(w->settings.contact_solver));
    fprintf(stream, "  %-12s %-6s %12s %12s %12s %12s %8s\n", "finger", "state", "normal N", "tangential N",
            "elastic um", "slip um", "margin");
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *f = &w->fingers[i];
        double margin = world_slip_margin(f);
        fprintf(stream, "  %-12s %-6s %12.6f %12.6f %12.4f %12.4f ", f->finger->name,
                pinch_contact_state_text(f->state.state), f->state.normal_force, scene_norm(f->state.tangential_force),
                1e6 * scene_norm(f->state.elastic), 1e6 * f->state.slip_total);
        if (isnan(margin))
            fprintf(stream, "%8s\n", "-");
        else
            fprintf(stream, "%8.4f\n", margin);
    }
    fprintf(stream, "  object moved %.6g mm, creep %.3g m/s and %.3g rad/s, fastest in the second half %.3g m/s\n",
            1e3 * scene_norm(r->motion.displacement), r->motion.creep, r->motion.creep_angular, r->speed_max);
    fprintf(stream, "  forces balance to %.2g N and %.2g N m", r->force_error, r->torque_error);
    if (w->plugin)
        fprintf(stream, "; verified: %s, residual %.2g, cone %.2g N, %ld unconverged steps, %.2f iterations a step",
                stats.fallback_islands ? "no" : "yes", stats.residual_max, stats.cone, stats.unconverged_steps,
                stats.islands ? (double)stats.iterations / (double)stats.islands : 0);
    if (w->plugin)
        fprintf(stream,
                "\n  energy: closes to %.2g J of %.3g J of work; %.3g J lost to friction, %.3g J to the time step",
                w->ledger.closure, w->ledger.work_size, w->ledger.friction, w->ledger.integrator);
    fprintf(stream, "\n  cost a step: %.2f us, and %.2f us for collision detection\n", per_step(w, w->step_s),
            per_step(w, w->collide_s));
    if (!w->diverged) fprintf(stream, "  outcome: %s\n", outcome_of(r));
    for (int i = 0; i < r->event_count; i++) {
        const simulation_event *e = &r->events[i];
        fprintf(stream, "  event at %g s: %s%s%s, value %g, limit %g\n", e->time, simulation_event_name(e->type),
                e->finger >= 0 ? " " : "", e->finger >= 0 ? w->fingers[e->finger].finger->name : "", e->value,
                e->limit);
    }
}

/* ---- The CSV file: a header line, then a row for each step. ---- */

static void put_vector(FILE *stream, const double *v, int count)
{
    for (int i = 0; i < count; i++) {
        char text[32];
        json_number_text(v[i], text);
        fprintf(stream, ",%s", text);
    }
}

static void write_csv_header(const world *w, FILE *stream)
{
    static const char *const columns[] = {".fx", ".fy", ".fz", ".slip_x", ".slip_y", ".slip_z", ".state"};
    fputs("time,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz", stream);
    for (int i = 0; i < w->finger_count; i++) {
        for (size_t k = 0; k < sizeof columns / sizeof *columns; k++) {
            fputc(',', stream);
            csv_text(w->fingers[i].finger->name, columns[k], stream);
        }
    }
    fputc('\n', stream);
}

static void write_csv_row(const world *w, FILE *stream)
{
    char text[32];
    json_number_text(w->time, text);
    fputs(text, stream);
    put_vector(stream, dBodyGetPosition(w->object), 3);
    put_vector(stream, dBodyGetQuaternion(w->object), 4);
    put_vector(stream, dBodyGetLinearVel(w->object), 3);
    put_vector(stream, dBodyGetAngularVel(w->object), 3);
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger_state *s = &w->fingers[i].state;
        put_vector(stream, s->force, 3);
        put_vector(stream, s->slip, 3);
        fprintf(stream, ",%s", pinch_contact_state_text(s->state));
    }
    fputc('\n', stream);
}

/* ---- The run. ---- */

static world_settings settings_from(const options *o, const scene *s)
{
    world_settings settings = world_default_settings(s);
    settings.contact_solver = o->contact_solver;
    if (o->given[OPTION_SEED]) settings.solver.seed = o->seed;
    if (o->no_newton) settings.solver.newton_finish = false;
    return settings;
}

enum { RECORD_PATH = 4096 };

/* Has the world record islands where that was asked for. */
static command_status prepare_record(const options *o, world_settings *settings, pinch_ode_record_folder *record,
                                     char path[RECORD_PATH])
{
    if (!o->given[OPTION_RECORD]) return COMMAND_DONE;
    settings->recorder = pinch_ode_record_into_folder;
    settings->recorder_context = record;
    settings->record_all = o->record_all;
    return command_make_folder("run", o->record, path, RECORD_PATH);
}

/* The files that a run writes. One that is not asked for has no stream. */
typedef struct run_files {
    whole_file csv, gltf;
} run_files;

static bool open_file(whole_file *file, const char *path)
{
    if (!path || whole_file_open(file, path)) return true;
    command_error("run", "%s: cannot be written", path);
    return false;
}

static bool close_file(whole_file *file, const char *path, bool keep)
{
    if (!file->stream || whole_file_close(file, keep)) return true;
    command_error("run", "%s: cannot be written", path);
    return false;
}

/* Steps the world through its duration, or until a signal interrupts it. Where `csv` is open, every step writes a row.
 * Where there is a film, it takes its frames. */
static world_status simulate(world *w, FILE *csv, film *pictures, simulation_result *result)
{
    simulation *s = simulation_start(w);
    if (!s) return WORLD_NO_MEMORY;
    world_status status = WORLD_OK;
    for (long k = 0; k < simulation_steps(s) && status == WORLD_OK && !(csv && ferror(csv)); k++) {
        if (process_interrupted()) break;
        status = simulation_step(s);
        if (csv && status == WORLD_OK) write_csv_row(w, csv);
        if (pictures && status == WORLD_OK && !film_step(pictures, w)) status = WORLD_NO_MEMORY;
    }
    simulation_finish(s, result);
    if (pictures && status != WORLD_NO_MEMORY && !film_finish(pictures, w)) status = WORLD_NO_MEMORY;
    return status;
}

static world_status simulate_into(const options *o, world *w, const run_files *files, simulation_result *result)
{
    film *pictures = o->gltf ? film_start(w, o->fps) : NULL;
    if (o->gltf && !pictures) return WORLD_NO_MEMORY;
    if (o->csv) write_csv_header(w, files->csv.stream);
    world_status status = simulate(w, files->csv.stream, pictures, result);
    if (status != WORLD_NO_MEMORY && o->gltf && !gltf_write(pictures, files->gltf.stream)) status = WORLD_NO_MEMORY;
    film_free(pictures);
    return status;
}

/* A file that could not be completed is not left behind. */
static command_status simulate_and_record(const options *o, world *w, simulation_result *result)
{
    run_files files = {.csv = {.stream = NULL}};
    world_status status = WORLD_NO_MEMORY;
    bool written = open_file(&files.csv, o->csv) && open_file(&files.gltf, o->gltf);
    if (written) {
        status = simulate_into(o, w, &files, result);
        if (status == WORLD_NO_MEMORY) command_error("run", "out of memory");
    }
    written = close_file(&files.csv, o->csv, status != WORLD_NO_MEMORY) && written;
    written = close_file(&files.gltf, o->gltf, status != WORLD_NO_MEMORY) && written;
    return written && status != WORLD_NO_MEMORY ? COMMAND_DONE : COMMAND_SYSTEM;
}

static command_status present(const options *o, const world *w, const simulation_result *result)
{
    if (o->json) {
        if (!json_print_new(run_document(w, result), stdout)) {
            command_error("run", "out of memory");
            return COMMAND_SYSTEM;
        }
    } else if (!o->quiet) {
        print_table(w, result, stdout);
    }
    if (process_interrupted()) {
        command_error("run", "%s: interrupted at %g s of %g s", w->scene->file, w->time, w->scene->duration);
        return (command_status)(COMMAND_INTERRUPTED + process_interrupted());
    }
    for (int i = 0; i < result->event_count; i++)
        if (o->fail_on & 1u << result->events[i].type) return COMMAND_FAILED;
    return world_solve_status(w) == PINCH_SOLVE_CONVERGED ? COMMAND_DONE : COMMAND_FAILED;
}

static command_status run_scene(const options *o, const scene *s)
{
    char error[256];
    world *w;
    simulation_result result = {.events = NULL};
    char folder[RECORD_PATH];
    pinch_ode_record_folder record = {.path = folder, .most = COMMAND_MOST_RECORDINGS};
    world_settings settings = settings_from(o, s);
    command_status status = prepare_record(o, &settings, &record, folder);
    if (status != COMMAND_DONE) return status;
    process_keep_signals();
    dInitODE2(0);
    status = COMMAND_SYSTEM;
    switch (world_create(s, &settings, &w, error)) {
    case WORLD_OK:
        status = simulate_and_record(o, w, &result);
        if (status == COMMAND_DONE) status = present(o, w, &result);
        simulation_free(&result);
        world_free(w);
        if (record.failed) {
            command_error("run", "%s: an island could not be written", folder);
            status = COMMAND_SYSTEM;
        }
        break;
    default:
        command_error("run", "%s", error);
    }
    world_close_ode();
    return status;
}

static command_status run_run(const options *o)
{
    scene *s;
    command_status status = command_load_scene(o, o->arguments[0], &s);
    if (status != COMMAND_DONE) return status;
    if (o->contact_solver == WORLD_PINCH) status = command_check_run("run", s);
    if (status == COMMAND_DONE) status = run_scene(o, s);
    scene_free(s);
    return status;
}

static const option_id run_options[] = {
    OPTION_SOLVER, OPTION_FORMULATION, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_FACES,
    OPTION_SEED,   OPTION_NO_NEWTON,   OPTION_DURATION,  OPTION_STEP,           OPTION_CONTACT_SOLVER,
    OPTION_JSON,   OPTION_CSV,         OPTION_FAIL_ON,   OPTION_RECORD,         OPTION_RECORD_ALL,
    OPTION_GLTF,   OPTION_FPS,         OPTION_QUIET,     OPTION_COUNT,
};

const command command_run = {
    .name = "run",
    .arguments = "SCENE",
    .summary = "simulates a scene in ODE with Pinch as contact solver",
    .min_arguments = 1,
    .max_arguments = 1,
    .options = run_options,
    .run = run_run,
};
