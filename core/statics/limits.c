/* Finds how much friction, load and grip are in reserve, by a search for the factor where the grasp ceases to hold. */
#include "statics/feasibility.h"
#include "statics/flow.h"
#include "statics/results.h"
#include "statics/workspace.h"

#include <math.h>

static const double PRECISION = 1e-6; /* relative, of the factors found */
static const double MOST_FRICTION = 1000.0, MOST_LOAD = 1e6, MOST_GRIP = 1e6;

typedef enum verdict {
    HOLDS,    /* converged, and verified */
    FAILS,    /* no forces balance, or the object escapes */
    UNDECIDED /* neither within the work allowed, or not verified */
} verdict;

/* What the factor is on. */
typedef enum subject { FRICTION, LOAD, GRIP } subject;

/* One of the searches. */
typedef struct question {
    pinch_statics *statics;
    const pinch_grasp *grasp;
    const pinch_statics_settings *settings;
    subject subject;
    long work;      /* solver iterations left for the whole search */
    long work_once; /* and allowed for one factor */
    double good;    /* nearest to the limit of what was seen to hold */
    double bad;     /* and on its other side, of what was not */
    double fails;   /* of that, what certainly fails; NaN: nothing yet */
    double guess;   /* where the limit may be; NaN: nothing is known */
    double part;    /* how much of the wrench the last failure reached; 0: unknown */
    double where;   /* and with which factor */
} question;

static pinch_finger scaled_finger(const pinch_finger *finger, subject what, double factor)
{
    pinch_finger scaled = *finger;
    if (what == FRICTION) {
        scaled.friction *= factor;
        scaled.torsional_friction *= factor;
    } else if (what == GRIP) {
        scaled.closing *= factor;
        scaled.normal_force *= factor;
    }
    return scaled;
}

/* Returns the grasp with its friction, its wrench or its grip scaled, as if it had come that way. */
static pinch_grasp scaled_grasp(const question *q, double factor)
{
    pinch_grasp scaled = *q->grasp;
    for (int i = 0; i < scaled.finger_count; i++)
        q->statics->scaled[i] = scaled_finger(&q->grasp->fingers[i], q->subject, factor);
    scaled.fingers = q->statics->scaled;
    for (int j = 0; j < 6 && q->subject == LOAD; j++) scaled.wrench[j] *= factor;
    return scaled;
}

/* Is the state at u an answer by the measure of every other answer? */
static bool is_verified(question *q, pinch_static_model *model, const pinch_grasp *grasp, const double *u)
{
    pinch_double_double exact[6];
    pinch_statics_result result = {0};
    for (int j = 0; j < 6; j++) exact[j] = (pinch_double_double){u[j], 0};
    model->alpha = 0.0;
    pinch_static_refine(model, exact, PINCH_STATIC_REFINEMENTS);
    pinch_static_recover(model, grasp, exact, q->statics->results, &result);
    pinch_statics_verify(grasp, q->settings, q->statics->results, &result, &result.verification);
    return result.verification.passed;
}

/* *part: of the wrench that the path carried where the grasp does not hold; 0 where that is not known. */
static verdict solve(question *q, double factor, double *part)
{
    pinch_grasp grasp = scaled_grasp(q, factor);
    pinch_static_model model;
    pinch_solver_result uncounted = {0};
    double u[6] = {0}, escape[6], twist[6], reached = 0.0;
    *part = 0.0;
    pinch_static_model_build(&model, q->statics->contacts, &grasp, q->settings, false);
    /* a proof costs less than any path */
    if (pinch_static_feasibility(&model, &grasp, q->settings, twist) == PINCH_INFEASIBLE) return FAILS;
    long allowed = q->work < q->work_once ? q->work : q->work_once;
    model.work_left = allowed;
    pinch_flow_outcome outcome = pinch_static_search(&model, q->settings, false, u, &reached, escape, &uncounted);
    q->work -= allowed - model.work_left;
    if (outcome == PINCH_FLOW_SETTLED) return is_verified(q, &model, &grasp, u) ? HOLDS : UNDECIDED;
    if (reached > 0.0 && reached < 1.0) *part = reached;
    return outcome == PINCH_FLOW_ESCAPED ? FAILS : UNDECIDED;
}

