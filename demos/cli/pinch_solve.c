/* pinch solve: the static grasp of a scene. */
#include "pinch_solve.h"

#include "common/measure.h"
#include "common/output.h"
#include "common/terminal.h"
#include "common/vector.h"
#include "quality/grasp_quality.h"
#include "scenes/grasp.h"

#include <math.h>
#include <stdlib.h>

typedef struct solution {
    const scene *s;
    pinch_statics_settings settings;
    pinch_grasp grasp;
    pinch_finger *fingers;
    pinch_finger_result *finger_results;
    pinch_statics_result result;
    double time;       /* s, that the solve took */
    double moment;     /* s, of the schedule; NaN: its first entry */
    bool searched;     /* for the reserves, which are NaN otherwise */
    bool contradicted; /* what was found is of another equilibrium */
    pinch_static_limits limits;
    pinch_static_limit least_closing;
    grasp_directions directions; /* count 0: not asked for */
    grasp_quality quality;       /* NaN where it was not asked for */
} solution;

static pinch_statics_settings settings_of(const options *o, const scene *s)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.solver.solver = s->solver.name;
    settings.solver.tolerance = s->solver.tolerance;
    settings.solver.goal = fmin(settings.solver.goal, s->solver.tolerance);
    settings.solver.max_iterations = s->solver.max_iterations;
    settings.solver.newton_finish = !o->no_newton;
    settings.solver.seed = o->seed;
    settings.formulation = s->solver.formulation == SCENE_LCP ? PINCH_FORMULATION_LCP : PINCH_FORMULATION_COULOMB;
    settings.faces = s->solver.pyramid_faces;
    settings.inscribed = o->inscribed;
    settings.one_step = o->one_step;
    settings.faithful = o->faithful;
    settings.unit = o->unit;
    return settings;
}

/* How far the finger itself is pressed in, m. The object may give way as well. */
static double depth_of(const solution *x, int i)
{
    const pinch_finger_result *f = &x->finger_results[i];
    return isnan(f->normal_displacement) ? NAN : f->r[0] / x->s->fingers[i].stiffness.normal;
}

static json_t *finger_document(const solution *x, int i)
{
    const pinch_finger_result *f = &x->finger_results[i];
    bool solved = x->result.solve.status == PINCH_SOLVE_CONVERGED;
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "name", x->s->fingers[i].name, "state",
                     solved ? json_string(pinch_contact_state_text(f->state)) : json_null(), "normal_force",
                     json_number(f->r[0]), "tangential_force", json_numbers(f->tangential_force, 3), "torsional_moment",
                     json_number(f->r[3]), "force", json_numbers(f->force, 3), "normal_displacement",
                     json_number(depth_of(x, i)), "tangential_displacement",
                     json_numbers(f->tangential_displacement, 3), "slip", json_numbers(f->slip, 3), "slip_margin",
                     json_number(f->slip_margin));
}

static json_t *finger_documents(const solution *x)
{
    json_t *list = json_array();
    for (int i = 0; i < x->grasp.finger_count; i++) json_array_append_new(list, finger_document(x, i));
    return list;
}

/* The bounds of a limit between which it lies. What was not looked for has no status. */
static json_t *limit_document(const pinch_static_limit *limit, bool searched)
{
    return json_pack("{s:s?, s:o, s:o}", "status", searched ? pinch_solve_status_text(limit->status) : NULL, "holds",
                     json_number(limit->holds), "fails", json_number(limit->fails));
}

static json_t *directions_document(const solution *x)
{
    const grasp_directions *d = &x->directions;
    if (d->count == 0) return json_null();
    json_t *list = json_array();
    for (int k = 0; k < d->count; k++)
        json_array_append_new(
            list, json_pack("{s:o, s:o, s:o, s:o, s:o}", "direction", json_numbers(d->of[k].direction, 3), "force",
                            json_number(d->force), "least_closing", limit_document(&d->of[k].least_closing, true),
                            "smallest_friction", limit_document(&d->of[k].smallest_friction, true),
                            "largest_load_factor", limit_document(&d->of[k].largest_load_factor, true)));
    return list;
}

