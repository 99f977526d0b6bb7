/* pinch run: a scene in ODE, with Pinch or one of ODE's own solvers for the contacts. */
#include "pinch_run.h"
#include "command.h"

#include "common/output.h"
#include "common/process.h"
#include "common/progress.h"
#include "common/terminal.h"
#include "common/vector.h"
#include "common/whole_file.h"
#include "hands/hand.h"
#include "scenes/world/simulation.h"
#include "scenes/world/world_hand.h"
#include "view/gltf.h"
#include "view/page.h"

#include <math.h>

/* ---- The table that a person reads. ---- */

static pinch_ode_stats stats_of(const world *w)
{
    pinch_ode_stats none = {.steps = 0};
    return w->plugin ? pinch_ode_statistics(w->plugin) : none;
}

/* An object that a hand carries should rest in the hand, and not in the world. */
static void print_motion_in_hand(const simulation_result *r, FILE *stream)
{
    const simulation_motion *m = &r->motion_in_hand;
    char n[3][48];
    const double apart[] = {scene_norm(m->displacement) - scene_norm(r->motion.displacement),
                            m->creep - r->motion.creep, m->creep_angular - r->motion.creep_angular};
    /* beyond the rounding of going into the hand's frame and back */
    if (!(fabs(apart[0]) > 1e-12 || fabs(apart[1]) > 1e-12 || fabs(apart[2]) > 1e-12)) return;
    terminal_print(stream, "  in the hand it moved %s mm, creep %s m/s and %s rad/s\n",
                   number_for_people("%.6g", 1e3 * scene_norm(m->displacement), n[0]),
                   number_for_people("%.3g", m->creep, n[1]), number_for_people("%.3g", m->creep_angular, n[2]));
}

static void print_energy(const world *w, FILE *stream)
{
    const energy_ledger *l = &w->ledger;
    char n[4][48], remark[SIMULATION_REMARK];
    terminal_print(stream, "\n  energy: closes to %s J of %s J of work; %s J lost to friction, %s J to the time step",
                   number_for_people("%.2g", l->closure, n[0]), number_for_people("%.3g", l->work_size, n[1]),
                   number_for_people("%.3g", l->friction, n[2]), number_for_people("%.3g", l->integrator, n[3]));
    if (simulation_energy_remark(w, remark)) terminal_print(stream, "\n  %s", remark);
}

static void print_table(const world *w, const simulation_result *r, FILE *stream)
{
    pinch_ode_stats stats = stats_of(w);
    terminal_print(stream, "%s: %g s in %ld steps, contacts by %s\n", w->scene->name, w->time, w->steps,
                   world_solver_name(w->settings.contact_solver));
    terminal_print(stream, "  %-12s %-6s %12s %12s %12s %12s %8s\n", "finger", "state", "normal N", "tangential N",
                   "elastic um", "slip um", "margin");
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *f = &w->fingers[i];
        if (!world_finger_is_shown(f)) continue;
        char margin[48];
        terminal_print(stream, "  %-12s %-6s %12.6f %12.6f %12.4f %12.4f ", f->finger->name,
                       pinch_contact_state_text(f->state.state), f->state.normal_force,
                       scene_norm(f->state.tangential_force), 1e6 * scene_norm(f->state.elastic),
                       1e6 * f->state.slip_total);
        terminal_print(stream, "%s\n", number_for_people("%8.4f", world_least_margin(w, f), margin));
    }
    run_print_joints(w, stream);
    char n[4][48];
    terminal_print(stream, "  object moved %s mm, creep %s m/s and %s rad/s, fastest in the second half %s m/s\n",
                   number_for_people("%.6g", 1e3 * scene_norm(r->motion.displacement), n[0]),
                   number_for_people("%.3g", r->motion.creep, n[1]),
                   number_for_people("%.3g", r->motion.creep_angular, n[2]),
                   number_for_people("%.3g", r->speed_max, n[3]));
    print_motion_in_hand(r, stream);
    terminal_print(stream, "  forces balance to %s N and %s N m", number_for_people("%.2g", r->force_error, n[0]),
                   number_for_people("%.2g", r->torque_error, n[1]));
    if (w->plugin)
        terminal_print(stream,
                       "; verified: %s, residual %.2g, cone %.2g N, %ld unconverged steps, %.2f iterations a step",
                       w->steps == 0                                    ? "-"
                       : world_solve_status(w) == PINCH_SOLVE_CONVERGED ? "yes"
                                                                        : "no",
                       stats.residual_max, stats.cone, stats.unconverged_steps,
                       stats.islands ? (double)stats.iterations / (double)stats.islands : 0);
    if (stats.fallback_islands)
        terminal_print(
            stream, "\n  left to ODE's solver %ld times, where no answer passed its checks (--record DIR keeps these)",
            stats.fallback_islands);
    if (stats.too_soft_islands)
        terminal_print(stream,
                       "\n  too soft %ld times: stiff contacts gave way so that forces miss their law by up to %.3g N",
                       stats.too_soft_islands, stats.floor_residual_max);
    if (w->plugin)
        terminal_print(stream, "\n  solved by Newton's steps %ld times, by greedy projections %ld, along a flow %ld%s",
                       stats.islands_by_newton, stats.islands_by_projections, stats.islands_by_flow,
                       stats.islands_by_lcp ? ", as a complementarity problem in the other steps" : "");
    if (w->plugin) print_energy(w, stream);
    terminal_print(stream, "\n  cost a step: %s us, and %s us for collision detection\n",
                   number_for_people("%.2f", world_us_a_step(w, w->step_s), n[0]),
                   number_for_people("%.2f", world_us_a_step(w, w->collide_s), n[1]));
    if (w->diverged)
        fputs("  the run diverged: its numbers left the range of double precision, and the next step was not taken\n",
              stream);
    else
        terminal_print(stream, "  outcome: %s%s\n", simulation_outcome(r),
                       r->touched ? "" : "; no finger touches an object at the end");
    for (int i = 0; i < r->event_count; i++) {
        const simulation_event *e = &r->events[i];
        const char *of = e->finger >= 0  ? w->fingers[e->finger].finger->name
                         : e->joint >= 0 ? w->hands[e->hand].joints[e->joint].name
                         : e->object > 0 ? w->scene->objects[e->object].name
                                         : "";
        terminal_print(stream, "  event at %g s: %s%s%s, value %g, limit %g\n", e->time, simulation_event_name(e->type),
                       *of ? " " : "", of, e->value, e->limit);
    }
}

