/* pinch solve for scenes with hands. */
#include "pinch_solve.h"

#include "common/output.h"
#include "common/terminal.h"
#include "common/vector.h"
#include "scenes/world/world.h"
#include "statics/hand_statics.h"

#include <math.h>

static const char *status_text(hand_statics_status status)
{
    pinch_solve_status as = status == HAND_STATICS_SOLVED       ? PINCH_SOLVE_CONVERGED
                            : status == HAND_STATICS_UNVERIFIED ? PINCH_SOLVE_UNVERIFIED
                            : status == HAND_STATICS_INFEASIBLE ? PINCH_SOLVE_INFEASIBLE
                                                                : PINCH_SOLVE_MAX_ITERATIONS;
    return pinch_solve_status_text(as);
}

static bool is_answer(const hand_statics *x)
{
    return x->status == HAND_STATICS_SOLVED || x->status == HAND_STATICS_UNVERIFIED;
}

/* ---- The document. ---- */

static json_t *no_vector(void)
{
    const double none[3] = {NAN, NAN, NAN};
    return json_numbers(none, 3);
}

/* Displacements and slip belong to the points of a link, of which it may have many. */
static json_t *finger_document(const hand_static_finger *f)
{
    return json_pack("{s:s, s:s, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "name", f->name, "state",
                     pinch_contact_state_text(f->state), "points", f->points, "normal_force",
                     json_number(f->normal_force), "tangential_force", json_numbers(f->tangential_force, 3),
                     "torsional_moment", json_number(f->torsional_moment), "force", json_numbers(f->force, 3),
                     "normal_displacement", json_null(), "tangential_displacement", no_vector(), "slip", no_vector(),
                     "slip_margin", json_number(f->slip_margin));
}

static json_t *joint_document(const hand_static_joint *j)
{
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:b}", "hand", j->hand, "name", j->name, "position",
                     json_number(j->position), "target", json_number(j->target), "torque", json_number(j->torque),
                     "contact_torque", json_number(j->contact_torque), "weight_torque", json_number(j->weight_torque),
                     "passive_torque", json_number(j->passive_torque), "at_limit", j->at_limit, "saturated",
                     j->saturated);
}

static json_t *hands_document(const scene *s, double moment, const hand_statics *x)
{
    json_t *fingers = json_array(), *joints = json_array();
    for (int i = 0; i < x->finger_count; i++) json_array_append_new(fingers, finger_document(&x->fingers[i]));
    for (int i = 0; i < x->joint_count; i++) json_array_append_new(joints, joint_document(&x->joints[i]));
    bool answer = is_answer(x);
    double none = answer ? 0 : NAN;
    json_t *document = json_pack("{s:s, s:s, s:s, s:s, s:s, s:i, s:i, s:i, s:i, s:o, s:o, s:o, s:o, s:o}", "command",
                                 "solve", "scene", s->name, "status", status_text(x->status), "solver", "newton",
                                 "formulation", "coulomb", "size", x->unknowns, "iterations", x->steps, "projections",
                                 0, "newton_steps", x->steps, "residual", json_number(x->residual), "time_s",
                                 json_number(x->time), "load_fraction", json_number(answer ? 1 : NAN), "solved_by",
                                 answer ? json_string("newton") : json_null(), "moment_s", json_number(moment));
    json_t *rest = json_pack(
        "{s:{s:o, s:o}, s:{s:b, s:o, s:o, s:o, s:o, s:o}, s:o, s:o, s:{s:o, s:o}, s:o, s:o, s:o, s:o}", "equilibrium",
        "force_error", json_number(x->force_error + none), "torque_error", json_number(x->torque_error + none),
        "verification", "passed", x->status == HAND_STATICS_SOLVED, "cone", json_number(x->cone + none),
        "complementarity", json_number(x->normal_law + none), "slip_direction", json_number(x->slip_direction + none),
        "joints", json_number(x->joint_error + none), "motors", json_number(x->motor_error + none), "fingers", fingers,
        "joints", joints, "object", "translation", answer ? json_numbers(x->translation, 3) : no_vector(), "rotation",
        answer ? json_numbers(x->rotation, 3) : no_vector(), "grasp", json_null(), "twist", json_null(),
        "not_expressed", json_array(), "remarks", json_array()); /* contacts are the run's */
    int failed = !document || !rest || json_object_update(document, rest);
    json_decref(rest);
    if (!failed) return document;
    json_decref(document);
    return NULL;
}

/* ---- The tables. ---- */

static void print_joints(const scene *s, const hand_statics *x, FILE *stream)
{
    bool several = s->hand_count > 1;
    terminal_print(stream, "  %-24s %12s %12s %12s %12s %12s\n", "joint", "position", "target", "torque", "of contacts",
                   "of weights");
    for (int i = 0; i < x->joint_count; i++) {
        const hand_static_joint *j = &x->joints[i];
        char name[128];
        (void)snprintf(name, sizeof name, "%s%s%s", several ? j->hand : "", several ? "/" : "", j->name);
        terminal_print(stream, "  %-24s %12.6f", name, j->position);
        if (isnan(j->target))
            terminal_print(stream, " %12s", "-");
        else
            terminal_print(stream, " %12.6f", j->target);
        terminal_print(stream, " %12.6f %12.6f %12.6f%s%s\n", j->torque, j->contact_torque, j->weight_torque,
                       j->at_limit ? "  at its limit" : "", j->saturated ? "  saturated" : "");
    }
}