static json_t *grasp_document(const solution *x)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < 6; i++) json_array_append_new(rows, json_numbers(x->result.stiffness + 6 * i, 6));
    const pinch_static_limit *friction = &x->limits.smallest_friction, *load = &x->limits.largest_load_factor;
    const grasp_quality *q = &x->quality;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:o, s:o, s:{s:o, s:o, s:o}}", "stiffness", rows,
                     "smallest_friction", json_number(friction->holds), "largest_load_factor", json_number(load->holds),
                     "least_closing", json_number(x->least_closing.holds), "epsilon", json_number(q->epsilon),
                     "epsilon_upper", json_number(q->epsilon_upper), "volume", json_number(q->volume), "quality_faces",
                     q->faces, "weakest_wrench", json_numbers(q->weakest, x->grasp.planar ? 3 : 6), "directions",
                     directions_document(x), "limits", "smallest_friction", limit_document(friction, x->searched),
                     "largest_load_factor", limit_document(load, x->searched), "least_closing",
                     limit_document(&x->least_closing, x->searched));
}

/* How the object escapes. A motion explains a failure only where it was shown that nothing holds against it. The twist
 * that proves that a wrench is infeasible is the one against which it works, so that the object goes the other way. */
static bool find_motion(const solution *x, double motion[6])
{
    const double *t = x->result.twist;
    bool infeasible = x->result.solve.status == PINCH_SOLVE_INFEASIBLE;
    for (int j = 0; j < 6; j++) motion[j] = (infeasible ? -t[j] : t[j]) + 0.0; /* no -0 */
    return (infeasible || x->result.solve.status == PINCH_SOLVE_UNSTABLE) && scene_norm(t) + scene_norm(t + 3) > 0.0;
}

static const char unknown_reserves[] = "its reserves are not known: by the default method the load leads elsewhere";

static const char *large_displacement(const solution *x)
{
    if (!x->result.large_displacement || x->result.solve.status != PINCH_SOLVE_CONVERGED) return NULL;
    return "the object moves by more than a tenth of its size or turns by more than 0.1 rad; the statics are linear "
           "and only tell the tendency";
}

/* What makes the answer another one than was meant, in a line each. */
static void find_remarks(const solution *x, void (*report)(void *context, const char *text), void *context)
{
    if (large_displacement(x)) report(context, large_displacement(x));
    if (x->contradicted) report(context, unknown_reserves);
}

static json_t *solution_document(const solution *x)
{
    const pinch_statics_result *r = &x->result;
    const pinch_static_verification *v = &r->verification;
    json_t *document = json_pack("{s:s, s:s, s:s, s:s, s:s, s:i, s:i, s:I, s:i, s:o, s:o, s:o}", "command", "solve",
                                 "scene", x->s->name, "status", pinch_solve_status_text(r->solve.status), "solver",
                                 pinch_solver_name(x->settings.solver.solver), "formulation",
                                 scene_formulation_name(x->s->solver.formulation), "size", r->size, "iterations",
                                 r->solve.iterations, "projections", (json_int_t)r->solve.projections, "newton_steps",
                                 r->solve.newton_steps, "residual", json_number(r->solve.residual), "time_s",
                                 json_number(x->time), "load_fraction", json_number(r->load_fraction));
    double motion[6];
    bool solved = r->solve.status == PINCH_SOLVE_CONVERGED, escapes = find_motion(x, motion);
    pinch_solved_by by = pinch_solver_solved_by(&x->settings.solver, &r->solve);
    json_t *rest = json_pack("{s:o, s:o, s:{s:o, s:o}, s:{s:b, s:o, s:o, s:o}, s:o, s:{s:o, s:o}, s:o, s:o}",
                             "solved_by", solved ? json_string(pinch_solved_by_name(by)) : json_null(), "moment_s",
                             json_number(x->moment), "equilibrium", "force_error", json_number(v->force_error),
                             "torque_error", json_number(v->torque_error), "verification", "passed", (int)v->passed,
                             "cone", json_number(v->cone), "complementarity", json_number(v->complementarity),
                             "slip_direction", json_number(v->slip_direction), "fingers", finger_documents(x), "object",
                             "translation", json_numbers(r->translation, 3), "rotation", json_numbers(r->rotation, 3),
                             "grasp", grasp_document(x), "twist", escapes ? json_numbers(motion, 6) : json_null());
    json_t *left_out = json_array();
    scene_statics_leave_out(x->s, json_append_text, left_out);
    json_t *remarks = json_array();
    find_remarks(x, json_append_text, remarks);
    int failed = !document || !rest || json_object_update(document, rest) ||
                 json_object_set(document, "not_expressed", left_out) || json_object_set(document, "remarks", remarks);
    json_decref(left_out);
    json_decref(remarks);
    json_decref(rest);
    if (!failed) return document;
    json_decref(document);
    return NULL;
}