/* ---- The CSV file: a header line, then a row for each step. ---- */

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
    run_hands_csv_header(w, stream);
    fputc('\n', stream);
}

static void write_csv_row(const world *w, FILE *stream)
{
    char text[32];
    json_number_text(w->time, text);
    fputs(text, stream);
    csv_numbers(stream, dBodyGetPosition(w->object), 3);
    csv_numbers(stream, dBodyGetQuaternion(w->object), 4);
    csv_numbers(stream, dBodyGetLinearVel(w->object), 3);
    csv_numbers(stream, dBodyGetAngularVel(w->object), 3);
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger_state *s = &w->fingers[i].state;
        csv_numbers(stream, s->force, 3);
        csv_numbers(stream, s->slip, 3);
        fprintf(stream, ",%s", pinch_contact_state_text(s->state));
    }
    run_hands_csv_row(w, stream);
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
    whole_file csv, gltf, view;
    page_libraries *libraries; /* of the view */
    run_checkpoint checkpoint;
} run_files;

static bool open_file(whole_file *file, const char *path)
{
    if (!path || whole_file_open(file, path)) return true;
    (void)command_cannot_write("run", path);
    return false;
}

static bool close_file(whole_file *file, const char *path, bool keep)
{
    if (!file->stream || whole_file_close(file, keep)) return true;
    (void)command_cannot_write("run", path);
    return false;
}

/* What a run writes while it goes. */
typedef struct run_outputs {
    FILE *csv; /* a row for every step; NULL: none */
    film *pictures;
    const run_checkpoint *checkpoint;
    bool progress; /* on a terminal */
    bool remarks;
} run_outputs;

static void say(void *scene_name, const char *text)
{
    command_error("run", "%s: %s", (const char *)scene_name, text);
}

/* Tells after the first step what is remarkable about the start, and about the end that is to come. */
static void remark_start(const simulation *s, const world *w)
{
    const char *overlap = simulation_so_far(s)->overlap;
    char text[SIMULATION_REMARK];
    if (w->steps != 1) return;
    if (simulation_duration_remark(w->scene, text)) say(w->scene->name, text);
    if (overlap) say(w->scene->name, overlap);
}

/* Goes on to the end of the scene's duration, or until a signal interrupts it. *ended tells how the world's steps
 * ended. */
static command_status simulate(simulation *s, world *w, const run_outputs *out, world_status *ended)
{
    command_status status = COMMAND_DONE;
    progress line;
    *ended = WORLD_OK;
    progress_start(&line, out->progress);
    while (w->steps < simulation_steps(s) && status == COMMAND_DONE && *ended == WORLD_OK && !process_interrupted() &&
           !(out->csv && ferror(out->csv))) {
        *ended = simulation_step(s);
        if (*ended != WORLD_OK) break;
        if (out->remarks) remark_start(s, w);
        progress_show(&line, w->steps, simulation_steps(s), w->time, w->scene->duration);
        if (out->csv) write_csv_row(w, out->csv);
        if (out->pictures && !film_step(out->pictures, w)) *ended = WORLD_NO_MEMORY;
        if (*ended == WORLD_OK && out->checkpoint) status = run_checkpoint_step(out->checkpoint, s, w->steps, false);
    }
    progress_end(&line);
    if (status != COMMAND_DONE || *ended != WORLD_OK) return status;
    bool last = out->checkpoint && process_interrupted();
    return last ? run_checkpoint_step(out->checkpoint, s, w->steps, true) : status;
}

