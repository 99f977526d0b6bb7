/* What a run prints: the JSON document, the table, the CSV rows. */
#include "common/json_output.h"
#include "run.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

double run_slip_margin(const world_finger *finger)
{
    const world_finger_state *s = &finger->state;
    const scene_finger *f = finger->finger;
    const double *t = s->tangential_force;
    if (!(s->normal_force > 0) || !(f->friction.static_ > 0)) return NAN;
    double reach = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) / f->friction.static_;
    if (f->torsional_friction > 0) reach = hypot(reach, s->torsional_moment / f->torsional_friction);
    return 1 - reach / s->normal_force;
}

static pinch_ode_stats stats_of(const world *w)
{
    pinch_ode_stats none = {.steps = 0};
    return w->plugin ? pinch_ode_statistics(w->plugin) : none;
}

pinch_solve_status run_status(const world *w)
{
    pinch_ode_stats stats = stats_of(w);
    if (w->diverged) return PINCH_SOLVE_DIVERGED;
    return stats.fallback_islands > 0 ? PINCH_SOLVE_MAX_ITERATIONS : PINCH_SOLVE_CONVERGED;
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
                     json_number(s->slip_total), "slip_margin", json_number(run_slip_margin(finger)),
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

static json_t *object_document(const world *w, const simulation_result *r)
{
    return json_pack(
        "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "position", json_numbers(dBodyGetPosition(w->object), 3),
        "orientation", json_numbers(dBodyGetQuaternion(w->object), 4), "linear_velocity",
        json_numbers(dBodyGetLinearVel(w->object), 3), "angular_velocity",
        json_numbers(dBodyGetAngularVel(w->object), 3), "displacement", json_numbers(r->displacement, 3), "creep",
        json_number(r->creep), "creep_angular", json_number(r->creep_angular), "speed_max", json_number(r->speed_max));
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

static void append_text(void *context, const char *text)
{
    (void)json_array_append_new(context, json_string(text));
}

static json_t *verification_document(const pinch_ode_stats *stats, bool pinch, bool passed)
{
    if (!pinch) return json_pack("{s:n, s:n, s:n, s:n}", "passed", "cone", "complementarity", "slip_direction");
    return json_pack("{s:o, s:o, s:o, s:o}", "passed", stats->steps > 0 ? json_boolean(passed) : json_null(), "cone",
                     json_number(stats->cone), "complementarity", json_number(stats->complementarity), "slip_direction",
                     json_number(stats->slip_direction));
}

static const char *contact_solver_name(const world *w)
{
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    return names[w->settings.contact_solver];
}

/* A number of Pinch's that ODE's own solvers do not have. */
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

static json_t *document_of(const world *w, const simulation_result *r)
{
    pinch_ode_stats stats = stats_of(w);
    bool pinch = w->plugin != NULL;
    char hash[24];
    snprintf(hash, sizeof hash, "%016" PRIx64, world_hash(w));
    json_t *not_expressed = json_array();
    world_not_expressed(w, append_text, not_expressed);
    double islands = stats.islands > 0 ? (double)stats.islands : NAN;
    json_t *head =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:I, s:o, s:o, s:o, s:o}", "command", "run", "scene", w->scene->file,
                  "status", pinch_solve_status_text(run_status(w)), "contact_solver", contact_solver_name(w), "solver",
                  pinch ? pinch_solver_name(w->settings.solver.solver) : contact_solver_name(w), "formulation",
                  scene_formulation_name(w->scene->solver.formulation), "steps", (json_int_t)w->steps, "time_s",
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
    json_t *tail = json_pack(
        "{s:o, s:{s:o, s:o}, s:o, s:o, s:o, s:o, s:o, s:o, s:s}", "verification",
        verification_document(&stats, pinch, run_status(w) == PINCH_SOLVE_CONVERGED), "equilibrium", "force_error",
        json_number(r->force_error), "torque_error", json_number(r->torque_error), "fingers", finger_documents(w),
        "object", object_document(w, r), "max_penetration", json_number(r->max_penetration), "energy",
        energy_document(w), "events", event_documents(w, r), "not_expressed", not_expressed, "hash", hash);
    bool failed = !head || !solve || !tail || json_object_update(head, solve) || json_object_update(head, tail);
    json_decref(solve);
    json_decref(tail);
    if (!failed) return head;
    json_decref(head);
    return NULL;
}

bool run_print_json(const world *w, const simulation_result *r, FILE *stream)
{
    json_t *document = document_of(w, r);
    if (!document) return false;
    json_print(document, stream);
    json_decref(document);
    return true;
}

static double length(const double *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

void run_print_table(const world *w, const simulation_result *r, FILE *stream)
{
    pinch_ode_stats stats = stats_of(w);
    fprintf(stream, "%s: %g s in %ld steps, contacts by %s\n", w->scene->name, w->time, w->steps,
            contact_solver_name(w));
    fprintf(stream, "  %-12s %-6s %12s %12s %12s %12s %8s\n", "finger", "state", "normal N", "tangential N",
            "elastic um", "slip um", "margin");
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *f = &w->fingers[i];
        double margin = run_slip_margin(f);
        fprintf(stream, "  %-12s %-6s %12.6f %12.6f %12.4f %12.4f ", f->finger->name,
                pinch_contact_state_text(f->state.state), f->state.normal_force, length(f->state.tangential_force),
                1e6 * length(f->state.elastic), 1e6 * f->state.slip_total);
        if (isnan(margin))
            fprintf(stream, "%8s\n", "-");
        else
            fprintf(stream, "%8.4f\n", margin);
    }
    fprintf(stream, "  object moved %.6g mm, creep %.3g m/s and %.3g rad/s, fastest in the second half %.3g m/s\n",
            1e3 * length(r->displacement), r->creep, r->creep_angular, r->speed_max);
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
    for (int i = 0; i < r->event_count; i++) {
        const simulation_event *e = &r->events[i];
        fprintf(stream, "  event at %g s: %s%s%s, value %g, limit %g\n", e->time, simulation_event_name(e->type),
                e->finger >= 0 ? " " : "", e->finger >= 0 ? w->fingers[e->finger].finger->name : "", e->value,
                e->limit);
    }
}

static void put_vector(FILE *stream, const double *v, int count)
{
    for (int i = 0; i < count; i++) {
        char text[32];
        json_number_text(v[i], text);
        fprintf(stream, ",%s", text);
    }
}

/* A header field of a finger, quoted as RFC 4180 has it where the name needs it. */
static void put_name(FILE *stream, const char *name, const char *suffix)
{
    fputc(',', stream);
    if (!strpbrk(name, ",\"\r\n")) {
        fprintf(stream, "%s.%s", name, suffix);
        return;
    }
    fputc('"', stream);
    for (const char *c = name; *c; c++) {
        if (*c == '"') fputc('"', stream);
        fputc(*c, stream);
    }
    fprintf(stream, ".%s\"", suffix);
}

void run_csv_header(const world *w, FILE *stream)
{
    static const char *const columns[] = {"fx", "fy", "fz", "slip_x", "slip_y", "slip_z", "state"};
    fputs("time,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz", stream);
    for (int i = 0; i < w->finger_count; i++) {
        for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
            put_name(stream, w->fingers[i].finger->name, columns[k]);
    }
    fputc('\n', stream);
}

void run_csv_row(const world *w, FILE *stream)
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