static void print_fingers(const solution *x, FILE *stream)
{
    terminal_print(stream, "  %-12s %-6s %12s %12s %12s %12s %9s\n", "finger", "state", "normal N", "tangential N",
                   "depth um", "slip um", "margin");
    for (int i = 0; i < x->grasp.finger_count; i++) {
        const pinch_finger_result *f = &x->finger_results[i];
        char margin[SOLVE_MARGIN_LENGTH];
        solve_write_margin(f->slip_margin, margin);
        terminal_print(stream, "  %-12s %-6s %12.6g %12.6g %12.6g %12.6g %9s\n", x->s->fingers[i].name,
                       pinch_contact_state_text(f->state), f->r[0], scene_norm(f->tangential_force),
                       1e6 * depth_of(x, i), 1e6 * scene_norm(f->slip), margin);
    }
}

static void print_open_limit(const char *of, const pinch_static_limit *limit, FILE *stream)
{
    if (limit->status == PINCH_SOLVE_CONVERGED) return;
    char n[48];
    terminal_print(stream, "  the search for the limit of %s ended early: the grasp holds with %s", of,
                   number_for_people("%.9g", limit->holds, n));
    if (isfinite(limit->fails)) terminal_print(stream, ", not with %.9g", limit->fails);
    terminal_print(stream, "\n");
}

/* A factor on friction, grip or load; "-" where there is none. */
static void print_factor(double factor, FILE *stream)
{
    if (isnan(factor))
        terminal_print(stream, " %12s", "-");
    else
        terminal_print(stream, " %12.6g", factor);
}

static void print_directions(const grasp_directions *d, FILE *stream)
{
    if (d->count == 0) return;
    terminal_print(stream, "  with %.6g N along %12s %12s %12s\n", d->force, "least grip", "friction", "most load");
    for (int k = 0; k < d->count; k++) {
        terminal_print(stream, "  %17c%c", k % 2 ? '-' : '+', 'x' + k / 2);
        print_factor(d->of[k].least_closing.holds, stream);
        print_factor(d->of[k].smallest_friction.holds, stream);
        print_factor(d->of[k].largest_load_factor.holds, stream);
        fputc('\n', stream);
    }
}

static void print_limits(const solution *x, FILE *stream)
{
    const pinch_static_limit *friction = &x->limits.smallest_friction, *load = &x->limits.largest_load_factor;
    if (isfinite(friction->holds))
        terminal_print(stream, "  the grasp holds down to %.6g of its friction\n", friction->holds);
    if (isinf(load->holds))
        terminal_print(stream, "  it holds any multiple of its load\n");
    else if (!isnan(load->holds))
        terminal_print(stream, "  it holds up to %.6g of its load\n", load->holds);
    if (isfinite(x->least_closing.holds))
        terminal_print(stream, "  it holds down to %.6g of its grip (closing and normal forces of all fingers)\n",
                       x->least_closing.holds);
    if (x->contradicted) terminal_print(stream, "  %s\n", unknown_reserves);
    print_directions(&x->directions, stream);
    print_open_limit("friction", friction, stream);
    print_open_limit("the load", load, stream);
    print_open_limit("the grip", &x->least_closing, stream);
    if (!isnan(x->quality.epsilon))
        terminal_print(stream, "  quality by %d faces: epsilon %.6g N/N, volume %.6g\n", x->quality.faces,
                       x->quality.epsilon, x->quality.volume);
}