/* The same scene with quickstep, for the view. Where memory runs out, *ghost stays without a film. */
static void run_ghost(const options *o, const world *w, page_run *ghost)
{
    char error[256];
    world *other;
    simulation_result result = {.events = NULL};
    world_settings settings = world_default_settings(w->scene);
    settings.contact_solver = WORLD_QUICKSTEP;
    dRandSetSeed(0); /* what has run before is not to change quickstep's order of rows */
    if (world_create(w->scene, &settings, &other, error) != WORLD_OK) return;
    world_status ended = WORLD_NO_MEMORY;
    simulation *s = simulation_start(other);
    run_outputs out = {.progress = !o->quiet, .pictures = film_start(other, o->fps)};
    if (s && out.pictures) (void)simulate(s, other, &out, &ended);
    if (s) simulation_finish(s, &result);
    if (ended != WORLD_NO_MEMORY && film_finish(out.pictures, other))
        *ghost = (page_run){out.pictures, simulation_document(other, &result, false)};
    else
        film_free(out.pictures);
    simulation_free(&result);
    world_free(other);
}

static bool write_view(const options *o, const world *w, const run_files *files, film *pictures,
                       const simulation_result *result)
{
    page_run run = {pictures, simulation_document(w, result, false)}, ghost = {.film = NULL};
    bool beside = o->contact_solver == WORLD_PINCH && !process_interrupted();
    if (beside) run_ghost(o, w, &ghost);
    bool done = run.document && (!beside || ghost.document) &&
                page_write_run(files->libraries, &run, beside ? &ghost : NULL, files->view.stream);
    json_decref(run.document);
    json_decref(ghost.document);
    film_free(ghost.film);
    return done;
}

/* The files of a run that has ended, or was given up for want of memory. */
static world_status finish_files(const options *o, world *w, const run_files *files, film *pictures,
                                 const simulation_result *result, world_status ended)
{
    if (ended == WORLD_NO_MEMORY || (pictures && !film_finish(pictures, w))) return WORLD_NO_MEMORY;
    bool done = (!o->gltf || gltf_write(pictures, files->gltf.stream)) &&
                (!o->view || write_view(o, w, files, pictures, result));
    return done ? ended : WORLD_NO_MEMORY;
}

static command_status simulate_into(const options *o, world *w, const run_files *files, simulation_result *result)
{
    world_status ended = WORLD_NO_MEMORY;
    bool wanted = o->gltf || o->view;
    simulation *s = simulation_start(w);
    command_status status = s ? run_checkpoint_resume(&files->checkpoint, s) : COMMAND_DONE;
    run_outputs out = {
        .progress = !o->quiet, .remarks = !o->quiet, .csv = files->csv.stream, .checkpoint = &files->checkpoint};
    if (s && wanted && status == COMMAND_DONE) out.pictures = film_start(w, o->fps);
    if (s && status == COMMAND_DONE && (out.pictures || !wanted)) {
        if (o->csv) write_csv_header(w, files->csv.stream);
        status = simulate(s, w, &out, &ended);
    }
    if (s) simulation_finish(s, result);
    if (status == COMMAND_DONE) {
        ended = finish_files(o, w, files, out.pictures, result, ended);
        if (ended == WORLD_NO_MEMORY) {
            command_error("run", "out of memory");
            status = COMMAND_SYSTEM;
        }
    }
    film_free(out.pictures);
    return status;
}

/* A file that could not be completed is not left behind. */
static command_status simulate_and_record(const options *o, world *w, run_files *files, simulation_result *result)
{
    command_status status = COMMAND_SYSTEM;
    bool written =
        open_file(&files->csv, o->csv) && open_file(&files->gltf, o->gltf) && open_file(&files->view, o->view);
    if (written) status = simulate_into(o, w, files, result);
    bool keep = status == COMMAND_DONE;
    written = close_file(&files->csv, o->csv, keep) && written;
    written = close_file(&files->gltf, o->gltf, keep) && written;
    written = close_file(&files->view, o->view, keep) && written;
    return written ? status : COMMAND_SYSTEM;
}

