/*
 * Follows the load path of the exact cone: closing first, then the wrench, in load steps as long as the tolerance
 * allows, with slip carried from step to step (return mapping). Where the path comes to an end, the object is let go.
 */
#include "statics/flow.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* One phase of the load path: closing, or the wrench. */
typedef struct phase {
    pinch_static_model *model;
    pinch_solver_settings solver;
    double tolerance; /* of the tangential springs' forces, per load step; INFINITY: whatever a step gives */
    double *factor;   /* the model's closing or wrench factor, taken from 0 to 1 */
    double *u, *rate; /* rate: of u along the phase, from the last step */
    double *direction;
    pinch_solver_result *total;
} phase;

static const size_t REST_SIZE = 3 * sizeof(double);

/* save_rest and restore_rest put the contacts' rest aside and bring it back. */
static void save_rest(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].saved, model->contacts[c].rest, REST_SIZE);
}

static void restore_rest(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].rest, model->contacts[c].saved, REST_SIZE);
}

/*
 * A load step is no jump: an equilibrium further away than ten thousand times what the softest spring gives under the
 * added load is another one than the path leads to.
 */
static bool follow(const phase *p, double part, const double *start, double *at)
{
    const double far = 1e4;
    double softest, stiffest, away = 0.0;
    pinch_static_stiffness_range(p->model, &softest, &stiffest);
    bool found = pinch_static_follow(p->model, &p->solver, start, at, p->total);
    for (int j = 0; j < p->model->freedoms; j++) away = hypot(away, at[j] - start[j]);
    return found && softest * away <= far * part;
}

/*
 * Finds the equilibrium at `next` with the state at `done` in u. It starts where the last step's motion would lead,
 * which keeps to the branch that the path is on, or else from u itself.
 */
static bool settle_at(const phase *p, double done, double next, double *u)
{
    double at[6];
    *p->factor = next;
    for (int j = 0; j < 6; j++) at[j] = u[j] + p->rate[j] * (next - done);
    bool settled = follow(p, next - done, u, at);
    if (!settled) {
        memcpy(at, u, sizeof at);
        settled = follow(p, next - done, u, at);
    }
    if (settled) memcpy(u, at, sizeof at);
    return settled;
}

/* Returns by how much the springs' forces differ between the rest now and `coarse`; torsion counts over its lever. */
static double coarse_error(const pinch_static_model *model)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        for (int i = 1; i < contact->rows; i++)
            worst = fmax(worst, contact->k[i] * fabs(contact->rest[i - 1] - contact->coarse[i - 1]));
    }
    return worst;
}

/* Returns by how much the springs' forces s exceed what friction r can be. */
static double excess(const double s[4], const double r[4])
{
    const double over[3] = {s[1] - r[1], s[2] - r[2], s[3] - r[3]};
    return pinch_v3_norm(over);
}

/* Notes at the middle of a step, before its slip is committed, how every contact is. */
static void note_middle(pinch_static_model *model, const double *middle)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        pinch_static_trial(model, contact, middle, s);
        bool open = pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN;
        contact->gap = open && !contact->controlled ? -s[0] : 0.0;
        contact->stuck = !open && excess(s, r) == 0.0;
        memcpy(contact->onset, r + 1, sizeof contact->onset);
    }
}

/* Estimates what the force's turn since the middle changes in a slip that began after it and has the end's direction.
 */
static double turning_error(const pinch_static_contact *contact, const double s[4], const double r[4])
{
    double before = pinch_v3_norm(contact->onset), after = pinch_v3_norm(r + 1), turn[3];
    for (int i = 0; i < 3; i++)
        turn[i] = (after > 0.0 ? r[i + 1] / after : 0.0) - (before > 0.0 ? contact->onset[i] / before : 0.0);
    return 0.5 * excess(s, r) * pinch_v3_norm(turn);
}