/* With which factors a grasp that does not hold would. */
static void print_remedies(const solution *x, FILE *stream)
{
    static const double LITTLE = 1e-6; /* less is no load: it is what the search leaves open */
    const double friction = x->limits.smallest_friction.holds, load = x->limits.largest_load_factor.holds;
    if (isfinite(friction)) terminal_print(stream, "  it would hold with %.6g of its friction\n", friction);
    if (isfinite(load) && load > LITTLE) terminal_print(stream, "  it would hold %.6g of its load\n", load);
    if (isfinite(x->least_closing.holds))
        terminal_print(stream, "  it would hold with %.6g of its grip (closing and normal forces of all fingers)\n",
                       x->least_closing.holds);
}

/* Which of the method's steps found the answer. */
static const char *found_by(const solution *x)
{
    static const char *const texts[PINCH_SOLVED_BY_COUNT] = {
        [PINCH_SOLVED_BY_START] = "",
        [PINCH_SOLVED_BY_NEWTON] = ", by Newton's steps alone",
        [PINCH_SOLVED_BY_PROJECTIONS] = ", by greedy projections",
        [PINCH_SOLVED_BY_FLOW] = ", along an implicit flow",
        [PINCH_SOLVED_BY_LCP] = "",
    };
    if (x->result.solve.status != PINCH_SOLVE_CONVERGED) return "";
    return texts[pinch_solver_solved_by(&x->settings.solver, &x->result.solve)];
}

static void print_left_out(void *stream, const char *text)
{
    terminal_print(stream, "  the statics leave out %s\n", text);
}

static void print_table(const solution *x, FILE *stream)
{
    const pinch_statics_result *r = &x->result;
    char n[48];
    terminal_print(stream, "%s: %s by %s%s (%s, %d unknowns), %d iterations, residual %s, %.3g ms\n", x->s->name,
                   pinch_solve_status_text(r->solve.status), pinch_solver_name(x->settings.solver.solver), found_by(x),
                   scene_formulation_name(x->s->solver.formulation), r->size, r->solve.iterations,
                   number_for_people("%.2g", r->solve.residual, n), 1e3 * x->time);
    scene_statics_leave_out(x->s, print_left_out, stream);
    double t[6];
    if (find_motion(x, t))
        terminal_print(stream, "  %s (%.4g, %.4g, %.4g) m, (%.4g, %.4g, %.4g) rad; wrench reached: %s\n",
                       r->solve.status == PINCH_SOLVE_INFEASIBLE ? "no finger can resist the motion"
                                                                 : "the object escapes along",
                       t[0], t[1], t[2], t[3], t[4], t[5], number_for_people("%.4g", r->load_fraction, n));
    if (r->solve.status != PINCH_SOLVE_CONVERGED) {
        print_remedies(x, stream);
        return;
    }
    print_fingers(x, stream);
    terminal_print(stream, "  object moves (%.4g, %.4g, %.4g) mm, turns (%.4g, %.4g, %.4g) mrad\n",
                   1e3 * r->translation[0], 1e3 * r->translation[1], 1e3 * r->translation[2], 1e3 * r->rotation[0],
                   1e3 * r->rotation[1], 1e3 * r->rotation[2]);
    terminal_print(stream, "  balance to %.2g N, %.2g N m; cone %.2g N, laws %.2g N, slip direction %.2g N: %s\n",
                   r->verification.force_error, r->verification.torque_error, r->verification.cone,
                   r->verification.complementarity, r->verification.slip_direction,
                   r->verification.passed ? "verified" : "NOT verified, which asks for 1e-9 of the forces");
    print_limits(x, stream);
}