/*
 * Where the path ended tells where the limit is. With the factor on the wrench it is that part of the factor tried.
 * With the factor on the grip it is the factor over that part: without force limits all forces scale with grip and
 * wrench. With the factor on friction the part nears 1 with the factor: along the line through the last two where two
 * are known, and in proportion, friction against load, where one is.
 */
static void guess_from(question *q, double factor, double part)
{
    if (q->subject != FRICTION) {
        q->guess = q->subject == LOAD ? factor * part : factor / part;
        return;
    }
    double slope = (part - q->part) / (factor - q->where);
    q->guess = q->part > 0.0 && slope > 0.0 ? factor + (1.0 - part) / slope : factor / part;
    q->part = part;
    q->where = factor;
}

static verdict ask(question *q, double factor);

/* Is the guess where the path that has just failed let the object go, rather than an estimate? */
static bool guess_is_exact(const question *q)
{
    for (int i = 0; i < q->grasp->finger_count && q->subject == GRIP; i++)
        if (isfinite(q->grasp->fingers[i].max_force)) return false;
    return q->subject != FRICTION;
}

static const double ASIDE = 0.4 * PRECISION; /* of a guess: how far from it factors are tried */

/* The factors next to the guess, on the side that holds and on the other. */
static double near_good(const question *q)
{
    return q->subject == LOAD ? q->guess / (1.0 + ASIDE) : q->guess * (1.0 + ASIDE);
}

static double near_bad(const question *q)
{
    return q->subject == LOAD ? q->guess * (1.0 + ASIDE) : q->guess / (1.0 + ASIDE);
}

/*
 * An object that a path has let go may come to rest elsewhere if the load stops growing meanwhile. So a path to a
 * smaller load may end well beyond the load at which one to a larger load ends. The reserve is what the object is held
 * with in either case: the search goes on about the load where it was let go.
 */
static void heed_escape(question *q)
{
    static const double NEAR = 0.05; /* paths in steps of other lengths end within a thousandth of each other */
    bool beyond = q->subject == LOAD ? q->guess < (1.0 - NEAR) * q->good : (1.0 - NEAR) * q->guess > q->good;
    if (!guess_is_exact(q) || !beyond) return;
    double good = q->good, bad = q->bad, fails = q->fails;
    q->good = NAN;
    q->bad = q->fails = near_bad(q);
    if (ask(q, near_good(q)) == HOLDS || ask(q, q->subject == LOAD ? 0.0 : 2.0 * q->guess) == HOLDS) return;
    q->good = good;
    q->bad = bad;
    q->fails = fails;
}

/* Asks about the factor and narrows the bracket. */
static verdict ask(question *q, double factor)
{
    double part;
    verdict answer = solve(q, factor, &part);
    if (answer == HOLDS) {
        q->good = factor;
        return answer;
    }
    q->bad = factor;
    if (answer == FAILS) q->fails = factor;
    if (part > 0.0) guess_from(q, factor, part);
    if (answer == FAILS && part > 0.0) heed_escape(q);
    return answer;
}

static bool within(double a, double b)
{
    return fabs(a - b) <= PRECISION * fmax(a, b);
}

static bool is_between(double x, double a, double b)
{
    return x > fmin(a, b) && x < fmax(a, b);
}

/*
 * Halves the bracket, but for two of three times tries close to the guess first, on the side that holds and then on the
 * other: a guess that is right ends the search.
 */
static void narrow(question *q)
{
    enum { MOST = 200 }; /* a limit at next to nothing has no relative precision to come to */
    for (int i = 0; i < MOST && q->work > 0 && !within(q->good, q->bad); i++) {
        double next = 0.5 * (q->good + q->bad);
        if (i % 3 < 2 && is_between(near_good(q), q->good, q->bad))
            next = near_good(q);
        else if (i % 3 < 2 && is_between(near_bad(q), q->good, q->bad))
            next = near_bad(q);
        ask(q, next);
    }
}

static pinch_static_limit answer_of(const question *q)
{
    bool found = isnan(q->good) ? q->bad == q->fails : within(q->good, q->fails);
    return (pinch_static_limit){q->good, q->fails, found ? PINCH_SOLVE_CONVERGED : PINCH_SOLVE_MAX_ITERATIONS};
}