/* A contact that closes after the middle pulls from where it was then, not from where it touched. */
static double touching_error(const pinch_static_model *model, const pinch_static_contact *contact, const double s[4],
                             const double r[4])
{
    double part = s[0] / (s[0] + contact->gap), touched[4] = {s[0], part * s[1], part * s[2], part * s[3]}, other[4];
    pinch_static_law(model, contact, touched, other, NULL);
    const double wrong[3] = {other[1] - r[1], other[2] - r[2], other[3] - r[3]};
    return pinch_v3_norm(wrong);
}

/* Notes at the start of a step how far open every contact is. */
static void note_start(pinch_static_model *model, const double *start)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        pinch_static_trial(model, contact, start, s);
        bool open = pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN;
        contact->gap = open && !contact->controlled ? -s[0] : 0.0;
    }
}

/* Estimates what neither the one step nor the halves see of contacts that close in the first half. */
static double closing_error(const pinch_static_model *model, const double *middle)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        if (contact->rows == 1 || contact->gap == 0.0) continue;
        pinch_static_trial(model, contact, middle, s);
        if (pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN) continue;
        worst = fmax(worst, touching_error(model, contact, s, r));
    }
    return worst;
}

/*
 * A contact that sticks or is open in the first half of a step and slips in the second may end up the same after the
 * one step and after the two halves. What neither sees is estimated from the state in the middle.
 */
static double unseen_error(const pinch_static_model *model, const double *end)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        if (contact->rows == 1 || (!contact->stuck && contact->gap == 0.0)) continue;
        pinch_static_trial(model, contact, end, s);
        if (pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN) continue;
        worst = fmax(worst, contact->stuck ? turning_error(contact, s, r) : touching_error(model, contact, s, r));
    }
    return worst;
}

/*
 * The slip of one step of backward Euler is wrong by c h^2 per step, that of two half steps by half as much: their
 * difference is the error of the better one, and adding it once more cancels it. What is reported at the end of a phase
 * is not extrapolated, so that it obeys the friction law to rounding.
 */
static void extrapolate(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        if (contact->open || contact->coarse_open) continue; /* no slip there: rest follows the object */
        for (int i = 0; i < 3; i++) contact->rest[i] += contact->rest[i] - contact->coarse[i];
    }
}

/* Keeps the rest after the step at once, to be compared with that of the halves, and goes back to the start. */
static void put_aside_coarse(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) {
        memcpy(model->contacts[c].coarse, model->contacts[c].rest, REST_SIZE);
        model->contacts[c].coarse_open = model->contacts[c].open;
    }
    restore_rest(model);
}

/* Takes the two halves: u at the middle and at the end, with the end's slip committed. */
static bool take_halves(const phase *p, double done, double next, double *middle, double *end, double *unseen)
{
    double half = 0.5 * (done + next);
    memcpy(middle, p->u, 6 * sizeof *middle);
    *p->factor = done;
    note_start(p->model, middle);
    if (!settle_at(p, done, half, middle)) return false;
    *unseen = closing_error(p->model, middle);
    note_middle(p->model, middle);
    pinch_static_commit(p->model, middle);
    memcpy(end, middle, 6 * sizeof *end);
    if (!settle_at(p, half, next, end)) return false;
    *unseen = fmax(*unseen, unseen_error(p->model, end));
    pinch_static_commit(p->model, end);
    return true;
}

/*
 * Takes one load step of the factor from `done` to `next`, at once and in two halves. Where it returns true, u and rest
 * are those of the halves, with the slip of the second half committed and extrapolated unless `last`. Where it returns
 * false, the step was too long and nothing has changed. *error estimates the slip's error as a force; it is 0 where
 * Newton's method failed already.
 */
static bool load_step(const phase *p, double done, double next, bool last, double *error)
{
    pinch_static_model *model = p->model;
    double coarse[6], middle[6], end[6], unseen;
    *error = 0.0;
    memcpy(coarse, p->u, sizeof coarse);
    if (!settle_at(p, done, next, coarse)) return false;
    if (!(p->tolerance < INFINITY)) {
        memcpy(p->u, coarse, sizeof coarse);
        if (!last) pinch_static_commit(model, p->u);
        return true;
    }
    save_rest(model);
    pinch_static_commit(model, coarse);
    put_aside_coarse(model);
    if (!take_halves(p, done, next, middle, end, &unseen)) {
        restore_rest(model);
        return false;
    }
    *error = fmax(coarse_error(model), unseen);
    if (*error > p->tolerance) {
        restore_rest(model);
        return false;
    }
    memcpy(p->u, end, sizeof end);
    if (!last) {
        extrapolate(model);
        return true;
    }
    /* the caller wants the rest before the last half: found again from the start and the middle's u */
    restore_rest(model);
    *p->factor = 0.5 * (done + next);
    pinch_static_commit(model, middle);
    *p->factor = next;
    return true;
}