/* The size of the load's force; that of the object's weight on earth where there is none. */
static double force_of_load(const solution *x)
{
    double force = scene_norm(x->grasp.wrench);
    return force > 0.0 ? force : 9.81 * x->s->objects[0].mass;
}

/* Do the reserves say that a grasp does not hold which was solved? Other methods and one step may end elsewhere than
 * the path by which reserves are found. */
static bool reserves_contradict(const solution *x)
{
    return x->result.solve.status == PINCH_SOLVE_CONVERGED &&
           (x->limits.smallest_friction.holds > 1.0 || x->limits.largest_load_factor.holds < 1.0 ||
            x->least_closing.holds > 1.0);
}

/* The reserves are always computed by the default method, whatever solved the grasp. Of a grasp that does not hold they
 * say what is missing. Returns false when memory runs out. */
static bool find_limits(const options *o, solution *x, pinch_statics *statics)
{
    const pinch_static_limit none = {NAN, NAN, PINCH_SOLVE_CONVERGED};
    x->limits = (pinch_static_limits){none, none};
    x->least_closing = none;
    x->searched = !x->settings.faithful && !o->no_reserves;
    if (!x->searched) return true;
    pinch_statics_settings settings = x->settings;
    settings.solver.solver = PINCH_SOLVER_NSNMGK;
    settings.solver.newton_finish = true;
    if (o->directions && grasp_directions_find(statics, &x->grasp, &settings, force_of_load(x), &x->directions))
        return false;
    if (pinch_statics_limits(statics, &x->grasp, &settings, &x->limits) == PINCH_OUT_OF_MEMORY ||
        pinch_statics_least_closing(statics, &x->grasp, &settings, &x->least_closing) == PINCH_OUT_OF_MEMORY)
        return false;
    x->contradicted = reserves_contradict(x);
    if (x->contradicted) {
        x->searched = false;
        x->limits = (pinch_static_limits){none, none};
        x->least_closing = none;
    }
    return true;
}

/* The qualities are of the contacts alone, whether or not the load is held. Returns false when memory runs out. */
static bool find_quality(const options *o, solution *x)
{
    grasp_quality_settings settings = grasp_quality_default_settings();
    grasp_quality_status status =
        o->no_reserves ? GRASP_QUALITY_FAILED : grasp_quality_find(&x->grasp, &settings, &x->quality);
    if (status != GRASP_QUALITY_FAILED) return status == GRASP_QUALITY_FINE;
    x->quality = (grasp_quality){.faces = settings.faces, .epsilon = NAN, .epsilon_upper = NAN, .volume = NAN};
    for (int j = 0; j < WRENCH_MOST; j++) x->quality.weakest[j] = NAN;
    return true;
}

static command_status present(const options *o, const solution *x)
{
    if (large_displacement(x) && !o->quiet) command_error("solve", "%s: %s", x->s->name, large_displacement(x));
    if (o->json) {
        if (!json_print_new(solution_document(x), stdout)) return COMMAND_SYSTEM;
    } else if (!o->quiet) {
        print_table(x, stdout);
    }
    /* the paper's own procedure may end with less than the verification asks for */
    bool done = x->result.solve.status == PINCH_SOLVE_CONVERGED && x->result.verification.passed;
    return done ? COMMAND_DONE : COMMAND_FAILED;
}