static question pose(pinch_statics *statics, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                     subject what)
{
    /* iterations times fingers, about a second; many fingers get as many iterations as a path needs all the same */
    const long work = 2500000, least = 20000, paths = 5;
    question q = {statics, grasp, settings, .subject = what, .good = NAN, .bad = NAN, .fails = NAN, .guess = NAN};
    q.work = work / grasp->finger_count > least ? work / grasp->finger_count : least;
    q.work_once = q.work / paths;
    return q;
}

static bool has_friction(const pinch_grasp *grasp)
{
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *f = &grasp->fingers[i];
        if (f->model != PINCH_CONTACT_FRICTIONLESS && f->friction > 0.0) return true;
        if (f->model == PINCH_CONTACT_SOFT && !grasp->planar && f->torsional_friction > 0.0) return true;
    }
    return false;
}

static bool has_grip(const pinch_grasp *grasp)
{
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *f = &grasp->fingers[i];
        if (f->force_controlled ? f->normal_force > 0.0 : f->closing != 0.0) return true;
    }
    return false;
}

/* The least factor that holds, of those up to `most`. */
static pinch_static_limit find_smallest(question *q, double most)
{
    if (ask(q, 1.0) == HOLDS) {
        if (ask(q, 0.0) == HOLDS) return (pinch_static_limit){0.0, NAN, PINCH_SOLVE_CONVERGED};
    } else {
        for (double factor = 1.0; isnan(q->good);) {
            if (factor >= most || q->work <= 0) return answer_of(q);
            factor = fmin(2.0 * factor, most);
            ask(q, factor);
        }
    }
    narrow(q);
    return answer_of(q);
}

static pinch_static_limit find_smallest_friction(question *q)
{
    return has_friction(q->grasp) ? find_smallest(q, MOST_FRICTION)
                                  : (pinch_static_limit){NAN, NAN, PINCH_SOLVE_CONVERGED};
}

static pinch_static_limit find_least_grip(question *q)
{
    return has_grip(q->grasp) ? find_smallest(q, MOST_GRIP) : (pinch_static_limit){NAN, NAN, PINCH_SOLVE_CONVERGED};
}

static pinch_static_limit find_largest_load(question *q)
{
    double factor = 1.0;
    if (ask(q, 1.0) != HOLDS) ask(q, 0.0);
    while (isnan(q->bad) && factor < MOST_LOAD) {
        factor = fmin(2.0 * factor, MOST_LOAD);
        ask(q, factor);
    }
    if (isnan(q->bad)) return (pinch_static_limit){INFINITY, NAN, PINCH_SOLVE_CONVERGED};
    if (!isnan(q->good)) narrow(q);
    return answer_of(q);
}

static pinch_status check(const pinch_statics *statics, const pinch_grasp *grasp,
                          const pinch_statics_settings *settings)
{
    pinch_status status = pinch_static_validate(statics, grasp, settings);
    if (status == PINCH_OK) status = pinch_static_validate_method(statics, grasp, settings);
    if (status != PINCH_OK) return status;
    return pinch_static_uses_displacements(settings) ? PINCH_OK : PINCH_UNSUPPORTED;
}

pinch_status pinch_statics_limits(pinch_statics *statics, const pinch_grasp *grasp,
                                  const pinch_statics_settings *settings, pinch_static_limits *limits)
{
    const pinch_static_limit unknown = {NAN, NAN, PINCH_SOLVE_MAX_ITERATIONS};
    if (!limits) return PINCH_INVALID_ARGUMENT;
    *limits = (pinch_static_limits){unknown, unknown};
    pinch_status status = check(statics, grasp, settings);
    if (status != PINCH_OK) return status;
    question friction = pose(statics, grasp, settings, FRICTION), load = pose(statics, grasp, settings, LOAD);
    limits->smallest_friction = find_smallest_friction(&friction);
    limits->largest_load_factor = find_largest_load(&load);
    return PINCH_OK;
}

pinch_status pinch_statics_least_closing(pinch_statics *statics, const pinch_grasp *grasp,
                                         const pinch_statics_settings *settings, pinch_static_limit *least)
{
    if (!least) return PINCH_INVALID_ARGUMENT;
    *least = (pinch_static_limit){NAN, NAN, PINCH_SOLVE_MAX_ITERATIONS};
    pinch_status status = check(statics, grasp, settings);
    if (status != PINCH_OK) return status;
    question grip = pose(statics, grasp, settings, GRIP);
    *least = find_least_grip(&grip);
    return PINCH_OK;
}