/*
 * Lets the object go where even the shortest step finds no equilibrium next to the last one. It moves as it would under
 * the load that goes on growing, slowly, and where it comes to rest the path goes on. How it moves is not the statics'
 * to say: only what escapes both swinging and creeping has escaped. Where neither motion can be followed, viscous flows
 * decide. *next says where the load has got to.
 */
static pinch_flow_outcome let_go(const phase *p, double done, double *next)
{
    enum { MOTIONS = 2, FLOWS = 4 };
    static const double MASS[MOTIONS] = {0.1, 10.0}, SHRINK[FLOWS] = {0.8, 0.5, 0.8, 0.25};
    const pinch_static_ramp ramp = {p->factor, 1.0, 1.0 / 6000.0, false};
    pinch_static_model *model = p->model;
    double at[6], way[6];
    pinch_flow_outcome outcome = PINCH_FLOW_UNDECIDED, one = PINCH_FLOW_UNDECIDED;
    save_rest(model);
    for (int i = 0; i < MOTIONS && one != PINCH_FLOW_SETTLED; i++) {
        restore_rest(model);
        memcpy(at, p->u, sizeof at);
        *p->factor = done;
        one = pinch_static_motion(model, &p->solver, &ramp, MASS[i], at, way, p->total);
        if (one == PINCH_FLOW_ESCAPED && outcome != one)
            memcpy(p->direction, way, (size_t)model->freedoms * sizeof *way);
        if (one != PINCH_FLOW_UNDECIDED) outcome = one;
    }
    if (outcome == PINCH_FLOW_SETTLED) {
        p->total->by_flow = true;
        *next = *p->factor;
    }
    *p->factor = *next;
    for (int i = 0; i < FLOWS && outcome == PINCH_FLOW_UNDECIDED; i++) {
        restore_rest(model);
        memcpy(at, p->u, sizeof at);
        outcome = pinch_static_flow(model, &p->solver, i == 0, SHRINK[i], at, p->direction, p->total);
    }
    if (outcome == PINCH_FLOW_SETTLED)
        memcpy(p->u, at, sizeof at);
    else
        restore_rest(model);
    return outcome;
}

/*
 * From nothing all loads grow in proportion, and so may the answer: with every force's direction at rest, the slip of
 * the whole way is that of one step from the undeformed state. That state is the path's own, to rounding, if what the
 * object does first leads to it; the slip left behind on the way there would fade only as fast as the load grows.
 */
static bool start_on_ray(const phase *p, double *u)
{
    const double near = 0.1;
    pinch_static_model *model = p->model;
    double at[6], away = 0.0, size = 0.0;
    save_rest(model);
    for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, REST_SIZE);
    memcpy(at, u, sizeof at);
    bool found = pinch_static_newton(model, &p->solver, PINCH_STATIC_LOAD_NEWTON_STEPS, at, p->total);
    for (int j = 0; j < model->freedoms; j++) {
        away = fmax(away, fabs(at[j] - u[j]));
        size = fmax(size, fabs(u[j]));
    }
    found = found && away <= near * size;
    if (found)
        memcpy(u, at, sizeof at);
    else
        restore_rest(model);
    pinch_static_commit(model, u);
    return found;
}

/* Does any finger press at u, by more than what is next to nothing of the load? */
static bool is_held(const pinch_static_model *model, const double *u, double load)
{
    const double next_to_nothing = 1e-6;
    for (int c = 0; c < model->count; c++) {
        double s[4], r[4];
        pinch_static_trial(model, &model->contacts[c], u, s);
        (void)pinch_static_law(model, &model->contacts[c], s, r, NULL);
        if (r[0] > next_to_nothing * load) return true;
    }
    return false;
}