/* What a scene must have so that an event can happen at all. NULL: it can. */
static const char *lacks(const scene *s, simulation_event_type type)
{
    bool force = false, slip = false, limits = false;
    for (size_t i = 0; i < s->finger_count; i++) {
        force = force || isfinite(s->fingers[i].damage_max_force);
        slip = slip || isfinite(s->fingers[i].damage_max_slip);
    }
    for (size_t k = 0; k < s->hand_count; k++)
        for (size_t i = 0; i < s->hands[k].model->joint_count; i++)
            limits = limits || s->hands[k].model->joints[i].limited;
    if (type == EVENT_CRUSH && !force) return "no finger has damage.max_force";
    if (type == EVENT_SLIP && !slip) return "no finger has damage.max_slip";
    if (type == EVENT_LIMIT && !limits) return "there is no hand with a limited joint";
    return NULL;
}

/* Who waits for an event that never comes takes every run for a good one. */
static void remark_events_that_never_happen(const options *o, const scene *s,
                                            void (*report)(void *context, const char *text), void *context)
{
    for (int i = 0; i < EVENT_COUNT; i++) {
        const char *why = lacks(s, (simulation_event_type)i);
        char text[160];
        if (!(o->fail_on & 1u << i) || !why) continue;
        snprintf(text, sizeof text, "--fail-on %s: %s, so that this never happens",
                 simulation_event_name((simulation_event_type)i), why);
        report(context, text);
    }
}

static json_t *document_of(const options *o, const world *w, const simulation_result *result)
{
    json_t *document = simulation_document(w, result, true);
    remark_events_that_never_happen(o, w->scene, json_append_text, json_object_get(document, "remarks"));
    return document;
}

static command_status present(const options *o, const world *w, const simulation_result *result)
{
    if (o->json) {
        if (!json_print_new(document_of(o, w, result), stdout)) {
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

command_status command_run_scene(const options *o, const scene *s)
{
    char error[256];
    world *w;
    simulation_result result = {.events = NULL};
    char folder[RECORD_PATH];
    pinch_ode_record_folder record = {.path = folder, .most = COMMAND_MOST_RECORDINGS};
    run_files files = {.libraries = NULL};
    world_settings settings = settings_from(o, s);
    command_status status = prepare_record(o, &settings, &record, folder);
    if (status == COMMAND_DONE) status = run_checkpoint_prepare(o, &files.checkpoint);
    if (status == COMMAND_DONE && o->view) status = page_libraries_load("run", &files.libraries);
    if (status != COMMAND_DONE) {
        run_checkpoint_free(&files.checkpoint);
        return status;
    }
    process_keep_signals();
    dInitODE2(0);
    status = COMMAND_SYSTEM;
    switch (world_create(s, &settings, &w, error)) {
    case WORLD_OK:
        status = simulate_and_record(o, w, &files, &result);
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
    page_libraries_free(files.libraries);
    run_checkpoint_free(&files.checkpoint);
    world_close_ode();
    return status;
}

/* ODE's own solvers have no settings here. */
static command_status check_foreign(const options *o)
{
    static const option_id of_pinch[] = {OPTION_SOLVER, OPTION_FORMULATION, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS,
                                         OPTION_FACES,  OPTION_NO_NEWTON,   OPTION_RECORD,    OPTION_COUNT};
    return command_refuse_given(o, of_pinch, "expected Pinch as contact solver, which alone has it");
}

static command_status run_run(const options *o)
{
    scene *s;
    command_status status = command_load_scene(o, o->arguments[0], &s);
    if (status != COMMAND_DONE) return status;
    status = o->contact_solver == WORLD_PINCH ? command_check_run("run", s) : check_foreign(o);
    if (status == COMMAND_DONE && !o->quiet) remark_events_that_never_happen(o, s, say, s->file);
    if (status == COMMAND_DONE) status = command_run_scene(o, s);
    scene_free(s);
    return status;
}

static const option_id run_options[] = {
    OPTION_SOLVER,     OPTION_FORMULATION, OPTION_TOLERANCE,  OPTION_MAX_ITERATIONS, OPTION_FACES, OPTION_SEED,
    OPTION_NO_NEWTON,  OPTION_DURATION,    OPTION_STEP,       OPTION_CONTACT_SOLVER, OPTION_JSON,  OPTION_CSV,
    OPTION_FAIL_ON,    OPTION_RECORD,      OPTION_RECORD_ALL, OPTION_GLTF,           OPTION_VIEW,  OPTION_FPS,
    OPTION_CHECKPOINT, OPTION_EVERY,       OPTION_RESUME,     OPTION_QUIET,          OPTION_COUNT,
};

const command command_run = {
    .name = "run",
    .arguments = "SCENE",
    .summary = "simulates a scene in ODE with Pinch as contact solver",
    .notes = COMMAND_SCENE_NOTE,
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "json",
    .options = run_options,
    .run = run_run,
};