static command_status solve(const options *o, solution *x)
{
    pinch_statics *statics;
    bool needs_lcp = x->settings.formulation == PINCH_FORMULATION_LCP &&
                     (x->settings.faithful || x->settings.solver.solver != PINCH_SOLVER_NSNMGK || o->no_newton);
    int faces = !needs_lcp ? 0 : x->grasp.planar ? 3 : x->settings.faces;
    if (pinch_statics_create(x->grasp.finger_count, faces, &statics) != PINCH_OK) {
        command_error("solve", "not enough memory for %d fingers with %d faces", x->grasp.finger_count, faces);
        return COMMAND_SYSTEM;
    }
    double start = clock_seconds();
    pinch_status status = pinch_statics_solve(statics, &x->grasp, &x->settings, x->finger_results, &x->result);
    x->time = clock_seconds() - start;
    if (status == PINCH_OK && !(find_limits(o, x, statics) && find_quality(o, x))) status = PINCH_OUT_OF_MEMORY;
    pinch_statics_destroy(statics);
    if (status != PINCH_OK) {
        command_error("solve", "%s: %s", x->s->file,
                      status == PINCH_UNSUPPORTED ? "--faithful is for formulation lcp" : pinch_status_text(status));
        return status == PINCH_OUT_OF_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
    }
    return present(o, x);
}

/* The time for which to solve; NaN for the schedule's first entry. */
static command_status choose_moment(const options *o, const scene *s, double *moment)
{
    *moment = o->at_end ? s->duration : o->given[OPTION_TIME] ? o->time : NAN;
    if (o->at_end && o->given[OPTION_TIME]) {
        command_error("solve", "--time and --at-end: expected one of them");
        return COMMAND_BAD_INPUT;
    }
    const scene_finger *moved = isnan(*moment) || s->hand_count > 0 ? NULL : scene_finger_on_path(s, *moment);
    if (!moved) return COMMAND_DONE;
    command_error("solve", "%s: finger %s has been moved along its path at %g s, so that the grasp is another; use run",
                  s->file, moved->name, *moment);
    return COMMAND_BAD_INPUT;
}

static command_status solve_scene(const options *o, const scene *s)
{
    command_status status = command_check_statics("solve", s);
    if (status != COMMAND_DONE) return status;
    solution x = {.s = s, .settings = settings_of(o, s), .moment = NAN};
    status = choose_moment(o, s, &x.moment);
    if (status != COMMAND_DONE) return status;
    if (s->hand_count > 0) return solve_with_hands(o, s, x.moment);
    x.fingers = calloc(s->finger_count, sizeof *x.fingers);
    x.finger_results = calloc(s->finger_count, sizeof *x.finger_results);
    status = COMMAND_SYSTEM;
    if (x.fingers && x.finger_results) {
        if (isnan(x.moment))
            scene_static_grasp(s, x.fingers, &x.grasp);
        else
            scene_static_grasp_at(s, x.moment, x.fingers, &x.grasp);
        status = solve(o, &x);
    } else {
        command_error("solve", "out of memory");
    }
    free(x.fingers);
    free(x.finger_results);
    return status;
}

static command_status run_solve(const options *o)
{
    scene *s;
    command_status status = command_load_scene(o, o->arguments[0], &s);
    if (status != COMMAND_DONE) return status;
    /* --faithful uses the paper's linearized cone, unless the command line asks for another. */
    if (o->faithful && !o->given[OPTION_FORMULATION]) s->solver.formulation = SCENE_LCP;
    status = solve_scene(o, s);
    scene_free(s);
    return status;
}

static const option_id solve_options[] = {
    OPTION_SOLVER,    OPTION_FORMULATION, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_FACES,      OPTION_SEED,
    OPTION_NO_NEWTON, OPTION_FAITHFUL,    OPTION_UNIT,      OPTION_ONE_STEP,       OPTION_INSCRIBED,  OPTION_JSON,
    OPTION_QUIET,     OPTION_TIME,        OPTION_AT_END,    OPTION_NO_RESERVES,    OPTION_DIRECTIONS, OPTION_COUNT};

const command command_solve = {
    .name = "solve",
    .arguments = "SCENE",
    .summary = "solves the static grasp: forces, displacements, slip, and the reserves of friction, load and grip",
    .notes = COMMAND_SCENE_NOTE,
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "json",
    .options = solve_options,
    .run = run_solve,
};