/* Puts the object where it was before any load, undeformed. */
static void go_back_to_nothing(const phase *p, double *u)
{
    memset(u, 0, 6 * sizeof *u);
    for (int c = 0; c < p->model->count; c++) memset(p->model->contacts[c].rest, 0, REST_SIZE);
}

/* How the first part of a load may come. */
typedef enum start_way {
    START_SWINGING, /* the object is heavy: it swings about where the load takes it */
    START_CREEPING, /* it is light, and goes there */
    START_IN_HONEY, /* the load is there at once */
    START_IN_A_STEP,
    START_WAYS
} start_way;

/* Brings the load to `part` one way, from nothing. Returns whether the object has come to rest at u. */
static bool start_one_way(const phase *p, start_way way, double part, double *u)
{
    static const double MASS[] = {[START_SWINGING] = 10.0, [START_CREEPING] = 0.1};
    const pinch_static_ramp ramp = {p->factor, part, 1.0 / 300.0, true};
    double direction[6];
    go_back_to_nothing(p, u);
    *p->factor = way <= START_CREEPING ? 0.0 : part;
    switch (way) {
    case START_IN_HONEY:
        return pinch_static_settle(p->model, &p->solver, u, p->total);
    case START_IN_A_STEP:
        return pinch_static_newton(p->model, &p->solver, PINCH_STATIC_LOAD_NEWTON_STEPS, u, p->total);
    default:
        return pinch_static_motion(p->model, &p->solver, &ramp, MASS[way], u, direction, p->total) ==
               PINCH_FLOW_SETTLED;
    }
}

/*
 * All forces grow from zero in proportion, so what the object does first decides which of several equilibria is
 * followed. It is set in motion by a load that grows from nothing to `part` of the goal and slides to rest there. Where
 * that does not end, or the object has come off all fingers and stays beside them, which is an equilibrium in any case,
 * it is brought there in calmer ways. Returns the part reached, 0 for none; *step: how far to go on.
 */
static double start_from_nothing(const phase *p, double part, double *step)
{
    double at[6];
    int free_of_all = -1; /* the first way on which it has come to rest beside the fingers */
    bool held = false;
    for (int way = 0; way < START_WAYS && !held; way++) {
        if (!start_one_way(p, (start_way)way, part, at)) continue;
        held = is_held(p->model, at, part);
        if (!held && free_of_all < 0) free_of_all = way;
    }
    bool settled = held || (free_of_all >= 0 && start_one_way(p, (start_way)free_of_all, part, at));
    if (!settled) {
        go_back_to_nothing(p, p->u);
        return 0.0;
    }
    bool on_ray = start_on_ray(p, at);
    for (int j = 0; j < 6 && on_ray; j++) p->rate[j] = (at[j] - p->u[j]) / part;
    *step = on_ray ? 4.0 * part : 0.25 * part;
    memcpy(p->u, at, sizeof at);
    return part;
}

/* Returns the next length of a step that was wrong by `error`. */
static double fit_step(const phase *p, double step, double error, double least, double most)
{
    double growth = error > 0.0 ? 0.9 * sqrt(p->tolerance / error) : most;
    return step * fmin(fmax(growth, least), most);
}