void solve_write_margin(double margin, char text[SOLVE_MARGIN_LENGTH])
{
    static const double SHOWS = 5e-5; /* less is 0.0000 */
    if (!isfinite(margin))
        snprintf(text, SOLVE_MARGIN_LENGTH, "-");
    else
        snprintf(text, SOLVE_MARGIN_LENGTH, "%.4f", fabs(margin) < SHOWS ? 0 : margin);
}

static void print_tables(const scene *s, double moment, const hand_statics *x, FILE *stream)
{
    if (x->status == HAND_STATICS_INFEASIBLE) {
        terminal_print(stream, "%s: %s at %g s: %s, which has a load\n", s->name, status_text(x->status), moment,
                       x->why);
        return;
    }
    terminal_print(stream, "%s: %s at %g s by Newton's steps (%d unknowns), %d steps, residual %.2g N, %.3g ms\n",
                   s->name, status_text(x->status), moment, x->unknowns, x->steps, x->residual, 1e3 * x->time);
    if (x->status == HAND_STATICS_NOT_FOUND)
        terminal_print(stream, "  No equilibrium was found. There may be none, as where an object slides off.\n");
    if (!is_answer(x)) return;
    terminal_print(stream, "  %-16s %-6s %6s %12s %12s %9s\n", "finger", "state", "points", "normal N", "tangential N",
                   "margin");
    for (int i = 0; i < x->finger_count; i++) {
        const hand_static_finger *f = &x->fingers[i];
        char margin[SOLVE_MARGIN_LENGTH];
        solve_write_margin(f->slip_margin, margin);
        terminal_print(stream, "  %-16s %-6s %6d %12.6g %12.6g %9s\n", f->name, pinch_contact_state_text(f->state),
                       f->points, f->normal_force, scene_norm(f->tangential_force), margin);
    }
    print_joints(s, x, stream);
    const double *d = x->translation, *r = x->rotation;
    terminal_print(stream, "  from there the object moves (%.4g, %.4g, %.4g) mm, turns (%.4g, %.4g, %.4g) mrad\n",
                   1e3 * d[0], 1e3 * d[1], 1e3 * d[2], 1e3 * r[0], 1e3 * r[1], 1e3 * r[2]);
    terminal_print(
        stream,
        "  balance to %.2g N, %.2g N m, of joints %.2g; motors and ties %.2g, cone %.2g N, laws %.2g N, slip "
        "direction %.2g N: %s\n",
        x->force_error, x->torque_error, x->joint_error, x->motor_error, x->cone, x->normal_law, x->slip_direction,
        x->status == HAND_STATICS_SOLVED ? "verified" : "NOT verified, which asks for 1e-9 of the forces");
}

/* ---- The command. ---- */

/* An option that the statics of hands do not know; NULL: none was given. */
static const char *unknown_option(const options *o)
{
    if (o->faithful) return "--faithful";
    if (o->directions) return "--directions";
    if (o->inscribed) return "--inscribed";
    if (o->one_step) return "--one-step";
    if (o->no_newton) return "--no-newton";
    return NULL;
}

static command_status refuse(const scene *s, const char *why)
{
    command_error("solve", "%s: %s", s->file, why);
    return COMMAND_BAD_INPUT;
}

static command_status present(const options *o, const scene *s, double moment, const hand_statics *x)
{
    if (o->json) {
        if (!json_print_new(hands_document(s, moment, x), stdout)) return COMMAND_SYSTEM;
    } else if (!o->quiet) {
        print_tables(s, moment, x, stdout);
    }
    return x->status == HAND_STATICS_SOLVED ? COMMAND_DONE : COMMAND_FAILED;
}

command_status solve_with_hands(const options *o, const scene *s, double moment)
{
    if (isnan(moment)) return refuse(s, "a hand touches what its run has come to: expected --at-end or --time T");
    if (unknown_option(o)) {
        command_error("solve", "%s: %s is not for scenes with hands", s->file, unknown_option(o));
        return COMMAND_BAD_INPUT;
    }
    if (s->solver.formulation == SCENE_LCP)
        return refuse(s, "the statics of hands have the exact friction cone: expected formulation coulomb");
    hand_statics x;
    command_status status = COMMAND_SYSTEM;
    dInitODE2(0);
    bool room = hand_statics_solve(s, moment, &x);
    world_close_ode();
    if (!room) {
        command_error("solve", "out of memory");
    } else if (x.status == HAND_STATICS_UNSUPPORTED) {
        command_error("solve", "%s: the statics of hands do not know %s; use run", s->file, x.why);
        status = COMMAND_BAD_INPUT;
    } else if (x.status == HAND_STATICS_FAILED) {
        command_error("solve", "%s: %s", s->file, x.why);
        status = COMMAND_FAILED;
    } else {
        status = present(o, s, moment, &x);
    }
    hand_statics_free(&x);
    return status;
}