/* Takes the phase's factor from 0 to 1 in at least `steps` steps. *reached says how far it got. */
static pinch_flow_outcome load(const phase *p, int steps, bool from_nothing, double *reached)
{
    /* the shortest step: there a failed Newton means a limit point, and slip that still changes from halving to halving
     * is taken as it comes */
    const double first_step = 1e-3, finest = 1e-6;
    double longest = 1.0 / steps, step = longest, done = 0.0, error, before[6];
    memset(p->rate, 0, 6 * sizeof *p->rate);
    if (from_nothing) done = start_from_nothing(p, first_step, &step);
    *reached = done;
    while (done < 1.0) {
        double next = done + step >= 1.0 - finest ? 1.0 : done + step;
        memcpy(before, p->u, sizeof before);
        phase attempt = *p;
        if (step <= finest) attempt.tolerance = INFINITY;
        if (load_step(&attempt, done, next, next == 1.0, &error)) {
            for (int j = 0; j < 6; j++) p->rate[j] = (p->u[j] - before[j]) / (next - done);
            *reached = done = next;
            step = fmin(fit_step(p, step, error, 0.25, 4.0), longest);
            continue;
        }
        if (error > p->tolerance) {
            step = fmax(fit_step(p, step, error, 0.1, 0.5), finest);
            continue;
        }
        if (step > finest) {
            step = fmax(0.25 * step, finest);
            continue;
        }
        if (p->model->work_left <= 0) return PINCH_FLOW_UNDECIDED;
        pinch_flow_outcome outcome = let_go(p, done, &next);
        if (outcome != PINCH_FLOW_SETTLED) return outcome;
        memset(p->rate, 0, 6 * sizeof *p->rate); /* a jump leads nowhere further */
        *reached = done = next;
        if (done < 1.0) pinch_static_commit(p->model, p->u);
    }
    return PINCH_FLOW_SETTLED;
}

static bool has_wrench(const pinch_static_model *model)
{
    for (int j = 0; j < model->freedoms; j++)
        if (model->wrench[j] != 0.0) return true;
    return false;
}

static bool has_closing(const pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++)
        if (model->contacts[c].controlled ? model->contacts[c].normal_force > 0.0 : model->contacts[c].closing != 0.0)
            return true;
    return false;
}

pinch_flow_outcome pinch_static_path(pinch_static_model *model, const pinch_statics_settings *settings, double *u,
                                     double *fraction, double *direction, pinch_solver_result *total)
{
    double rate[6];
    phase p = {.model = model,
               .solver = settings->solver,
               .tolerance = settings->path_tolerance,
               .u = u,
               .rate = rate,
               .direction = direction,
               .total = total};
    /* between load steps the tolerance is enough; the last state is refined by the caller */
    p.solver.tolerance = fmax(settings->solver.tolerance, 1e-10);
    p.solver.goal = p.solver.tolerance;
    memset(u, 0, 6 * sizeof *u);
    for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, REST_SIZE);
    model->closing_factor = 1.0;
    model->wrench_factor = 0.0;
    *fraction = 0.0;
    if (has_closing(model)) {
        double closed;
        p.factor = &model->closing_factor;
        pinch_flow_outcome outcome = load(&p, settings->path_steps, true, &closed);
        if (outcome != PINCH_FLOW_SETTLED) return outcome;
        pinch_static_commit(model, u);
    }
    p.factor = &model->wrench_factor;
    return load(&p, has_wrench(model) ? settings->path_steps : 1, !has_closing(model), fraction);
}

bool pinch_static_uses_displacements(const pinch_statics_settings *settings)
{
    if (settings->formulation == PINCH_FORMULATION_COULOMB) return true;
    return settings->solver.solver == PINCH_SOLVER_NSNMGK && settings->solver.newton_finish && !settings->faithful;
}

pinch_flow_outcome pinch_static_search(pinch_static_model *model, const pinch_statics_settings *settings, bool thorough,
                                       double *u, double *fraction, double *escape, pinch_solver_result *total)
{
    bool path = settings->formulation == PINCH_FORMULATION_COULOMB && !settings->one_step;
    pinch_flow_outcome outcome;
    if (path) {
        outcome = pinch_static_path(model, settings, u, fraction, escape, total);
    } else {
        model->closing_factor = 1.0;
        model->wrench_factor = 1.0;
        outcome = pinch_static_one_step(model, &settings->solver, u, thorough, escape, total);
        *fraction = outcome == PINCH_FLOW_SETTLED ? 1.0 : NAN;
    }
    /* what has escaped one way might have settled another that was not tried to its end */
    if (outcome == PINCH_FLOW_ESCAPED && model->work_left <= 0) outcome = PINCH_FLOW_UNDECIDED;
    return outcome;
}
